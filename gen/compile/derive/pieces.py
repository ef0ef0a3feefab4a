"""Branches: c ? a : b as a function of our own, differentiated branch by branch.

sympy's Piecewise rewrites its conditions until they change no more, which with some pairs of comparisons never ends, and folds
comparisons of pieces into pieces of comparisons. Here a condition stays as it was written.
"""
from __future__ import annotations

import sympy as sp


class chosen(sp.Function):
    """a where the condition holds, else b."""
    nargs, is_real = 3, True

    @classmethod
    def eval(cls, test, a, b):
        first, second = branch(a, test, 1), branch(b, test, 2)
        if test == sp.true or first == second:
            return first
        if test == sp.false:
            return second
        return cls(test, first, second) if (first, second) != (a, b) else None

    def _eval_derivative(self, s):
        test, a, b = self.args
        return chosen(test, sp.diff(a, s), sp.diff(b, s))


def branch(e, test, side: int):
    """What is left of a branch that asks the same condition once more."""
    return e.args[side] if isinstance(e, chosen) and e.args[0] == test else e
