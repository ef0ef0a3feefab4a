"""Step advice: before a run, an estimate of the largest safe h for its start, with the reason.

    advise(spec, "demo").h
"""
from .report import Advice, advice_for, advise

__all__ = ["Advice", "advice_for", "advise"]
