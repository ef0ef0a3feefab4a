"""Torques as turns: T = w x R."""
from __future__ import annotations

from .expr import Expr, Idx, Num, Op, Spin, kind_of, with_index

SCALING = {"*", "/"}


def of_site(e: Expr, w: Spin) -> Expr:
    """A formula of a family, in its site's number Idx('i'), at the site of `w`."""
    return with_index(e, "i", Idx(w.slot) if isinstance(w.slot, str) else Num(w.slot))


def radius_of(family, w: Spin) -> Expr | None:
    """The radius of its sphere; None in R^3."""
    return family.radius and of_site(family.radius, w)


def about(torque: Expr, w: Spin) -> Expr | None:
    """R with torque = w x R, where the formula has `w` as a factor of its cross products; else None."""
    if not isinstance(torque, Op):
        return None
    a, *rest = torque.args
    if torque.op == "cross":
        return rest[0] if a == w else Op("neg", (a,)) if rest[0] == w else None
    if torque.op == "if":
        found = [about(x, w) for x in rest]
        return None if None in found else Op("if", (a, *found))
    if torque.op in SCALING:
        vector, number = (a, rest[0]) if kind_of(a) == "v" else (rest[0], a)
        found = about(vector, w)
        return None if found is None else Op(torque.op, (found, number))
    if torque.op in ("+", "-", "neg"):
        found = [about(x, w) for x in torque.args]
        return None if None in found else Op(torque.op, tuple(found))
    return None


def turn(torque: Expr, w: Spin, across: bool = False) -> Expr:
    """R with torque = w x R, whatever its formula; what it has along w is left out. across: the one across w."""
    found = None if across else about(torque, w)
    return Op("/", (Op("cross", (torque, w)), Op("dot", (w, w)))) if found is None else found
