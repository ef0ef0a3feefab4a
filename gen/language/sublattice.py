"""The sites of one place of a lattice's cell, the part of a lattice that is one family's, and the cell that has the places of several families."""
from __future__ import annotations

from dataclasses import replace

from .expr import Expr, Idx, Num, Op
from .spec import Lattice, Over, Sites


def sites_of(over: Over) -> tuple:
    """(`Sites`, the condition on its index or None) of an index family with a single index; (over, None) of any other."""
    if not isinstance(over, Lattice) or len(over.indices) != 1:
        return over, None
    ((place, _),), = over.bonds
    return Sites(over.indices[0], over.family), Op("==", (Op("mod", (Idx(over.indices[0]), Num(over.sites))), Num(place)))


def there(condition, value: Expr) -> Expr:
    """The value where the condition holds, else 0."""
    return value if condition is None else Op("if", (condition, value, Num(0)))


def within(over: Lattice, family: str) -> Lattice:
    """The ends of its bonds that are of a family."""
    if over.family:
        return over
    ends = [k for k, name in enumerate(over.families) if name == family]
    return replace(over, indices=tuple(over.indices[k] for k in ends), bonds=tuple(tuple(bond[k] for k in ends) for bond in over.bonds), family=family, families=())


def together(over: Lattice, names) -> Lattice:
    """Its bonds between places of a cell that has those of all these families, one behind the other."""
    first = [over.sites * names.index(home) for home in over.families or (over.family,) * len(over.indices)]
    bonds = tuple(tuple((k + sub, offset) for k, (sub, offset) in zip(first, bond)) for bond in over.bonds)
    return over if len(names) == 1 else replace(over, sites=len(names) * over.sites, bonds=bonds)
