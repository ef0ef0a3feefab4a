"""Energies on the same bonds as one term: a bond is then visited once, whatever the number of effects on it.

Those with a constant Hessian are added up, entry by entry, so that the gradient takes nine products of a coefficient and a component at most. Bonds that only some
of the effects share become terms of their own; the value of every effect stays a function of its own, over all its bonds.
"""
from __future__ import annotations

from dataclasses import replace
from functools import reduce

import sympy as sp

from ...language.expr import Elem, Expr, Idx, Op, Spin
from ...language.spec import Each, Graph, Lattice, Pairs
from ..by_bond import free
from ..derive.derivatives import Derived, derive, switched
from ..lower.kernels import kernels_of, motion_kernels, value_kernels


def energy_kernels(low, energies, role: str, method, like=None) -> tuple:
    """(the kernels of what moves sites, those of the values of effects that share bonds). Methods that turn bond after bond, effect after effect, have each as it is.
    like: the same energies in another form, of which those are joined that are here."""
    derived = tuple(map(derive, energies))
    shared = {} if method.splitting == "pairs" else shares(derived, derived if like is None else tuple(map(derive, like)))
    moving: list = []
    for n, d in enumerate(derived):
        moving += [kernels_of(low, d, role)] if n not in shared else [motion_kernels(low, one, role) for one in shared[n]]
    return tuple(moving), tuple(value_kernels(low, d, role) for n, d in enumerate(derived) if n in shared)


def shares(derived, like) -> dict[int, list]:
    """Number of each energy that shares bonds -> the terms that begin with it: sums over the bonds that it shares with later ones, and those that it has alone. like: says which."""
    found: dict = {}
    names = {d.term.name for d in derived}
    for group in groups(like).values():
        bonds = covered(group, like)
        if any(len(some) > 1 for some in bonds):
            found.update({n: [] for n in group if any(n in some and len(some) > 1 for some in bonds)})
            for some, over in bonds.items():
                if some[0] in found:
                    found[some[0]].append(summed([derived[n] for n in some], over, names))
    return found


def groups(derived) -> dict:
    """Energies whose bonds may be the same, by what they run over."""
    found: dict = {}
    for n, d in enumerate(derived):
        if quadratic(d) and isinstance(d.term.over, (Pairs, Each, Graph, Lattice)) and len(d.slots) > 1:
            over = numbered(d.term.over)
            key = replace(over, bonds=()) if by_bond(over) else over, frozenset(positions(d))
            found.setdefault(key, []).append(n)
    return {key: some for key, some in found.items() if len(some) > 1}


def by_bond(over) -> bool:
    """May bonds of its list be taken apart? Not where their numbers count; one that is listed twice counts twice."""
    return isinstance(over, Lattice) and not (over.number or over.columns) and len(set(over.bonds)) == len(over.bonds)


def quadratic(d: Derived) -> bool:
    """Is its Hessian the same at all states?"""
    vectors = {x for v in d.vectors for x in v}
    return not d.parts and not switched(d) and not any(vectors & block.free_symbols for block in d.hessian.values())


def covered(group, derived) -> dict:
    """The energies of a bond -> the bonds that they have together, as an index family."""
    over = derived[group[0]].term.over
    if not by_bond(over):
        return {tuple(group): over}
    found: dict = {}
    for bond in dict.fromkeys(bond for n in group for bond in derived[n].term.over.bonds):
        found.setdefault(tuple(n for n in group if bond in derived[n].term.over.bonds), []).append(bond)
    return {some: replace(derived[some[0]].term.over, bonds=tuple(bonds)) for some, bonds in found.items()}


# Sums

def summed(parts, over, names: set) -> Derived:
    """One term of several; of a single one the same over other bonds."""
    first = parts[0].term
    if len(parts) == 1 and over == first.over:
        return parts[0]
    name = free(first.name + (f"_and_{len(parts) - 1}_more" if len(parts) > 1 else "_elsewhere"), names)
    names.add(name)
    parts = [aligned(d, parts[0]) for d in parts]
    term = replace(first, name=name, over=over, value=reduce(lambda a, b: Op("+", (a, b)), (d.term.value for d in parts)))
    leaves = {symbol: node for d in parts for symbol, node in d.leaves.items()}
    blocks = added(parts)
    return replace(parts[0], term=term, value=sum(d.value for d in parts), gradient=gradient(parts, blocks), hessian=blocks, leaves=leaves, joined=tuple(d.term.name for d in parts) if len(parts) > 1 else ())


def added(parts) -> dict:
    """The Hessian, by its blocks that are not zero."""
    found: dict = {}
    for d in parts:
        for pair, block in d.hessian.items():
            found[pair] = found[pair] + block if pair in found else block
    return {pair: found[pair] for pair in sorted(found) if any(x != 0 for x in found[pair])}


def gradient(parts, blocks) -> tuple:
    """Of the sum: its value where all vectors are 0, and the Hessian times them."""
    vectors = parts[0].vectors
    nowhere = {x: 0 for v in vectors for x in v}

    def component(k: int, a: int):
        linear = (blocks[k, l][a, b] * x for l, v in enumerate(vectors) if (k, l) in blocks for b, x in enumerate(v))
        return sum((sp.sympify(d.gradient[k][a]).subs(nowhere) for d in parts), sp.S.Zero) + sum(linear, sp.S.Zero)
    return tuple(tuple(component(k, a) for a in range(3)) for k in range(len(vectors)))


# Names

def numbered(over):
    """An index family with numbers in place of the names of its indices."""
    return named(over, {name: str(n) for n, name in enumerate(over.bound)})


def named(over, names: dict):
    """The same with other names of indices."""
    if isinstance(over, (Pairs, Graph)):
        return replace(over, first=names[over.first], second=names[over.second])
    more = {"number": over.number and names[over.number]} if isinstance(over, Lattice) else {}
    return replace(over, indices=tuple(names[i] for i in over.indices), **more)


def positions(d: Derived) -> list:
    """Its slots, with the number of an index in place of its name."""
    return [(family, d.term.over.bound.index(slot) if isinstance(slot, str) else f"site {slot}") for family, slot in d.slots]


def aligned(d: Derived, like: Derived) -> Derived:
    """The same with the indices and the order of slots of another one."""
    names = dict(zip(d.term.over.bound, like.term.over.bound))
    value = renamed(d.term.value, names)
    order = [[(f, names.get(s, s)) for f, s in d.slots].index(slot) for slot in like.slots]
    if value == d.term.value and order == list(range(len(order))):
        return d
    again = derive(replace(d.term, over=named(d.term.over, names), value=value))
    swap = {x: y for k, other in enumerate(order) for x, y in zip(again.vectors[other], like.vectors[k])}
    rows = tuple(tuple(sp.sympify(x).xreplace(swap) for x in again.gradient[other]) for other in order)
    blocks = {(order.index(k), order.index(l)): block for (k, l), block in again.hessian.items()}
    return replace(again, slots=like.slots, vectors=like.vectors, value=again.value.xreplace(swap), gradient=rows, hessian=blocks)


def renamed(e: Expr, names: dict) -> Expr:
    """A formula with other names of indices."""
    if isinstance(e, Idx):
        return replace(e, name=names.get(e.name, e.name))
    if isinstance(e, Spin):
        return replace(e, slot=names.get(e.slot, e.slot))
    if isinstance(e, Elem):
        return replace(e, index=renamed(e.index, names))
    return replace(e, args=tuple(renamed(a, names) for a in e.args)) if isinstance(e, Op) else e
