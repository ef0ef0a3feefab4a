"""Orbits: effects over the same sites, bond by bond, so that their terms may be added.

A sum over an index family is unchanged by a rotation when its terms are, added over all effects
of the family: x-x, y-y and z-z exchange over the same bonds are Heisenberg's. A lattice's bond
list is taken bond by bond; a bond is the same whichever end and cell it is written from. Small
systems are written out term by term, and then a sum that only vanishes as a whole is found too.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field

from ...language.instances import instances_of
from ...language.evaluate import integer
from ...language.expr import slots_of
from ...language.spec import Each, Graph, Lattice, Once, Pairs, Sites, Term
from ...language.tracers import moves_tracers
from . import bounds


@dataclass(frozen=True)
class Bound:
    """A term and what its indices stand for: site numbers, or labels that stay any."""
    term: Term
    indices: dict = field(hash=False)
    columns: dict = field(default_factory=dict, hash=False)


def orbits(effects) -> list[list[Bound]]:
    """The effects sorted into sums over one and the same set of index values."""
    found: dict = {}
    for term in effects:
        for key, bound in _keyed(term):
            found.setdefault(key, []).append(bound)
    return list(found.values())


def _keyed(term: Term):
    """(key, Bound) of each elementary sum that an effect consists of."""
    over = term.over
    if isinstance(over, Lattice):
        yield from (_bond(term, over, n) for n in range(len(over.bonds)))
        return
    labels = {name: f"{k}" for k, name in enumerate(_in_order(over))}
    yield _key(over), Bound(term, labels)


def _in_order(over) -> tuple:
    """The bound names; for `each` by family, since its order of writing does not matter."""
    if isinstance(over, Each):
        return tuple(i for _, i in sorted(zip(over.families, over.indices)))
    return over.bound


def _key(over):
    if isinstance(over, Once):
        return ("once",)
    if isinstance(over, (Sites, Pairs)):
        return type(over).__name__, over.family
    if isinstance(over, Each):
        return "each", tuple(sorted(over.families))
    assert isinstance(over, Graph)
    return "graph", over.family, over.edges, over.columns


def _bond(term: Term, over: Lattice, n: int):
    """One bond of a lattice, from its least end; its number is that of one list."""
    bond = over.bonds[n]
    families = over.families or (over.family,) * len(bond)
    order = sorted(range(len(bond)), key=lambda k: (families[k], bond[k]))
    origin = bond[order[0]][1]
    ends = tuple((bond[k][0], tuple(o - p for o, p in zip(bond[k][1], origin))) for k in order)
    labels = {over.indices[k]: f"{place}" for place, k in enumerate(order)} | ({over.number: f"{n} of {over.bonds}"} if over.number else {})
    return ("lattice", *(families[k] for k in order), over.size, over.periodic, over.sites, ends), Bound(term, labels)


def written_out(effects, values: dict, places: dict):
    """One orbit of all terms with their site numbers; None where there are too many."""
    if sum(terms(e.over, values, places) for e in effects) > bounds.TERMS:
        return None
    found = []
    for term in effects:
        indices, columns = instances_of(term.over, values, places)
        number = len(next(iter(indices.values()))) if indices else 1
        found += [Bound(term, {i: int(v[k]) for i, v in indices.items()},
                        {c: float(v[k]) for c, v in columns.items()}) for k in range(number)]
    return [found]


def terms(over, values: dict, places: dict) -> int:
    """How many terms a sum has (open ends of a lattice not taken off)."""
    if isinstance(over, Sites):
        return places[over.family][1]
    if isinstance(over, Pairs):
        return math.comb(places[over.family][1], 2)
    if isinstance(over, Each):
        return math.prod(places[f][1] for f in over.families)
    if isinstance(over, Lattice):
        return len(over.bonds) * math.prod(integer(e, values, "the size of a lattice") for e in over.size)
    return len(over.edges) if isinstance(over, Graph) else 1


def passive(term: Term, tracers) -> bool:
    """Does the term hold tracers? It then moves them alone."""
    return moves_tracers(term.over, slots_of(term.value), tracers)
