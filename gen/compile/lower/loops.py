"""Index families as C loops: the sum over an orbit, never written out.

`scatter` visits every term once; `gather` visits, for one site, the terms in which it takes part.
A body is a function of `Instance`: the C text of each bound index.
"""
from __future__ import annotations

from dataclasses import dataclass

from ...language.spec import Each, Graph, Lattice, Once, Pairs, Sites


@dataclass(frozen=True)
class Instance:
    """One term of the sum: index name -> C text of the site's number in its family."""
    index: dict


def indent(lines, by: int = 1):
    return ["  " * by + line for line in lines]


def block(head: str, lines):
    return [f"{head} {{".lstrip(), *indent(lines), "}"]


def loop(name: str, end: str, lines, start: str = "0"):
    return block(f"for (int64_t {name} = {start}; {name} < {end}; ++{name})", lines)


class Loops:
    """Writes loops for one model; `low` gives sizes, `count(family)` the text of a family's size."""

    def __init__(self, low, count):
        self.low, self.count = low, count

    # -- every term once --------------------------------------------------------------------
    def scatter(self, over, body):
        return getattr(self, "scatter_" + type(over).__name__.lower())(over, body)

    def scatter_once(self, over: Once, body):
        return body(Instance({}))

    def scatter_sites(self, over: Sites, body):
        return loop(over.index, self.count(over.family), body(Instance({over.index: over.index})))

    def scatter_pairs(self, over: Pairs, body):
        n, i, j = self.count(over.family), over.first, over.second
        inner = loop(j, n, body(Instance({i: i, j: j})), start=f"{i} + 1")
        return loop(i, n, inner)

    def scatter_each(self, over: Each, body):
        lines = body(Instance({i: i for i in over.indices}))
        for i, family in reversed(list(zip(over.indices, over.families))):
            lines = loop(i, self.count(family), lines)
        return lines

    def scatter_graph(self, over: Graph, body):
        i, j, name = over.first, over.second, graph_name(over)
        head = [f"const int64_t {i} = {name}_edge[e][0];",
                f"const int64_t {j} = {name}_edge[e][1];"]
        return loop("e", str(len(over.edges)), head + self.weights(over) + body(Instance({i: i, j: j})))

    def weights(self, over: Graph):
        name = graph_name(over)
        return [f"const smg_real weight_{c} = {name}_{c}[e];" for c, _ in over.columns]

    def scatter_lattice(self, over: Lattice, body):
        cells = [f"c{d}" for d in range(len(over.size))]
        lines = []
        for bond in over.bonds:
            lines += self.bond(over, bond, cells, range(len(bond)), body)
        for d, size in enumerate(over.size):        # direction 0 is the fastest: innermost
            lines = loop(f"c{d}", self.low.size(size), lines)
        return lines

    # -- lattice bonds ----------------------------------------------------------------------
    def bond(self, over: Lattice, bond, cells, given, body):
        """One term from its base cell `cells`, inside a test where open ends may cut it off."""
        tests, lines = [], []
        for name, (sub, offset) in zip(over.indices, bond):
            lines += self.site(over, name, sub, offset, cells, tests)
        lines += body(Instance({i: i for i in over.indices}))
        if tests:
            return block("if (" + " && ".join(dict.fromkeys(tests)) + ")", lines)
        return block("", lines)

    def site(self, over: Lattice, name: str, sub: int, offset, cells, tests):
        """Statements that compute the number of the site `sub` in the cell at `offset`."""
        lines, text = [], []
        for d, (cell, shift) in enumerate(zip(cells, offset)):
            size = self.low.size(over.size[d])
            moved = cell if shift == 0 else f"{cell} {'+' if shift > 0 else '-'} {abs(shift)}"
            if shift and over.periodic[d]:
                moved = f"smg_wrap({moved}, {size})"
            elif shift:
                tests.append(f"{moved} < {size}" if shift > 0 else f"{moved} >= 0")
            text.append(moved)
        number = text[-1]
        for d in range(len(cells) - 2, -1, -1):
            number = f"{text[d]} + {self.low.size(over.size[d])}*({number})"
        if over.sites > 1:
            number = f"({number})*{over.sites} + {sub}"
        return [*lines, f"const int64_t {name} = {number};"]

    # -- the terms of one site --------------------------------------------------------------
    def gather(self, over, slot, body, placed: bool = False):
        """Terms in which site `i` (C variable `site`) stands at `slot` = (family, index name).

        placed: the site's cell s0, s1, .. and place `sub` are variables already.
        """
        if isinstance(over, Lattice):
            return self.gather_lattice(over, slot, body, placed)
        return getattr(self, "gather_" + type(over).__name__.lower())(over, slot, body)

    def gather_once(self, over: Once, slot, body):
        return block(f"if (site == {slot[1]})", body(Instance({})))

    def gather_sites(self, over: Sites, slot, body):
        return block("", [f"const int64_t {over.index} = site;", *body(Instance({over.index: over.index}))])

    def gather_pairs(self, over: Pairs, slot, body):
        n, own = self.count(over.family), slot[1]
        inner = [f"const int64_t {own} = site;", *body(Instance({over.first: over.first,
                                                                  over.second: over.second}))]
        if own == over.first:
            return loop(over.second, n, inner, start="site + 1")
        return loop(over.first, "site", inner)

    def gather_each(self, over: Each, slot, body):
        lines = [f"const int64_t {slot[1]} = site;", *body(Instance({i: i for i in over.indices}))]
        for i, family in reversed(list(zip(over.indices, over.families))):
            if i != slot[1]:
                lines = loop(i, self.count(family), lines)
        return block("", lines)

    def gather_graph(self, over: Graph, slot, body):
        """Adjacency rows: for each site the edges that it begins (or ends)."""
        i, j, name = over.first, over.second, graph_name(over)
        side = "first" if slot[1] == i else "second"
        head = [f"const int64_t e = {name}_{side}[row];",
                f"const int64_t {i} = {name}_edge[e][0];",
                f"const int64_t {j} = {name}_edge[e][1];"]
        sites = 1 + max((max(e) for e in over.edges), default=0)     # later sites have no edge and no row
        return block(f"if (site < {sites})", loop(
            "row", f"{name}_{side}_row[site + 1]",
            head + self.weights(over) + body(Instance({i: i, j: j})),
            start=f"{name}_{side}_row[site]"))

    def gather_lattice(self, over: Lattice, slot, body, placed: bool = False):
        lines = [] if placed else self.cell_of_site(over)
        position = over.indices.index(slot[1])
        for bond in over.bonds:
            lines += self.gather_bond(over, bond, position, body)
        return block("", lines)

    def cell_of_site(self, over: Lattice):
        """The coordinates of the cell that holds the site, and its place in the cell."""
        lines = [f"const int64_t sub = site % {over.sites};"] if over.sites > 1 else []
        rest = f"site / {over.sites}" if over.sites > 1 else "site"
        for d in range(len(over.size) - 1):
            size = self.low.size(over.size[d])
            lines += [f"const int64_t r{d} = {rest};", f"const int64_t s{d} = r{d} % {size};"]
            rest = f"r{d} / {size}"
        return [*lines, f"const int64_t s{len(over.size) - 1} = {rest};"]

    def by_colour(self, over: Lattice, colours, body):
        """All sites of a lattice, colour after colour; `body(sub)` finds site, s0, s1, .. set."""
        lines = []
        for sub in range(over.sites):
            lines += self.one_place(over, colours, sub, body)
        return loop("colour", str(colours.colours), lines) if colours.colours > 1 else lines

    def one_place(self, over: Lattice, colours, sub: int, body):
        cells = [f"s{d}" for d in range(len(over.size))]
        inner = self.site(over, "site", sub, (0,) * len(cells), cells, []) + body(sub)
        step, w = colours.colours, colours.weights
        others = " + ".join([f"{w[d]}*s{d}" for d in range(1, len(cells)) if w[d]] + [str(colours.shift[sub])])
        for d, size in enumerate(over.size):
            end = self.low.size(size)
            if d == 0 and w[0] and step > 1:    # the cells of this colour: s0 = inverse*(colour - others)
                inverse = pow(w[0], -1, step)
                start = f"smg_mod({inverse}*(colour - ({others})), {step})"
                inner = block(f"for (int64_t s0 = {start}; s0 < {end}; s0 += {step})", inner)
            else:
                inner = loop(f"s{d}", end, inner)
        if step > 1 and not w[0]:
            inner = self.whole_rows(colours, others, inner)
        return inner

    def whole_rows(self, colours, others: str, inner):
        if any(colours.weights):
            raise ValueError("a colouring that leaves out the fastest direction")
        return block(f"if (colour == {others})", inner)

    def gather_bond(self, over: Lattice, bond, position: int, body):
        sub, offset = bond[position]
        tests = [f"sub == {sub}"] if over.sites > 1 else []
        lines, cells = [], []
        for d, shift in enumerate(offset):
            cells.append(f"b{d}")
            size = self.low.size(over.size[d])
            moved = f"s{d}" if shift == 0 else f"s{d} {'-' if shift > 0 else '+'} {abs(shift)}"
            if shift and over.periodic[d]:
                moved = f"smg_wrap({moved}, {size})"
            elif shift:
                tests.append(f"{moved} >= 0" if shift > 0 else f"{moved} < {size}")
            lines.append(f"const int64_t b{d} = {moved};")
        lines += self.bond(over, bond, cells, (), body)
        return block("if (" + " && ".join(tests) + ")" if tests else "", lines)


def graph_name(over: Graph) -> str:
    """Graphs are told apart by their content, so that equal ones share their tables."""
    from hashlib import sha256
    return "graph_" + sha256(repr((over.edges, over.columns)).encode()).hexdigest()[:8]
