"""Several families on one lattice, by rows: their sites are places of one cell, those of a family behind those of the one before it.

Nothing else of rows knows families. In a state they stand one after the other all the same: smg_numbered_site of runtime/lattice/smg_rows.h.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from ...language.spec import Lattice, Sites
from ...language.sublattice import together
from ..lower.code import Call, If, Name, Return
from ..lower.integers import ZERO, Computed, Index, Int, Whole, compare, modulo, total
from .part import MOST_LANES


def roles(model) -> list:
    """The effects and slots through which the sites of all families feel something."""
    return [role for f in model.families for role in model.roles(f.name)]


def lattices(model) -> list:
    """Those of all bonds; where there are none, a chain without bonds of sites that feel only themselves."""
    found = [common(model, t.over) for t, _ in roles(model) if isinstance(t.over, Lattice)]
    return found or [Lattice(("i",), (f.family.count,), (False,), 1, ()) for f in model.families if free(model)]


def free(model) -> bool:
    """Do sites feel only themselves, of one family that fills lanes, by a method that goes by rows where no colours are needed?"""
    count, method = model.families[0].count, model.method
    fills = len(model.families) == 1 and (not isinstance(count, Whole) or count.value >= MOST_LANES)
    stepped = method.takes_fields or method.of_midpoints and not method.divided
    return stepped and fills and bool(model.fields) and all(isinstance(t.over, Sites) for t in model.fields)


def common(model, over: Lattice) -> Lattice:
    """The bonds between places of the common cell."""
    return together(over, [f.name for f in model.families])


def of_sites(model, over: Sites, cell: Lattice) -> Lattice:
    """The places of a family."""
    places = cell.sites // len(model.families)
    first = places * [f.name for f in model.families].index(over.family)
    return Lattice((over.index,), cell.size, cell.periodic, cell.sites, tuple(((sub, (0,) * len(cell.size)),) for sub in range(first, first + places)))


def in_cell(model, t, cell: Lattice):
    """A term over places of the common cell, if it is one of sites or of bonds."""
    over = of_sites(model, t.over, cell) if isinstance(t.over, Sites) else common(model, t.over) if isinstance(t.over, Lattice) else t.over
    return replace(t, derived=replace(t.derived, term=replace(t.derived.term, over=over)))


def in_cells(model, whole: dict, cell: Lattice) -> dict:
    """{prefix: the term in its place}, with the terms of several families over places of the common cell; whole: those that are others where some sites are absent."""
    return whole if len(model.families) == 1 else {t.prefix: in_cell(model, whole.get(t.prefix, t), cell) for t in model.fields}


def place_of(model, places: int) -> Int:
    """The place of site k."""
    return modulo(Index("k"), total(places)) if len(model.families) == 1 else Computed("smg_place_of_site", (Index("c"), Index("k")))


@dataclass(frozen=True)
class Home:
    """The family of the sites that a term is about: its name; the number of its first site, and of the first of the next family, None of the last."""
    name: str
    first: Int
    end: Int | None

    def value(self, function: str) -> tuple:
        """The statements that return a number of one of all sites, 0 of other families."""
        number = (Return(Call(function, (Name("c"), Index("site") - self.first))),)
        tests = (*[compare(Index("site"), ">=", self.first)] * (self.first != ZERO), *[compare(Index("site"), "<", self.end)] * (self.end is not None))
        return (If(tests, number), Return(ZERO)) if tests else number


def firsts(model, widths) -> dict:
    """{prefix: the number of its first value} of terms with so many values at each of their sites; terms of different families share numbers."""
    used, found = dict.fromkeys((f.name for f in model.families), 0), {}
    for t, width in widths:
        names = {name for name, _ in t.slots}
        found[t.prefix] = max(used[name] for name in names)
        used.update(dict.fromkeys(names, found[t.prefix] + width))
    return found


def homes_of(model, t) -> tuple:
    """Those of its slots."""
    some = (model.by_name[name] for name, _ in t.slots)
    return tuple(Home(f.name, f.first, None if f is model.families[-1] else f.first + f.count) for f in some)
