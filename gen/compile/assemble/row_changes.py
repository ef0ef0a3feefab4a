"""What a change of all vectors of a lattice by rows makes of the gradient of some slots, for the tangent map (runtime/lattice/smg_row_tangent.h):
each term by its Hessian in lanes, with the numbers of sites that its gradient has.
"""
from __future__ import annotations

from dataclasses import replace

import sympy as sp

from ..lower.code import Argument, Call, Component, Function, Let, Local, Name, Scope, Variable
from ..lower.integers import ZERO, Index, Pointed
from ..lower.kernels import DIRECTION, additions
from .bond_values import bond_partings
from .lanes import in_lanes
from .rows import ALL, SLOTS, bonds_of, by_place, joined, neighbours, numbers_in, row_roles, row_terms, taken, vectors_beside, where_there, width
from .site_factors import multiplied
from .site_values import differs, names, partings, taken as taken_values


def changes_of(model, low, found) -> dict:
    """{prefix of a term: {(slot that feels, slot that changes): kernel in lanes}}."""
    terms = [found.whole.get(t.prefix, t) for t in model.fields]
    return {t.prefix: of_values(low, t, found.sited[t.prefix]) if t.prefix in found.sited else {pair: in_lanes(kernel_of(t, pair)) for pair in t.derived.hessian} for t in terms}


def kernel_of(t, pair) -> Function:
    return next(f for f in t.functions if f.name == name_of(t, pair))


def name_of(t, pair) -> str:
    return f"{t.prefix}_hessian_{pair[0]}{pair[1]}"


def of_values(low, t, one) -> dict:
    """Of a term that differs from site to site: the derivatives of its gradient with the same numbers."""
    gradient, values = partings(low, t) if differs(t) else bond_partings(low, t)
    own = {symbol.name: Local(symbol.name) for symbol in values.values()}
    found = {}
    for k, l in t.derived.hessian:
        row = gradient[3 * k:3 * k + 3]
        kernel = low.kernel([sum(sp.diff(x, y) * d for y, d in zip(t.derived.vectors[l], DIRECTION)) for x in row], t.derived.leaves, own=own)
        arguments = (*t.arguments(), Argument("const smg_real *", "d"), Argument("smg_real *", "y"))
        f = in_lanes(Function("void", name_of(t, (k, l)), arguments, (*kernel.values, *additions([Component("y", a) for a in range(3)], kernel.results))))
        found[k, l] = replace(f, arguments=(*f.arguments, *(Argument("smg_lanes", name) for name in names(one))))
    return found


# What the model says of them

def change_functions(model) -> list:
    """smg_changed_slot_gradient: sum += d2H/dw2 times the changes `all` at the points of the run."""
    found = model.in_rows
    if not found.changes:
        return []
    kernels = [f for t in row_terms(model) for f in found.changes[t.prefix].values()]
    body = by_place(model, lambda sub: (*changes_of_place(model, sub), *multiplied(found, width(found))))
    return [*kernels, Function("void", "smg_changed_slot_gradient", SLOTS, body, target="lanes", wanted=True, inlined="always")]


def changes_of_place(model, sub: int) -> tuple:
    known, own = neighbours(model, sub), Pointed("run", "start") + Index("j")
    lines = [line for t, k in row_roles(model) for bond in bonds_of(t, k, sub) for line in one_term(model, t, k, bond, known, sub)]
    loads = [line for name, all in (("d_own", ALL), ("own", POINTS)) for line in (Variable("smg_lanes", f"{name}[3]"), Call("smg_take_slots", (*all, own, Name(name))))]
    return (Let("points", Pointed("run", "points"), "const smg_real *"), *loads, *lines)


POINTS = (Name("points"), Index("pitch"))


def one_term(model, t, k: int, bond, known: list, sub: int) -> list:
    """The blocks of a term in the row of slot k."""
    one = numbers_in(model, t, k, bond, sub)
    blocks = {l: f for (q, l), f in model.in_rows.changes[t.prefix].items() if q == k}
    if not blocks:
        return []
    others = vectors_beside(t, bond, k)
    lines = [line for q, at in others for name, all in ((f"d{q}", ALL), (f"v{q}", POINTS)) for line in (Variable("smg_lanes", f"{name}[3]"), taken(at, known.index(at), name, all))]
    vectors = [Name("own" if q == k else f"v{q}") for q in range(len(t.slots))]
    lines += [Call(f.name, (Name("c"), *[ZERO] * len(t.over.bound), *vectors, Name("d_own" if l == k else f"d{l}"), Name("sum"), *map(Name, names(one) if one else ()))) for l, f in blocks.items()]
    return [Scope((*(taken_values(one) if one else ()), *where_there(joined(t, bond, k), known, lines)))]
