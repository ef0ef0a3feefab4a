"""Visits of every coupled site in the order of a sweep."""
from __future__ import annotations

from ..lower.code import Argument, Braces, Call, For, Function, Let, Name
from ..lower.integers import ZERO, Index, total
from ..lower.kernels import COEFFICIENTS
from ..plan.colouring import colouring, one_colour
from .norms import norm_functions
from .rows import bounded_apart
from .sums import swept_by_site
from .visiting import in_order

VISIT = (COEFFICIENTS, Argument("void *", "context"), Argument("void", "visit", "void *context, smg_lattice_site at"))


def visits(model) -> list:
    """smg_each, cell by cell, and smg_each_coloured, colour after colour."""
    found = []
    if model.plan.coupled and (swept_by_site(model) or "tangent" in model.features and model.lifts()):
        found.append(visit(model, "smg_each", False))
    if swept_by_site(model):
        found.append(visit(model, "smg_each_coloured", True))
    return found + (norm_functions(model) if model.in_rows is None or not bounded_apart(model) else [])


def visit(model, name: str, coloured: bool) -> Function:
    """Inlined, so that the call of `visit` is, too."""
    body = [line for f in model.coupled for line in visit_family(model, f, coloured)]
    return Function("void", name, VISIT, body, wanted=True, inlined="always")


def visit_family(model, f, coloured: bool) -> tuple:
    """Calls of `visit` for all sites of a family."""
    def call(site, sub: int, cells):
        at = Braces((f.first + site, total(sub), *cells, *[ZERO] * (4 - len(cells))))
        return Let("at", at, "const smg_lattice_site"), Call("visit", (Name("context"), Name("at")))
    lattice = model.lattice(f.name)
    if lattice is None and model.visited is not None:
        return in_order(model, f, lambda site, ahead: call(site, 0, (f.first + ahead,)))
    if lattice is None:
        return (For("site", ZERO, f.count, call(Index("site"), 0, ())),)
    colours = colouring(model.lattices(f.name)) if coloured else one_colour(lattice)
    cells = [Index(f"s{d}") for d in range(len(lattice.size))]
    return model.loops.by_colour(lattice, colours, lambda site, sub: call(site, sub, cells))
