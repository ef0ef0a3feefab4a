"""Sites that do not move, and sites that are not there: which they are, as formulas of the site's number Idx("i")."""
from __future__ import annotations

from functools import reduce

from .expr import Expr, Num, Op
from .spec import Spec

ALWAYS = Op("<", (Num(0), Num(1)))


def absent(spec: Spec, family: str) -> Expr | None:
    """The condition that a site is not there; None where all are."""
    return either(spec, family, lambda e: e.gone)


def still(spec: Spec, family: str) -> Expr | None:
    """The condition that a site does not move: it is pinned, absent or of a fixed family; None where all move."""
    fixed = any(f.fixed for f in spec.families if f.name == family)
    return ALWAYS if fixed else either(spec, family, lambda e: True)


def standing(spec: Spec) -> tuple:
    """The families with sites that others feel and that do not move."""
    return tuple(f.name for f in spec.families if f.fixed or either(spec, f.name, lambda e: not e.gone) is not None)


def lacking(spec: Spec) -> tuple:
    """The families with absent sites."""
    return tuple(f.name for f in spec.families if absent(spec, f.name) is not None)


def either(spec: Spec, family: str, which) -> Expr | None:
    """The conditions of some effects on the sites of a family, joined by `or`."""
    found = [e.holds[1] for e in spec.effects if e.holds and e.holds[0] == family and which(e)]
    return reduce(lambda a, b: Op("or", (a, b)), found) if found else None


def unless(condition: Expr) -> Expr:
    """1, or 0 where the condition holds."""
    return Op("if", (condition, Num(0), Num(1)))
