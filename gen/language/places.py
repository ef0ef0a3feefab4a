"""Where the sites of a family stand, and which of them bonds join.

    positions(spec, "w", values)        # (sites, 3), or None where the spec gives no positions
    bonds(spec, "w", values)            # (bonds, 2): numbers of sites within the family
    bond_vectors(spec, "w", values)     # (bonds, 3): from the first site to the second, through the boundary where the bond goes through it

values: of all parameters (`run.step.evaluated.Evaluated.values`).
"""
from __future__ import annotations

import numpy as np

from .evaluate import integer
from .instances import instances_of
from .spec import Graph, Lattice, Spec, families_of


def joined_by(spec: Spec, family: str) -> list:
    """The lattices and graphs of effects and observables on a family."""
    found = [e.over for e in (*spec.effects, *spec.observables) if isinstance(e.over, (Lattice, Graph)) and is_on(e.over, family)]
    return list({(over, over.places): over for over in found}.values())


def best(overs):
    """The lattice or graph that says where sites stand: of those with places those that declare them, then those of most directions. None where there
    is none. Raises ValueError where two that are left differ."""
    ranks = [((isinstance(over, Graph) or not over.places.assumed, directions(over)), over) for over in overs if over.places is not None]
    found = [over for rank, over in ranks if rank == max(rank for rank, _ in ranks)]
    if len({geometry(over) for over in found}) > 1:
        raise ValueError("two lattices place the sites differently")
    return found[0] if found else None


def is_on(over, family: str) -> bool:
    """Does a lattice or graph join sites of a family? Of bonds between several families each has a site for each of the lattice."""
    return over.family == family or isinstance(over, Lattice) and family in over.families


def directions(over) -> int:
    return len(over.size) if isinstance(over, Lattice) else 0


def geometry(over) -> tuple:
    return (over.size, over.places.vectors, over.places.positions) if isinstance(over, Lattice) else (over.places,)


def placed_on(spec: Spec, family: str):
    """The lattice or graph that says where the sites of a family stand; None without one, or where several differ."""
    home = next(f.lattice for f in spec.families if f.name == family)
    try:
        return home if home is not None and home.places is not None else best(joined_by(spec, family))
    except ValueError:
        return None


def positions(spec: Spec, family: str, values: dict):
    """Where the sites of a family stand: an array (sites, 3), in the order of the sites; None where the spec gives no positions."""
    over = placed_on(spec, family)
    if over is None:
        return None
    return np.array(over.places, float).reshape(-1, 3) if isinstance(over, Graph) else on_lattice(over, values)


def all_positions(spec: Spec, counts: dict, values: dict):
    """Of the sites of all families, (sites, 3), NaN of those without; None where none has any. counts: family -> number of its sites."""
    found = {name: positions(spec, name, values) for name in counts}
    if all(there is None for there in found.values()):
        return None
    return np.concatenate([np.full((count, 3), np.nan) if found[name] is None else found[name] for name, count in counts.items()])


def on_lattice(over: Lattice, values: dict, first: int = 0, end: int | None = None) -> np.ndarray:
    """Site s of cell (c0, c1, ..) at c0 a0 + c1 a1 + .. and the fractions of s, of the cells from first to end - 1."""
    size = [integer(e, values, "the size of a lattice") for e in over.size]
    cells = np.stack(np.unravel_index(np.arange(first, np.prod(size, dtype=np.int64) if end is None else end), size[::-1])[::-1], axis=-1)
    vectors = np.array(over.places.vectors, float)
    return (np.repeat(cells @ vectors[:len(size)], over.sites, axis=0) + np.tile(within_cell(over), (len(cells), 1)))


def within_cell(over: Lattice) -> np.ndarray:
    """(sites, 3): where the sites of the first cell stand."""
    return np.array(over.places.positions, float) @ np.array(over.places.vectors, float)


def bonds(spec: Spec, family: str, values: dict, scene: Spec | None = None) -> np.ndarray:
    """The bonds and edges with two ends on a family, each pair of each lattice or graph once: numbers of sites (bonds, 2).

    scene: the same with fewer effects, whose bonds they are; positions are those of the whole.
    """
    return _found(spec, family, values, scene)[0]


def bond_vectors(spec: Spec, family: str, values: dict, scene: Spec | None = None):
    """Of the same bonds, the vector from the first site to the second, (bonds, 3); None where the spec gives no positions."""
    return _found(spec, family, values, scene)[1]


def _found(spec: Spec, family: str, values: dict, scene: Spec | None):
    """(bonds, their vectors)."""
    there = positions(spec, family, values)
    rows = [_of(over, values, there) for over in joined_by(scene or spec, family) if over.family and len(families_of(over)) == 2]
    pairs = np.concatenate([pair for pair, _ in rows]) if rows else np.zeros((0, 2), np.int64)
    vectors = np.concatenate([v for _, v in rows]) if rows else np.zeros((0, 3))
    grid = vectors / (np.abs(vectors).max(initial=0) or 1)
    _, first = np.unique(np.column_stack([pairs, np.round(grid, 9)]), axis=0, return_index=True)
    first.sort()
    return pairs[first], None if there is None else vectors[first]


def _of(over, values: dict, there):
    """Of one lattice or graph; vectors are 0 without positions."""
    split = [_one(over, (bond,)) for bond in over.bonds] if isinstance(over, Lattice) else [over]
    parts = []
    for one in split:
        indices, _ = instances_of(one, values, {})
        pairs = np.column_stack([indices[name] for name in families_of(over)]).astype(np.int64)
        parts.append((pairs, _vectors(one, pairs, there)))
    return tuple(np.concatenate([part[k] for part in parts]) for k in (0, 1))


def _one(over: Lattice, bonds: tuple) -> Lattice:
    return Lattice(over.indices, over.size, over.periodic, over.sites, bonds, over.family, over.places)


def _vectors(over, pairs, there) -> np.ndarray:
    """Those of a lattice do not depend on its size."""
    if there is None:
        return np.zeros((len(pairs), 3))
    if isinstance(over, Graph) or over.places is None:
        return there[pairs[:, 1]] - there[pairs[:, 0]]
    return np.tile(bond_vector(over, over.bonds[0]), (len(pairs), 1))


def bond_vector(over: Lattice, bond) -> np.ndarray:
    """From the first site of a bond of two ends to the second."""
    (a, here), (b, away) = bond
    steps = (np.array(away) - np.array(here)) @ np.array(over.places.vectors, float)[:len(over.size)]
    return steps + within_cell(over)[b] - within_cell(over)[a]
