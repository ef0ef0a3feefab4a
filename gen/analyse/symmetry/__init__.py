"""Symbolic conservation: from a spec alone, what is unchanged, what is conserved, what a method keeps.

    report = explain(spec)
    report.words(), report.rotations, report.integrals
"""
from .integrals import Integral
from .report import Report, explain

__all__ = ["Integral", "Report", "explain"]
