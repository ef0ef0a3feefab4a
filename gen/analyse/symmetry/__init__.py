"""Symbolic conservation: from a spec alone, what is unchanged, what is conserved, what a method keeps.

    report = explain(spec)
    report.words(), report.rotations, report.integrals
"""
from importlib import import_module

_HOMES = {"Integral": "integrals", "Report": "report", "explain": "report"}     # imported once they are asked for: they take sympy

__all__ = ["Integral", "Report", "explain"]


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)
