"""Lattices: the shorthands chain, square, cubic and the declared ones of [lattices]."""
from __future__ import annotations

from dataclasses import dataclass

from ..language import limits
from ..language.expr import Expr
from ..language.spec import Lattice
from ..language import codes
from .formulas import Formulas
from .names import identifier, plural
from .problems import Problems, nearest
from .syntax import Name, Number
from .text import meaning
from .tree import Node

SHORT = {"chain": 1, "square": 2, "cubic": 3}
BOUNDARIES = ("periodic", "open")


@dataclass(frozen=True)
class Declaration:
    """A lattice of [lattices]: its cells, and its bond lists by name."""
    size: tuple[Expr, ...]
    periodic: tuple[bool, ...]
    sites: int
    bonds: dict


class Lattices:
    """The declared lattices; `over` makes the index family of a bond list."""

    def __init__(self, formulas: Formulas, problems: Problems):
        self.formulas, self.problems = formulas, problems
        self.known: dict[str, Declaration] = {}
        self.broken: set[str] = set()

    # [lattices.name]

    def declare(self, node: Node) -> None:
        self.broken.add(node.name)
        node.table("size", "boundary", "sites", "bonds", "meaning")
        name, lattice, _ = self.problems.together(
            lambda: identifier(self.problems, node.key, node.name, "lattice"),
            lambda: self.lattice(node), lambda: meaning(node, "meaning"))
        self.known[name] = lattice
        self.broken.discard(name)

    def lattice(self, node: Node) -> Declaration:
        size, sites = self.problems.together(
            lambda: self.sizes(node.need("size", 'give the cells per direction: `size = ["n"]`')),
            lambda: node.get("sites").integer(1, limits.CELL) if node.has("sites") else 1)
        periodic, bonds = self.problems.together(lambda: self.boundaries(node, len(size)),
                                                 lambda: self.bond_lists(node, sites, len(size)))
        return Declaration(size, periodic, sites, bonds)

    def sizes(self, node: Node) -> tuple[Expr, ...]:
        entries = node.entries("list of one size per direction", limits.DIMENSIONS)
        if not entries:
            node.wrong(codes.COUNT, "a lattice has at least one direction", 'write `size = ["n"]`')
        return tuple(self.problems.together(*(lambda e=e: self.formulas.count(e) for e in entries)))

    def boundaries(self, node: Node, dimensions: int) -> tuple[bool, ...]:
        child = node.need("boundary", 'write `boundary = "periodic"` or `"open"`')
        if isinstance(child.raw, list):
            entries = child.entries()
            if len(entries) != dimensions:
                child.wrong(codes.COUNT, f"{len(entries)} boundaries for "
                            f"{plural(dimensions, 'direction')}", "give one for each, or "
                            "one word for all")
            return tuple(self.boundary(e) for e in entries)
        return (self.boundary(child),) * dimensions

    def boundary(self, node: Node) -> bool:
        word = node.string()
        if word not in BOUNDARIES:
            node.wrong(codes.CHOICE, f"there is no boundary `{word}`", nearest(word, BOUNDARIES))
        return word == "periodic"

    def bond_lists(self, node: Node, sites: int, dimensions: int) -> dict:
        table = node.need("bonds", "write `bonds.name = [{ offset = [1] }]`").table()
        return dict(self.problems.together(*(lambda c=child: (c.name, self.bond_list(c, sites, dimensions))
                                             for child in table.items())))

    def bond_list(self, child: Node, sites: int, dimensions: int) -> tuple:
        identifier(self.problems, child.key, child.name, "bond list")
        entries = child.entries("list of bonds", limits.BONDS)
        if not entries:
            child.wrong(codes.BOND, f"`{child.label}` has no bonds", "write `[{ offset = [1] }]`")
        bonds = tuple(self.problems.together(*(lambda e=e: self.bond(e, sites, dimensions) for e in entries)))
        if len({len(b) for b in bonds}) > 1:
            child.wrong(codes.BOND, "all bonds of a list join the same number of sites",
                        "put the others into another list")
        return bonds

    def bond(self, node: Node, sites: int, dimensions: int) -> tuple:
        """((sub, offset), ...) for each site of the bond."""
        node.table("from", "to", "offset", "at")
        if node.has("at"):
            ends = tuple(self.end(e, sites, dimensions)
                         for e in node.get("at").entries("list of sites", limits.BOUND))
        else:
            first = self.sub(node, "from", sites), (0,) * dimensions
            ends = first, (self.sub(node, "to", sites), self.offset(node, dimensions))
        if len(ends) < 2 or len(set(ends)) < len(ends):
            node.wrong(codes.BOND, "a bond joins different sites",
                       "write `from` and `to`, or an `offset` that is not zero")
        return ends

    def sub(self, node: Node, key: str, sites: int) -> int:
        if not node.has(key):
            return 0
        child = node.get(key)
        if child.integer(0, limits.CELL) >= sites:
            child.wrong(codes.BOND, f"a cell has sites 0 to {sites - 1}, not {child.raw}",
                        "set `sites` to the number of sites in a cell")
        return child.raw

    def offset(self, node: Node, dimensions: int) -> tuple[int, ...]:
        child = node.need("offset", f"write `offset = {[0] * dimensions}`")
        entries = child.entries("list of one offset per direction")
        if len(entries) != dimensions:
            child.wrong(codes.BOND, f"{plural(len(entries), 'offset')} for "
                        f"{plural(dimensions, 'direction')}", "give one for each direction")
        return tuple(e.integer(-limits.REACH, limits.REACH) for e in entries)

    def end(self, node: Node, sites: int, dimensions: int) -> tuple:
        """`[sub, offset, ...]`: one site of a bond written with `at`."""
        entries = node.entries("list `[site, offset, ...]`")
        if len(entries) != 1 + dimensions:
            node.wrong(codes.BOND, f"a site is 1 + {dimensions} integers: its number in the "
                       "cell, then the cell's offset", f"write `{[0] * (1 + dimensions)}`")
        if entries[0].integer(0, limits.CELL) >= sites:
            entries[0].wrong(codes.BOND, f"a cell has sites 0 to {sites - 1}",
                             "set `sites` to the number of sites in a cell")
        return entries[0].raw, tuple(e.integer(-limits.REACH, limits.REACH)
                                     for e in entries[1:])

    # over = "bond(i, j) of ..."

    def over(self, w, reader) -> Lattice:
        family = reader.home(w)
        if w.args is not None:
            return self.short(w, family)
        lattice = self.lookup(w)
        lists = lattice.bonds
        if w.member is None and len(lists) > 1:
            self.problems.fail(codes.OVER, w.target.span, f"`{w.target.text}` has several bond "
                               f"lists", f"write `{w.target.text}.{next(iter(lists))}`")
        if w.member is not None and w.member.text not in lists:
            self.problems.fail(codes.UNKNOWN_NAME, w.member.span, f"lattice `{w.target.text}` has "
                               f"no bonds `{w.member.text}`", nearest(w.member.text, lists))
        bonds = lists[w.member.text] if w.member else next(iter(lists.values()))
        indices = self.matched(w, len(bonds[0]))
        return Lattice(indices, lattice.size, lattice.periodic, lattice.sites, bonds, family)

    def lookup(self, w) -> Declaration:
        name = w.target.text
        if name not in self.known:
            if name in self.broken:
                self.formulas.silently()
            self.problems.fail(codes.UNKNOWN_NAME, w.target.span, f"there is no lattice `{name}`",
                               nearest(name, list(self.known) + list(SHORT)))
        return self.known[name]

    def matched(self, w, ends: int) -> tuple[str, ...]:
        if len(w.items) != ends:
            self.problems.fail(codes.OVER, w.head.span, f"these bonds join {ends} sites, but "
                               f"{len(w.items)} are bound", "name one index for each site")
        return tuple(i.text for i, _ in w.items)

    def short(self, w, family: str) -> Lattice:
        """`chain(n, periodic, 2)`, `square(nx, ny, open)`, `cubic(nx, ny, nz, periodic)`."""
        name = w.target.text
        if name not in SHORT:
            self.problems.fail(codes.OVER, w.target.span, f"there is no lattice `{name}(...)`",
                               nearest(name, SHORT))
        d = SHORT[name]
        sizes, rest = w.args[:d], w.args[d:]
        distance = self.distance(rest.pop()) if name == "chain" and len(rest) > 1 else 1
        if len(sizes) < d or len(rest) not in (1, d):
            self.problems.fail(codes.OVER, w.target.span, f"`{name}` takes {d} size"
                               f"{'s' * (d > 1)} and a boundary", self.form(name))
        periodic = tuple(self.word(b, name) for b in rest) * (d // len(rest))
        size = tuple(self.formulas.count_of(s) for s in sizes)
        steps = [tuple(distance * (k == j) for k in range(d)) for j in range(d)]
        bonds = tuple(((0, (0,) * d), (0, step)) for step in steps)
        return Lattice(self.matched(w, 2), size, periodic, 1, bonds, family)

    def form(self, name: str) -> str:
        return {"chain": "write `chain(n, periodic)`, `chain(n, open)` or, for neighbours at "
                "distance 2, `chain(n, periodic, 2)`",
                "square": "write `square(nx, ny, periodic)` or `square(nx, ny, open, periodic)`",
                "cubic": "write `cubic(nx, ny, nz, periodic)`"}[name]

    def word(self, node, name: str) -> bool:
        if not isinstance(node, Name) or node.name not in BOUNDARIES:
            self.problems.fail(codes.OVER, node.span, "a boundary is `periodic` or `open`",
                               self.form(name))
        return node.name == "periodic"

    def distance(self, node) -> int:
        whole = isinstance(node, Number) and isinstance(node.value, int)
        if not whole or not 1 <= node.value <= limits.REACH:
            self.problems.fail(codes.BOND, node.span, "the distance of neighbours is a whole "
                               f"number from 1 to {limits.REACH}", self.form("chain"))
        return node.value
