"""The printer of extended precision: every operation is a call, so that one text serves long double and pairs of doubles."""
from __future__ import annotations

from fractions import Fraction

import mpmath
import sympy as sp
from sympy.core.sorting import default_sort_key

from ...language.expr import Elem, Idx, Par, Time, Weight
from ..derive import derivatives as derive
from ..lower.cprint import _FUNCTIONS, ATOM, Printer, number
from ..lower.lowering import STEP, Lowering

_OWN = {derive.absolute: "fabs", sp.Abs: "fabs", derive.signum: "sign", derive.lesser: "min", derive.greater: "max"}
DIGITS = 40     # decimal places from which a constant is split into a pair


class WidePrinter(Printer):
    """Expressions as calls of runtime/core/smg_wide.h; names give smg_wide texts."""

    def constant(self, e):
        if e.is_Float or e.is_Rational and Fraction(float(e)) == Fraction(int(e.p), int(e.q)):
            return f"smg_wide_of({number(float(e))})", ATOM
        high, low = pair(e)
        return f"smg_wide_pair({number(high)}, {number(low)})", ATOM

    def add(self, e):
        text = ""
        for term in sorted(e.args, key=default_sort_key):
            negative = bool(text) and term.could_extract_minus_sign()
            value = self(-term if negative else term)
            text = f"smg_wide_{'sub' if negative else 'add'}({text}, {value})" if text else value
        return text, ATOM

    def mul(self, e):
        if e.could_extract_minus_sign():
            return f"smg_wide_neg({self(-e)})", ATOM
        above, below, scale = [], [], None
        for factor in sorted(e.args, key=default_sort_key):
            if factor.is_Number and factor.is_Float or factor.is_Integer:
                scale = factor
            elif factor.is_Pow and factor.exp.is_number and factor.exp.is_negative:
                below.append(1 / factor)
            else:
                above.append(factor)
        text = self.product(above, scale)
        if below:
            text = f"smg_wide_div({text}, {self.product(below, None)})"
        return text, ATOM

    def product(self, factors, scale):
        """The product, a double factor by the cheaper `smg_wide_scale`."""
        if not factors:
            return f"smg_wide_of({number(float(scale if scale is not None else 1))})"
        text = self(factors[0])
        for f in factors[1:]:
            text = f"smg_wide_mul({text}, {self(f)})"
        return text if scale is None else f"smg_wide_scale({number(float(scale))}, {text})"

    def pow(self, e):
        base, exponent = e.args
        if exponent.is_number and exponent.is_negative:
            return f"smg_wide_div(smg_wide_of(1.0), {self(1 / e)})", ATOM
        if exponent == sp.S.Half:
            return f"smg_wide_sqrt({self(base)})", ATOM
        if exponent.is_Integer and exponent <= 8:
            return f"smg_wide_power({self(base)}, {int(exponent)})", ATOM
        if exponent.is_Rational and exponent.q == 2 and exponent.p <= 9:
            return f"smg_wide_mul(smg_wide_power({self(base)}, {int(exponent.p // 2)}), smg_wide_sqrt({self(base)}))", ATOM
        return f"smg_wide_pow({self(base)}, {self(exponent)})", ATOM

    def test(self, e) -> str:
        if isinstance(e, sp.core.relational.Relational) and not isinstance(e.lhs, sp.logic.boolalg.Boolean):
            return self.relation(e, self(e.lhs), self(e.rhs))
        return super().test(e)

    def relation(self, e, a: str, b: str) -> str:
        less = {sp.StrictLessThan: f"smg_wide_less({a}, {b})", sp.StrictGreaterThan: f"smg_wide_less({b}, {a})",
                sp.LessThan: f"!smg_wide_less({b}, {a})", sp.GreaterThan: f"!smg_wide_less({a}, {b})",
                sp.Eq: f"smg_wide_equal({a}, {b})", sp.Ne: f"!smg_wide_equal({a}, {b})"}
        return less[type(e)]

    def call(self, e):
        name = _OWN.get(type(e)) or _FUNCTIONS[type(e)]
        return f"smg_wide_{name}({', '.join(self(a) for a in e.args)})", ATOM


class WideLowering(Lowering):
    """The lowering of the same model in extended precision: its hoisted values are members of `wide`."""
    printer, real, holder = WidePrinter, "smg_wide", "wide"

    def text(self, name: str) -> str:
        """Symbols as smg_wide: what the caller gives in double is exact."""
        node = self.leaves.get(name)
        if node is STEP:
            return "wide->h"
        if isinstance(node, Time):
            self.uses_time = True
            return "wide->t"
        if isinstance(node, (Par, Idx, Weight, Elem)):
            return f"smg_wide_of({super().text(name)})"
        vector, axis = name[:-1], name[-1]
        if axis in "xyz" and vector[:1] == "v" and vector[1:].isdigit():
            return f"smg_wide_load({vector}, {'xyz'.index(axis)})"
        return name


def pair(e) -> tuple[float, float]:
    """A number as hi + lo, to 106 bits."""
    with mpmath.workdps(DIGITS):
        exact = Fraction(int(e.p), int(e.q)) if e.is_Rational else None
        high = float(exact) if exact is not None else float(e)
        low = float(exact - Fraction(high)) if exact is not None else float(sp.N(e, DIGITS) - sp.Float(high, DIGITS))
    return high, low
