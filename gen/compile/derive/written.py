"""Arithmetic as a formula has it: each operation rounds once, in the order that is written.

What stands below a jump (floor, mod, a comparison) decides on a side, and one rounding may decide otherwise: i/n is 1 at i = n, i*(1/n)
need not be. sympy would rearrange it, lowering would keep 1/n. So it is built of functions that nothing looks into.
"""
from __future__ import annotations

import operator

import sympy as sp


class Operation(sp.Function):
    """An operation on real numbers, folded where all of them are known. Nothing differentiates what a jump looks at."""
    is_real = True

    @classmethod
    def eval(cls, *args):
        return folded(cls.compute, *args)

    def _eval_derivative(self, s):
        return sp.S.Zero


class plus(Operation):
    compute = staticmethod(operator.add)


class minus(Operation):
    compute = staticmethod(operator.sub)


class times(Operation):
    compute = staticmethod(operator.mul)


class over(Operation):
    compute = staticmethod(operator.truediv)

    @classmethod
    def eval(cls, a, b):
        return sp.nan if b.is_zero else folded(cls.compute, a, b)


class negative(Operation):
    compute = staticmethod(operator.neg)


def folded(compute, *args):
    """The double that comes of numbers; None where not all are known, or where there is none."""
    if not all(a.is_Number and a.is_finite for a in args):
        return None
    try:
        return sp.Float(compute(*map(float, args)))
    except ArithmeticError:
        return sp.nan


def known(e):
    """A number as a double, such as pi/2 or the root of 2; anything else as it is."""
    return sp.Float(float(e)) if e.is_number and not e.is_Number and not e.has(Operation) else e
