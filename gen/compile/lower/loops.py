"""Index families as loops: the sum over an orbit, never written out.

`scatter` visits every term once; `gather` visits, for one site, the terms in which it takes part. A body is a tuple of
statements in the indices that the family binds.
"""
from __future__ import annotations

from array import array
from functools import lru_cache
from hashlib import sha256

import sympy as sp

from ...language.spec import Each, Graph, Lattice, Once, Pairs, Sites
from .code import Entry, For, Let, Real, Scope, Value, real_of, tidy, where
from .integers import ZERO, Cell, Index, compare, modulo, quotient, remainder, times, total, wrapped

SITE = Index("site")


class Loops:
    """The loops of one model; `low` gives sizes, `count(family)` a family's."""

    def __init__(self, low, count):
        self.low, self.count = low, count

    # -- every term once --------------------------------------------------------------------
    def scatter(self, over, body) -> tuple:
        return tidy(getattr(self, "scatter_" + type(over).__name__.lower())(over, tuple(body)))

    def scatter_once(self, over: Once, body):
        return body

    def scatter_sites(self, over: Sites, body):
        return (For(over.index, ZERO, self.count(over.family), body),)

    def scatter_pairs(self, over: Pairs, body):
        n, i, j = self.count(over.family), over.first, over.second
        return (For(i, ZERO, n, (For(j, Index(i) + 1, n, body, over="pairs"),), over="pairs"),)

    def scatter_each(self, over: Each, body):
        for i, family in reversed(list(zip(over.indices, over.families))):
            body = (For(i, ZERO, self.count(family), body),)
        return body

    def scatter_graph(self, over: Graph, body):
        return (For("e", ZERO, total(len(over.edges)), (*self.edge(over), *body), over="edges"),)

    def edge(self, over: Graph):
        """The sites and weights of the edge e."""
        ends = [Let(i, Cell(f"{graph_name(over)}_edge", (Index("e"), total(side)))) for side, i in enumerate(over.bound)]
        return (*ends, *self.weights(over))

    def weights(self, over: Graph):
        return tuple(Value(f"weight_{c}", real_of(Entry(f"{graph_name(over)}_{c}", Index("e")))) for c, _ in over.columns)

    def scatter_lattice(self, over: Lattice, body):
        return self.of_bonds(over, range(len(over.bonds)), body)

    def of_bonds(self, over: Lattice, some, body):
        """The terms of some of the bonds of the list, in all cells."""
        cells = [Index(f"c{d}") for d in range(len(over.size))]
        lines = tuple(self.bond(over, n, cells, body) for n in some)
        for d, size in enumerate(over.size):        # direction 0 is the fastest: innermost
            lines = (For(f"c{d}", ZERO, self.low.size(size), lines, over="cells"),)
        return lines

    # -- lattice bonds ----------------------------------------------------------------------
    def bond(self, over: Lattice, n: int, cells, body, member: int | None = None):
        """The term of the n-th bond of the list from its base cell `cells`, or from the cell of one of its members; inside a test where open ends
        may cut it off."""
        tests, lines, back = [], [], (0,) * len(cells) if member is None else over.bonds[n][member][1]
        for name, (sub, offset) in zip(over.indices, over.bonds[n]):
            lines.append(self.site(over, name, sub, tuple(a - b for a, b in zip(offset, back)), cells, tests))
        weights = (Value(f"weight_{c}", Real(sp.Float(values[n]), {})) for c, values in over.columns)
        return where(tests, (*lines, *self.numbered(over, n, cells, back), *weights, *body))

    def numbered(self, over: Lattice, n: int, cells, back) -> tuple:
        """The number of that bond, where the formula asks."""
        if not over.number:
            return ()
        base = [self.moved(over, d, cell, -shift, []) for d, (cell, shift) in enumerate(zip(cells, back))]
        return (Let(over.number, self.bond_number(over, n, base)),)

    def bond_number(self, over: Lattice, n: int, cells):
        """Behind those of the bonds before it in the list: the place of its base cell among those in which the bond is."""
        start, place = self.bonds_of(over, range(n)), ZERO
        for cell, (first, length) in reversed(list(zip(cells, self.within(over, n)))):
            place = cell - first + length * place
        return start + place

    def bonds_of(self, over: Lattice, some):
        """How many there are of some of the list."""
        return total(*(times(*(length for _, length in self.within(over, k))) for k in some))

    def within(self, over: Lattice, n: int) -> list:
        """(the first, how many) of the cells from which the n-th bond stays within open ends, in each direction."""
        found = []
        for d, size in enumerate(over.size):
            reach = [0, *(offset[d] for _, offset in over.bonds[n])] if not over.periodic[d] else [0]
            found.append((-min(reach), self.low.size(size) - (max(reach) - min(reach))))
        return found

    def moved(self, over: Lattice, d: int, cell, shift: int, tests):
        """The coordinate `cell + shift` in direction d: on a ring, or tested to lie within open ends."""
        size, place = self.low.size(over.size[d]), cell + shift
        if shift and over.periodic[d]:
            return wrapped(place, size)
        if shift:
            tests.append(compare(place, "<", size) if shift > 0 else compare(place, ">=", ZERO))
        return place

    def site(self, over: Lattice, name: str, sub: int, offset, cells, tests):
        """The number of the site `sub` in the cell at `offset`."""
        places = [self.moved(over, d, cell, shift, tests) for d, (cell, shift) in enumerate(zip(cells, offset))]
        number = places[-1]
        for d in range(len(cells) - 2, -1, -1):
            number = places[d] + self.low.size(over.size[d]) * number
        return Let(name, number * over.sites + sub)

    # -- the terms of one site --------------------------------------------------------------
    def gather(self, over, slot, body, placed: bool = False) -> tuple:
        """Terms in which the site `site` stands at `slot` = (family, index name).

        placed: the site's cell s0, s1, .. and place `sub` are variables already.
        """
        if isinstance(over, Lattice):
            return (Scope(self.gather_lattice(over, slot, tuple(body), placed)),)
        return (Scope(getattr(self, "gather_" + type(over).__name__.lower())(over, slot, tuple(body))),)

    def gather_once(self, over: Once, slot, body):
        return (where([compare(SITE, "==", total(slot[1]))], body),)

    def gather_sites(self, over: Sites, slot, body):
        return (Let(over.index, SITE), *body)

    def gather_pairs(self, over: Pairs, slot, body):
        n, own = self.count(over.family), slot[1]
        inner = (Let(own, SITE), *body)
        if own == over.first:
            return (For(over.second, SITE + 1, n, inner, over="pairs"),)
        return (For(over.first, ZERO, SITE, inner, over="pairs"),)

    def gather_each(self, over: Each, slot, body):
        lines = (Let(slot[1], SITE), *body)
        for i, family in reversed(list(zip(over.indices, over.families))):
            if i != slot[1]:
                lines = (For(i, ZERO, self.count(family), lines),)
        return lines

    def gather_graph(self, over: Graph, slot, body):
        """Adjacency rows: for each site the edges that it begins (or ends)."""
        side, row = over.bound.index(slot[1]), (Index("row"),)
        table, sites = side_table(over, side), 1 + over.highest      # later sites have no edge and no row
        inside = (Let("e", Cell(table, row)), Let(over.bound[1 - side], Cell(f"{table}_end", row)), Let(slot[1], SITE), *self.weights(over), *body)
        rows = For("row", Cell(f"{table}_row", (SITE, total(0))), Cell(f"{table}_row", (SITE, total(1))), inside, over="edges")
        return (where([compare(SITE, "<", total(sites))], (rows,)),)

    def gather_lattice(self, over: Lattice, slot, body, placed: bool = False):
        place = () if placed else self.cell_of_site(over)
        position = over.indices.index(slot[1])
        return (*place, *(self.gather_bond(over, n, position, body) for n in range(len(over.bonds))))

    def cell_of_site(self, over: Lattice):
        """The coordinates of the cell that holds the site, and its place in the cell."""
        lines = [Let("sub", remainder(SITE, over.sites))] if over.sites > 1 else []
        rest = quotient(SITE, over.sites)
        for d in range(len(over.size) - 1):
            size = self.low.size(over.size[d])
            lines += [Let(f"r{d}", rest), Let(f"s{d}", remainder(Index(f"r{d}"), size))]
            rest = quotient(Index(f"r{d}"), size)
        return (*lines, Let(f"s{len(over.size) - 1}", rest))

    def gather_bond(self, over: Lattice, n: int, position: int, body):
        """The term whose member `position` is the site: its base cell is as far back as the bond reaches there."""
        sub, offset = over.bonds[n][position]
        tests = [compare(Index("sub"), "==", total(sub))] if over.sites > 1 else []
        lines, cells = [], []
        for d, shift in enumerate(offset):
            cell = self.moved(over, d, Index(f"s{d}"), -shift, tests)
            if shift:
                lines.append(Let(f"b{d}", cell))
            cells.append(Index(f"b{d}") if shift else cell)
        return where(tests, (*lines, self.bond(over, n, cells, body)))

    # -- all sites in an order --------------------------------------------------------------
    def by_colour(self, over: Lattice, colours, body) -> tuple:
        """All sites of a lattice, colour after colour; `body(site, sub)` finds s0, s1, .. set."""
        lines = tuple(line for sub in range(over.sites) for line in self.one_place(over, colours, sub, body))
        return (For("colour", ZERO, total(colours.colours), lines, over="colours"),) if colours.colours > 1 else lines

    def one_place(self, over: Lattice, colours, sub: int, body):
        """The sites `sub` of the cells of a colour."""
        cells = [Index(f"s{d}") for d in range(len(over.size))]
        return self.cells_of_colour(over, colours, sub, body(self.site(over, "site", sub, (0,) * len(cells), cells, []).value, sub))

    def cells_of_colour(self, over: Lattice, colours, sub: int, inner):
        """The cells s0, s1, .. whose site `sub` has a colour: those with (weights . cell + shift) mod colours = colour."""
        cells, step, w = [Index(f"s{d}") for d in range(len(over.size))], colours.colours, colours.weights
        others = total(*(w[d] * cells[d] for d in range(1, len(cells))), colours.shift[sub])
        start, stride = (first_of_colour(others, w[0], step), step) if w[0] and step > 1 else (ZERO, 1)
        for d, size in enumerate(over.size):
            inner = (For(f"s{d}", start if d == 0 else ZERO, self.low.size(size), inner, step=stride if d == 0 else 1, over="cells"),)
        if step > 1 and not w[0]:
            if any(w):
                raise ValueError("the colouring does not depend on the fastest direction")
            inner = (where([compare(Index("colour"), "==", others)], inner),)
        return inner


def first_of_colour(others, weight: int, step: int):
    """The least s0 with weight s0 + others = colour (mod step); the colour itself, 0 <= colour < step, where that says it."""
    inverse = pow(weight, -1, step)
    if others == ZERO and inverse == 1:
        return Index("colour")
    return modulo(inverse * (Index("colour") - others), step)


@lru_cache(maxsize=64)
def graph_name(over: Graph) -> str:
    """Graphs are told apart by their content, so that equal ones share their tables."""
    content = sha256(over.ends.tobytes())
    for name, values in over.columns:
        content.update(name.encode() + b"\0" + array("d", values).tobytes())
    return "graph_" + content.hexdigest()[:8]


def side_table(over: Graph, side: int) -> str:
    """The table of the edges that each site begins (0) or ends (1); `_end` their other ends, `_row` where those of a site stand."""
    return f"{graph_name(over)}_{('first', 'second')[side]}"
