"""The printer of extended precision: every operation is a call, so that one text serves long double and pairs of doubles."""
from __future__ import annotations

from fractions import Fraction

import mpmath
import sympy as sp
from sympy.core.sorting import default_sort_key

from ..derive import derivatives as derive
from ..derive import written
from ..lower.code import Component, Constant, Drawn, Entry, Local, Parameter, Real, walk
from ..lower.integers import Int
from .formulas import ATOM, ELEMENTARY, RELATIONS, WRITTEN, Formulas, number, power_of
from .print_scalar import Scalar

_OWN = {derive.absolute: "fabs", sp.Abs: "fabs", derive.signum: "sign", sp.sign: "sign", derive.lesser: "min", derive.greater: "max"}
DIGITS = 40     # decimal places from which a constant is split into a pair


class WideFormulas(Formulas):
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
        way = power_of(exponent)
        if exponent.is_number and exponent.is_negative:
            return f"smg_wide_div(smg_wide_of(1.0), {self(1 / e)})", ATOM
        if way == "root":
            return f"smg_wide_sqrt({self(base)})", ATOM
        if way == "product":
            return f"smg_wide_power({self(base)}, {int(exponent)})", ATOM
        if way == "product and root":
            return f"smg_wide_mul(smg_wide_power({self(base)}, {int(exponent.p // 2)}), smg_wide_sqrt({self(base)}))", ATOM
        return f"smg_wide_pow({self(base)}, {self(exponent)})", ATOM

    def test(self, e) -> str:
        if isinstance(e, sp.core.relational.Relational):
            return f"({self.narrow(e.lhs)} {RELATIONS[type(e)]} {self.narrow(e.rhs)})"
        return super().test(e)

    def call(self, e):
        name = _OWN.get(type(e)) or ELEMENTARY[type(e)]
        if isinstance(e, (derive.floor_, derive.signum, sp.sign)):
            return f"smg_wide_{name}(smg_wide_of({self.narrow(e.args[0])}))", ATOM
        return f"smg_wide_{name}({', '.join(map(self, e.args))})", ATOM

    def operation(self, e):
        return f"smg_wide_of({self.narrow(e)})", ATOM

    def narrow(self, e) -> str:
        """In ordinary precision: a jump is on the side where it is in all other functions of the model."""
        if isinstance(e, written.negative):
            return f"(-{self.narrow(e.args[0])})"
        if isinstance(e, written.Operation):
            return f"({self.narrow(e.args[0])} {WRITTEN[type(e)][0]} {self.narrow(e.args[1])})"
        return number(float(e)) if e.is_Integer or e.is_Float else f"smg_wide_high({self(e)})"


class Wide(Scalar):
    """Numbers of runtime/core/smg_wide.h; what the caller gives in double is exact."""
    formulas, real = WideFormulas, "smg_wide"

    def leaf(self, node):
        if isinstance(node, Component):
            return f"smg_wide_load({node.vector}, {node.axis})", ATOM
        text, strength = super().leaf(node)
        exact = isinstance(node, (Int, Parameter, Constant, Drawn, Entry)) or isinstance(node, Local) and node.exact
        return (f"smg_wide_of({text})", ATOM) if exact else (text, strength)

    def do_add(self, s):
        return [f"smg_wide_into({s.target.vector}, {s.target.axis}, {self(s.value)});"]


def elementary(nodes) -> bool:
    """Does any real number in these trees take a function of runtime/core/smg_wide_math.h?"""
    return any(takes_one(e) for node in nodes for one in walk(node) if isinstance(one, Real) for e in sp.preorder_traversal(one.expr))


def takes_one(e) -> bool:
    if isinstance(e, sp.Pow):
        return power_of(e.exp) == "general"
    return type(e) in ELEMENTARY and type(e) not in _OWN


def pair(e) -> tuple[float, float]:
    """A number as hi + lo, to 106 bits."""
    with mpmath.workdps(DIGITS):
        exact = Fraction(int(e.p), int(e.q)) if e.is_Rational else None
        high = float(exact) if exact is not None else float(e)
        low = float(exact - Fraction(high)) if exact is not None else float(sp.N(e, DIGITS) - sp.Float(high, DIGITS))
    return high, low
