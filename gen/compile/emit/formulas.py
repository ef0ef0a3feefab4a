"""Formulas: sympy expressions as C, deterministic and exact.

Numbers round-trip; integer powers become products; x^-n becomes a division. The order of sums
and products is sympy's canonical one, so that the same spec gives the same bytes.
"""
from __future__ import annotations

import sympy as sp
from sympy.core.sorting import default_sort_key

from ..derive import derivatives as derive
from ..derive import written

TEST, SUM, PRODUCT, ATOM = range(4)     # binding strength of the printed text

ELEMENTARY = {sp.exp: "exp", sp.log: "log", sp.sin: "sin", sp.cos: "cos", sp.tan: "tan",
              sp.asin: "asin", sp.acos: "acos", sp.atan: "atan", sp.sinh: "sinh",
              sp.cosh: "cosh", sp.tanh: "tanh", sp.atan2: "atan2",
              derive.absolute: "fabs", derive.floor_: "floor", derive.power: "pow"}

WRITTEN = {written.plus: ("+", SUM), written.minus: ("-", SUM), written.times: ("*", PRODUCT), written.over: ("/", PRODUCT)}

_RUNTIME = {derive.lesser: "smg_min", derive.greater: "smg_max"}

RELATIONS = {sp.StrictLessThan: "<", sp.LessThan: "<=", sp.StrictGreaterThan: ">",
              sp.GreaterThan: ">=", sp.Eq: "==", sp.Ne: "!="}


def number(x: float) -> str:
    """A double as a C literal that reads back as the same double."""
    text = repr(float(x))
    return text if any(c in text for c in ".en") else text + ".0"


def power_of(exponent) -> str:
    """How x^exponent is computed (of a negative one, its inverse): by products and roots where they are few."""
    size = -exponent if exponent.is_number and exponent.is_negative else exponent
    if size == sp.S.Half:
        return "root"
    if size.is_Integer and size <= 8:
        return "product"
    return "product and root" if size.is_Rational and size.q == 2 and size.p <= 9 else "general"


class Formulas:
    """`leaf` maps a symbol's name to its text and strength."""

    def __init__(self, leaf):
        self.leaf = leaf

    def __call__(self, e) -> str:
        return self.show(e)[0]

    def inside(self, e, strength: int) -> str:
        text, own = self.show(e)
        return text if own >= strength else f"({text})"

    def show(self, e) -> tuple[str, int]:
        if e.is_Symbol:
            return self.leaf(e.name)
        if e.is_Number or e.is_NumberSymbol:
            return self.constant(e)
        for kind, method in ((sp.Add, self.add), (sp.Mul, self.mul), (sp.Pow, self.pow),
                             (derive.chosen, self.chosen), (written.Operation, self.operation)):
            if isinstance(e, kind):
                return method(e)
        return self.call(e)

    def constant(self, e):
        if e.is_Rational and not e.is_Integer:
            text = f"{e.p}.0/{e.q}.0" if e.q & (e.q - 1) == 0 else f"(smg_real){e.p}.0/{e.q}.0"      # of long doubles, thirds have more digits
            return text, PRODUCT if e > 0 else SUM
        text = number(float(e))
        return text, ATOM if float(e) >= 0 else SUM

    def add(self, e):
        parts = []
        for k, term in enumerate(sorted(e.args, key=default_sort_key)):
            negative = term.could_extract_minus_sign()
            text = self.inside(-term if negative else term, PRODUCT)
            parts.append(("-" if negative else "") + text if k == 0 else
                         (" - " if negative else " + ") + text)
        return "".join(parts), SUM

    def mul(self, e):
        if e.could_extract_minus_sign():
            return "-" + self.inside(-e, PRODUCT), SUM
        above, below = [], []
        for factor in sorted(e.args, key=default_sort_key):
            if factor.is_Pow and factor.exp.is_number and factor.exp.is_negative:
                below.append(1 / factor)
            else:
                above.append(factor)
        top = "*".join(self.inside(f, PRODUCT if k == 0 else ATOM) for k, f in enumerate(above)) or "1.0"
        for f in below:
            top += "/" + self.inside(f, ATOM)
        return top, PRODUCT

    def pow(self, e):
        base, exponent = e.args
        way = power_of(exponent)
        if exponent.is_number and exponent.is_negative:
            return "1.0/" + self.inside(1 / e, ATOM), PRODUCT
        if way == "root":
            return f"SMG_MATH(sqrt)({self(base)})", ATOM
        if way == "product":
            return "*".join([self.inside(base, ATOM)] * int(exponent)), PRODUCT
        if way == "product and root":
            whole = "*".join([self.inside(base, ATOM)] * int(exponent.p // 2))
            return f"{whole}*SMG_MATH(sqrt)({self(base)})", PRODUCT
        return f"SMG_MATH(pow)({self(base)}, {self(exponent)})", ATOM

    def chosen(self, e):
        test, value, other = e.args
        return f"({self.test(test)} ? {self.inside(value, PRODUCT)} : {self.inside(other, PRODUCT)})", ATOM

    def test(self, e) -> str:
        if e in (sp.true, sp.false):
            return "1" if e == sp.true else "0"
        if e.is_Symbol:         # a condition that has a name
            return self.leaf(e.name)[0]
        if isinstance(e, (sp.And, sp.Or)):
            mark = " && " if isinstance(e, sp.And) else " || "
            return "(" + mark.join(self.test(a) for a in sorted(e.args, key=default_sort_key)) + ")"
        if isinstance(e, sp.Not):
            return f"!({self.test(e.args[0])})"
        return f"({self.doubled(e.lhs, SUM)} {RELATIONS[type(e)]} {self.doubled(e.rhs, SUM)})"

    def call(self, e):
        if isinstance(e, (derive.signum, sp.sign)):
            x = self.inside(e.args[0], ATOM)
            return f"(smg_real)(({x} > 0) - ({x} < 0))", ATOM
        if isinstance(e, derive.floor_):
            return f"SMG_MATH(floor)({self.doubled(e.args[0], SUM)})", ATOM
        if isinstance(e, sp.Abs):
            return f"SMG_MATH(fabs)({self(e.args[0])})", ATOM
        if type(e) in _RUNTIME:
            return f"{_RUNTIME[type(e)]}({', '.join(map(self, e.args))})", ATOM
        name = ELEMENTARY[type(e)]
        return f"SMG_MATH({name})({', '.join(map(self, e.args))})", ATOM

    def operation(self, e):
        """As it is written: the sides in their order, the right one in brackets where it is no factor."""
        if isinstance(e, written.negative):
            return "-" + self.doubled(e.args[0], PRODUCT), SUM
        sign, strength = WRITTEN[type(e)]
        blank = " " if strength == SUM else ""
        left, right = (self.doubled(a, strength + k) for k, a in enumerate(e.args))
        return f"{left}{blank}{sign}{blank}{right}", strength

    def doubled(self, e, strength: int) -> str:
        """What a jump looks at, in double precision whatever smg_real is: every build is on the same side."""
        if e.is_Number or e.is_Add or e.is_Mul or isinstance(e, written.Operation):      # sums and products outside of operations are of sizes
            return self.inside(e, strength)
        return "(double)" + self.inside(e, ATOM)
