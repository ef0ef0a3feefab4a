"""Numbers that belong to a site and to no term, on lattices by rows. The whole gradient is multiplied by: its strength beside that of the first site, and whether it moves,
unless its response says so."""
from __future__ import annotations

from ..lower.code import Assign, Call, Element, Function, Let, Name, Ordered, Return
from ..lower.integers import ONE, ZERO, Index
from .families import SITE
from .site_values import taken_value


def factors(found) -> dict:
    """{name in lanes: function}; they stand behind the numbers of terms."""
    return {**({"rate": "smg_rate"} if found.rated else {}), **({"moves": "smg_moves"} if found.held and not found.differing else {})}


def multiplied(found, first: int) -> tuple:
    """sum *= each of them; first: the number of the first one."""
    return tuple(line for n, name in enumerate(factors(found), first) for line in (Let(name, taken_value(n), "const smg_lanes"), *(Assign(Element("sum", a), Name(name), "*=") for a in range(3))))


def rate_function(found) -> list:
    """smg_rate(c, k): how much more a site turns in a field than the first one does, which is what rows reckon with."""
    kappa = [Call("smg_kappa", (Name("c"), site)) for site in (ZERO, Index("k"))]
    return [Function("smg_real", "smg_rate", SITE, (Return(Ordered("/", *kappa)),), wanted=True)] if found.rated else []


def radius_values(found) -> list:
    """The statements that return 1/r^2 of a site, where radii differ: the last of its numbers."""
    r = Call("smg_radius", (Name("c"), Index("site")))
    return [(Return(Ordered("/", ONE, Ordered("*", r, r))),)] if found.radii else []



def radius_settings(found, at: int) -> dict:
    return {"SMG_RADII": 1, "SMG_RADIUS_AT": at} if found.radii else {}


def rated(found, bound):
    """A bound of the field in which site k turns."""
    return Ordered("*", Call("smg_abs", (Call("smg_rate", (Name("c"), Index("k"))),)), bound) if found.rated else bound
