"""The printers of several states at once: the same operations in the same order on smg_lanes (runtime/core/smg_lanes.h).

A sum or a product of lanes, or of lanes and one number, is written as that of numbers; functions and tests are calls. What does
not depend on a state stays one number.
"""
from __future__ import annotations

import sympy as sp
from sympy.core.sorting import default_sort_key
from sympy.logic.boolalg import Boolean

from ..assemble.lane_sphere import IN_LANES, named
from ..derive import derivatives as derive
from ..lower.code import Component, Held, Local, Number, Parameter
from ..lower.integers import Whole
from .formulas import ATOM, ELEMENTARY, PRODUCT, RELATIONS, Formulas, power_of
from .print_scalar import LINKAGE, Scalar

KERNELS = {**LINKAGE, "usual": LINKAGE["lanes"]}        # by value
_OWN = {derive.lesser: "min", derive.greater: "max", derive.signum: "sign", sp.sign: "sign", sp.Abs: "abs", derive.absolute: "abs"}


class LaneFormulas(Formulas):
    """`wide`: names of the symbols that are lanes."""

    def __init__(self, leaf, wide):
        super().__init__(leaf)
        self.wide = wide

    def in_lanes(self, e) -> bool:
        return any(s.name in self.wide for s in e.free_symbols)

    def lanes(self, e) -> str:
        """The text of e, which may be one number, as lanes."""
        return self(e) if self.in_lanes(e) else f"smg_lane_of({self(e)})"

    def lane_call(self, name: str, *args):
        return f"smg_lane_{name}({', '.join(self.lanes(a) for a in args)})", ATOM

    def pow(self, e):
        base, exponent = e.args
        way = power_of(exponent)
        if not self.in_lanes(e) or exponent.is_number and exponent.is_negative or way == "product":
            return super().pow(e)
        if way == "root":
            return self.lane_call("sqrt", base)
        if way == "product and root":
            whole = "*".join([self.inside(base, ATOM)] * int(exponent.p // 2))
            return f"{whole}*{self.lane_call('sqrt', base)[0]}", PRODUCT
        return self.lane_call("pow", base, exponent)

    def doubled(self, e, strength: int) -> str:
        return self.inside(e, strength) if self.in_lanes(e) else super().doubled(e, strength)

    def call(self, e):
        if not self.in_lanes(e):
            return super().call(e)
        return self.lane_call(_OWN.get(type(e)) or ELEMENTARY[type(e)], *e.args)

    def chosen(self, e):
        if not self.in_lanes(e):
            return super().chosen(e)
        test, value, other = e.args
        return f"smg_lane_select({self.mask(test)}, {self.lanes(value)}, {self.lanes(other)})", ATOM

    def mask(self, e) -> str:
        """The text of a test, which may be the same for all lanes, as a mask."""
        return self.test(e) if self.in_lanes(e) else f"smg_lane_all({self.test(e)})"

    def test(self, e) -> str:
        if not self.in_lanes(e) or e.is_Symbol:
            return super().test(e)
        if isinstance(e, (sp.And, sp.Or)):
            mark = " & " if isinstance(e, sp.And) else " | "
            return "(" + mark.join(self.mask(a) for a in sorted(e.args, key=default_sort_key)) + ")"
        if isinstance(e, sp.Not):
            return f"smg_lane_not({self.mask(e.args[0])})"
        return f"(smg_lane_mask)({self.lanes(e.lhs)} {RELATIONS[type(e)]} {self.lanes(e.rhs)})"


class Lanes(Scalar):
    """Components of vectors are lanes, and so is what is made of them; all else is one number.

    named: values of the function under way that are lanes.
    """
    named, zeros = frozenset(), "smg_lanes"

    def define_function(self, f):
        self.named = {a.name for a in f.arguments if a.kind == "smg_lanes"}
        return super().define_function(f)

    def formulas_of(self, real) -> LaneFormulas:
        wide = {name for name, leaf in real.leaves.items()
                if isinstance(leaf, Component) or isinstance(leaf, Local) and leaf.name in self.named}
        return LaneFormulas(lambda name: self.leaf(real.leaves[name]), wide)

    def show_real(self, r):
        shown = self.formulas_of(r)
        return (shown.test(r.expr), ATOM) if isinstance(r.expr, Boolean) else shown.show(r.expr)

    def do_value(self, s):
        if not self.formulas_of(s.value).in_lanes(s.value.expr):
            return super().do_value(s)
        truth = isinstance(s.value.expr, Boolean) and not s.value.expr.is_Symbol
        line = f"const {'smg_lane_mask' if truth else 'smg_lanes'} {s.name} = {self(s.value)};"
        self.named.add(s.name)
        return [line]

    def of_zeros(self, s):
        return f"{s.name}[{s.size}] = {{{', '.join(['smg_lane_of(0)'] * s.size)}}}"


class LanesByValue(Lanes):
    """The single sphere in lanes: vectors by value, and coefficients that are lanes too, so that each state has its own."""
    real, linkage = "smg_lanes", KERNELS

    def formulas_of(self, real) -> LaneFormulas:
        wide = {name for name, leaf in real.leaves.items()
                if isinstance(leaf, (Component, Held, Parameter)) or isinstance(leaf, Local) and (leaf.name == "q" or leaf.name in self.named)}
        return LaneFormulas(lambda name: self.leaf(real.leaves[name]), wide)

    def leaf_component(self, n):
        return f"{n.vector}.{'xyz'[n.axis]}", ATOM

    def leaf_held(self, n):
        return f"{n.holder}->{n.name}", ATOM

    def leaf_parameter(self, n):
        return super().leaf_parameter(n) if n.place is not None and not isinstance(n.place, Whole) else (f"c->{named(n)}", ATOM)

    def show_real(self, r):
        shown = self.formulas_of(r)
        truth = isinstance(r.expr, Boolean) and not r.expr.is_Symbol
        return super().show_real(r) if shown.in_lanes(r.expr) or truth else (shown.lanes(r.expr), ATOM)

    def show_call(self, n):
        """Numbers as lanes; the function of lanes."""
        return f"{IN_LANES.get(n.function, n.function)}({', '.join(map(self.as_lanes, n.args))})", ATOM

    def as_lanes(self, n) -> str:
        return f"smg_lane_of({self(n)})" if isinstance(n, (Number, Whole)) else self(n)

    def do_return(self, s):
        return [f"return {self.as_lanes(s.value)};"]
