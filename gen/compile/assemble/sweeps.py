"""Visits of every coupled site in the order of a sweep, and bounds of a row that show a contraction."""
from __future__ import annotations

import sympy as sp

from ...language.spec import Lattice, Sites
from ..lower.code import Argument, Braces, Call, For, Function, Let, Name, Ordered, Return
from ..lower.integers import ZERO, Index, total
from ..lower.kernels import COEFFICIENTS
from ..lower.lowering import CLOCK
from ..plan.colouring import colouring, one_colour
from .families import SITE, by_family

VISIT = (COEFFICIENTS, Argument("void *", "context"), Argument("void", "visit", "void *context, smg_lattice_site at"))


def visits(model) -> list:
    """smg_each, cell by cell, and smg_each_coloured, colour after colour."""
    found = []
    if model.plan.coupled and (model.plan.rotation or "tangent" in model.features and model.lifts()):
        found.append(visit(model, "smg_each", False))
    if model.plan.rotation:
        found.append(visit(model, "smg_each_coloured", True))
    if model.reach is not None:
        found.append(by_family("smg_real", "smg_hessian_row_norm", SITE, lambda f: (Return(model.reach[f.name]),), model.coupled, wanted=True))
    return found


def visit(model, name: str, coloured: bool) -> Function:
    """Inlined, so that the call of `visit` is, too."""
    body = [line for f in model.coupled for line in visit_family(model, f, coloured)]
    return Function("void", name, VISIT, body, wanted=True, inlined="always")


def visit_family(model, f, coloured: bool) -> tuple:
    """Calls of `visit` for all sites of a family."""
    def call(sub: int, cells):
        at = Braces((f.first + Index("site"), total(sub), *cells, *[ZERO] * (4 - len(cells))))
        return Let("at", at, "const smg_lattice_site"), Call("visit", (Name("context"), Name("at")))
    lattice = model.lattice(f.name)
    if lattice is None:
        return (For("site", ZERO, f.count, call(0, ())),)
    colours = colouring(model.lattices(f.name)) if coloured else one_colour(lattice)
    cells = [Index(f"s{d}") for d in range(len(lattice.size))]
    return model.loops.by_colour(lattice, colours, lambda sub: call(sub, cells))


def reach(model, low):
    """Family -> sum of bounds on the norms of the Hessian blocks in a row, where they are the same for all sites; else None."""
    if any(f.kind == "nambu" for f in model.coupled):
        return None
    found = {f.name: row_sums(model, low, f, lambda t, k: block_norm(low, t, k)) for f in model.coupled}
    return None if None in found.values() else found


def row_sums(model, low, f, norm):
    """Sum of norm(term, slot) over the terms that a site feels; of a lattice of several places in a cell the sum over them; None where a
    norm is."""
    rows = [0] * max([over.sites for over in model.lattices(f.name)] or [1])
    for t, k in model.roles(f.name):
        one = norm(t, k)
        if one is None:
            return None
        for sub, times_seen in meetings(t, k, len(rows)):
            rows[sub] += times_seen * one
    kernel = low.kernel(rows, {})
    return None if kernel.values else added(dict.fromkeys(kernel.results))


def added(values):
    """Their sum, as it stands."""
    first, *others = values
    for other in others:
        first = Ordered("+", first, other)
    return first


def block_norm(low, t, k):
    """A bound on the norms of the Hessian blocks in the row of slot k, if no site enters them."""
    if not isinstance(t.over, (Lattice, Sites)):
        return None
    total_norm = sp.S.Zero
    for (a, _), block in t.derived.hessian.items():
        if a == k:
            values = [low.number_values(x) for x in block]
            if any(low.when(x) > CLOCK for x in values):
                return None
            total_norm += spectral_bound(sp.Matrix(3, 3, values))
    return total_norm


def spectral_bound(block):
    """A bound on the spectral norm: of the symmetric part, which is exact for multiples of I, Frobenius elsewhere; and exact of the
    antisymmetric one."""
    even, odd = (block + block.T) / 2, (block - block.T) / 2
    return even_bound(even.applyfunc(sp.expand)) + sp.sqrt(sum(x.expand() ** 2 for x in (odd[0, 1], odd[0, 2], odd[1, 2])))


def even_bound(block):
    if block == block[0, 0] * sp.eye(3):
        return sp.Abs(block[0, 0])
    return sp.sqrt(sum(x ** 2 for x in block))


def meetings(t, k: int, subs: int):
    """How often a site of each place in the cell stands at slot k of a term: [(sub, times)]."""
    if isinstance(t.over, Sites):
        return [(sub, 1) for sub in range(subs)]
    position = t.over.indices.index(t.slots[k][1])
    places = [bond[position][0] for bond in t.over.bonds]
    return [(sub, places.count(sub)) for sub in range(subs)]
