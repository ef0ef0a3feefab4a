"""Lattices: those by name, `honeycomb(n, m, periodic)`, and the declared ones of [lattices]."""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce

from ..language import limits
from ..language.crystals import CRYSTALS
from ..language.expr import Expr, Num, Op
from ..language.shells import SHELLS
from ..language.spec import Lattice, Places, Sites
from ..language import codes
from .formulas import Formulas
from .names import identifier, plural
from .places import KEYS, PlaceReader, places_of, shell_of
from .problems import Problems, nearest
from .syntax import Name, Number
from .text import meaning
from .tree import Node, describe

SIZES = ("n", "nx, ny", "nx, ny, nz")      # by directions, as examples have them
BOUNDARIES = ("periodic", "open")
HOW_BONDS = "write `bonds.name = [{ offset = [1] }]`"


@dataclass(frozen=True)
class Declaration:
    """A lattice of [lattices]: its cells, its bond lists by name, where its sites stand, and what those of a cell are called."""
    size: tuple[Expr, ...]
    periodic: tuple[bool, ...]
    sites: int
    bonds: dict
    places: Places | None = None
    names: tuple[str, ...] = ()


class Lattices:
    """The declared lattices; `over` makes the index family of a bond list."""

    def __init__(self, formulas: Formulas, problems: Problems):
        self.formulas, self.problems = formulas, problems
        self.known: dict[str, Declaration] = {}
        self.broken: set[str] = set()

    # [lattices.name]

    def declare(self, node: Node) -> None:
        self.broken.add(node.name)
        node.table("size", "boundary", "sites", "bonds", "meaning", *KEYS)
        name, lattice, _ = self.problems.together(
            lambda: identifier(self.problems, node.key, node.name, "lattice"),
            lambda: self.lattice(node), lambda: meaning(node, "meaning"))
        self.known[name] = lattice
        self.broken.discard(name)

    def lattice(self, node: Node) -> Declaration:
        size, (sites, names) = self.problems.together(
            lambda: self.sizes(node.need("size", 'give the number of cells in each direction: `size = ["n"]`')), lambda: self.of_cell(node))
        periodic, places = self.problems.together(
            lambda: self.boundaries(node, len(size)),
            lambda: PlaceReader(self.formulas, self.problems).read(node, len(size), sites))
        sites, places = self.sites(node, sites, places), places and replace(places, names=names)
        return Declaration(size, periodic, sites, self.bond_lists(node, sites, len(size), places), places, names)

    def of_cell(self, node: Node) -> tuple:
        """(the number of sites or None, their names)."""
        if not node.has("sites") or not isinstance(node.get("sites").raw, list):
            return node.get("sites").integer(1, limits.CELL) if node.has("sites") else None, ()
        entries = node.get("sites").entries("list of names", limits.CELL)
        names = tuple(identifier(self.problems, e.key, e.string(), "site of a cell") for e in entries)
        if not names or len(set(names)) < len(names):
            node.get("sites").wrong(codes.CLASH, "the sites of a cell must have different names", 'write `sites = ["a", "b"]`, or their number')
        return len(names), names

    def sites(self, node: Node, sites: int | None, places: Places | None) -> int:
        """Of a cell."""
        if places is None:
            return sites or 1
        if sites not in (None, len(places.positions)):
            node.get("sites").wrong(codes.CONFLICT, f"a cell of `{places.name}` has {plural(len(places.positions), 'site')}", "remove `sites`")
        return len(places.positions)

    def sizes(self, node: Node) -> tuple[Expr, ...]:
        entries = node.entries("list of one size per direction", limits.DIMENSIONS)
        if not entries:
            node.wrong(codes.COUNT, "a lattice must have at least one direction", 'write `size = ["n"]`')
        return tuple(self.problems.together(*(lambda e=e: self.formulas.count(e) for e in entries)))

    def boundaries(self, node: Node, dimensions: int) -> tuple[bool, ...]:
        if not node.has("boundary"):
            return (True,) * dimensions
        child = node.get("boundary")
        if isinstance(child.raw, list):
            entries = child.entries()
            if len(entries) != dimensions:
                child.wrong(codes.COUNT, f"{len(entries)} boundaries for "
                            f"{plural(dimensions, 'direction')}", "give one for each direction, or one word for all")
            return tuple(self.boundary(e) for e in entries)
        return (self.boundary(child),) * dimensions

    def boundary(self, node: Node) -> bool:
        word = node.string()
        if word not in BOUNDARIES:
            node.wrong(codes.CHOICE, f"there is no boundary `{word}`", nearest(word, BOUNDARIES))
        return word == "periodic"

    def bond_lists(self, node: Node, sites: int, dimensions: int, places: Places | None) -> dict:
        if places is not None and not node.has("bonds"):
            return {}
        table = node.need("bonds", HOW_BONDS)
        if isinstance(table.raw, list):
            table.wrong(codes.TYPE, f"the list of bonds `{table.label}` must have a name", HOW_BONDS)
        table.table()
        return dict(self.problems.together(*(lambda c=child: (c.name, self.bond_list(c, sites, dimensions))
                                             for child in table.items())))

    def bond_list(self, child: Node, sites: int, dimensions: int) -> tuple:
        identifier(self.problems, child.key, child.name, "bond list")
        entries = child.entries("list of bonds", limits.BONDS)
        if not entries:
            child.wrong(codes.BOND, f"`{child.label}` has no bonds", "write `[{ offset = [1] }]`")
        bonds = tuple(self.problems.together(*(lambda e=e: self.bond(e, sites, dimensions) for e in entries)))
        if len({len(b) for b in bonds}) > 1:
            child.wrong(codes.BOND, "all bonds of a list must join the same number of sites",
                        "move the others to another list")
        return bonds

    def bond(self, node: Node, sites: int, dimensions: int) -> tuple:
        """((sub, offset), ...) for each site of the bond."""
        if not isinstance(node.raw, dict):
            node.wrong(codes.TYPE, f"`{node.label}` must be a table, not {describe(node.raw)}",
                       f"a bond is written `{{ from = 0, to = 1, offset = {[0] * dimensions} }}`")
        node.table("from", "to", "offset", "at")
        if node.has("at"):
            ends = tuple(self.end(e, sites, dimensions)
                         for e in node.get("at").entries("list of sites", limits.BOUND))
        else:
            first = self.sub(node, "from", sites), (0,) * dimensions
            ends = first, (self.sub(node, "to", sites), self.offset(node, dimensions))
        if len(ends) < 2 or len(set(ends)) < len(ends) != 2:
            node.wrong(codes.BOND, "a bond must join different sites",
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
            node.wrong(codes.BOND, f"a site is given by 1 + {dimensions} integers: its number in the cell and the offset of the cell", f"write `{[0] * (1 + dimensions)}`")
        if entries[0].integer(0, limits.CELL) >= sites:
            entries[0].wrong(codes.BOND, f"a cell has sites 0 to {sites - 1}",
                             "set `sites` to the number of sites in a cell")
        return entries[0].raw, tuple(e.integer(-limits.REACH, limits.REACH)
                                     for e in entries[1:])

    def home(self, node: Node) -> tuple:
        """(the number of its sites, itself) for a family that lies on a lattice."""
        lattice = self.known[node.raw]
        factors = [Num(lattice.sites)] * (lattice.sites > 1) + list(lattice.size)
        count = reduce(lambda a, b: Op("*", (a, b)), factors)
        return count, Lattice((), lattice.size, lattice.periodic, lattice.sites, (), "", lattice.places)

    # over = "bond(i, j) of ..."

    def over(self, w, reader) -> Lattice:
        families = self.families(w, reader)
        family = families[0] if len(set(families)) == 1 else ""
        if w.args is not None:
            found = self.short(w, family)
        else:
            lattice = self.lookup(w)
            bonds = self.bonds_of(w, lattice)
            indices, number = self.matched(w, len(bonds[0]))
            found = Lattice(indices, lattice.size, lattice.periodic, lattice.sites, bonds, family, lattice.places, number)
        return self.between(w, found, families)

    @staticmethod
    def families(w, reader) -> tuple[str, ...]:
        """Of the ends: one of all, or one of each."""
        if all(family is None for _, family in w.items):
            return (reader.home(w),)
        if w.family:
            reader.problems.fail(codes.OVER, w.family.span, "the indices already name their families", "drop `on`")
        return tuple(reader.family(family) for _, family in w.items if family)

    def between(self, w, over: Lattice, families) -> Lattice:
        """With the families of its ends, where they are several."""
        if len(families) > 1 or w.items[0][1]:
            named = [family is not None for _, family in w.items]
            if named != [True] * len(over.indices) + [False] * bool(over.number):
                self.problems.fail(codes.OVER, w.head.span, "either every site of the bond has a family, or none has", "write `bond(i of a, j of b) of LATTICE`")
        over = over if over.family else replace(over, families=families)
        if over.family and any(len(set(bond)) < len(bond) for bond in over.bonds):
            self.problems.fail(codes.BOND, w.target.span, "a bond must join different sites, but one of these has two equal ends",
                               "write `from` and `to` or an `offset` that is not zero, or join two families, `bond(i of a, j of b)`")
        return over

    def sublattice(self, w, index: str, family: str):
        """The sites of a cell with a name: `site(i) of honey.a`."""
        lattice = self.lookup(w)
        if w.member.text not in lattice.names:
            self.problems.fail(codes.UNKNOWN_NAME, w.member.span, f"no site in a cell of `{w.target.text}` is called `{w.member.text}`",
                               nearest(w.member.text, lattice.names) if lattice.names else 'give the sites of a cell names: `sites = ["a", "b"]`')
        if lattice.sites == 1:
            return Sites(index, family)
        place = (lattice.names.index(w.member.text), (0,) * len(lattice.size))
        return Lattice((index,), lattice.size, lattice.periodic, lattice.sites, ((place,),), family, lattice.places)

    def bonds_of(self, w, lattice: Declaration) -> tuple:
        """A list of bonds by its name, or a shell."""
        lists, shells = lattice.bonds, SHELLS if lattice.places else ()
        if lattice.places and (w.member.text not in lists and w.member.text in shells if w.member else not lists):
            return shell_of(lattice.places, len(lattice.size), w.member or w.target, self.problems)
        if w.member is None and len(lists) > 1:
            self.problems.fail(codes.OVER, w.target.span, f"`{w.target.text}` has several bond "
                               f"lists", f"write `{w.target.text}.{next(iter(lists))}`")
        if w.member is not None and w.member.text not in lists:
            self.problems.fail(codes.UNKNOWN_NAME, w.member.span, f"lattice `{w.target.text}` has "
                               f"no bonds `{w.member.text}`", nearest(w.member.text, [*lists, *shells]))
        return lists[w.member.text] if w.member else next(iter(lists.values()))

    def lookup(self, w) -> Declaration:
        name = w.target.text
        if name not in self.known:
            if name in self.broken:
                self.formulas.silently()
            self.problems.fail(codes.UNKNOWN_NAME, w.target.span, f"there is no lattice `{name}`",
                               nearest(name, [*self.known, *CRYSTALS]))
        return self.known[name]

    def matched(self, w, ends: int) -> tuple[tuple[str, ...], str]:
        """(an index for each end, one for the number of the bond or "")."""
        names = tuple(i.text for i, _ in w.items)
        if not ends <= len(names) <= ends + 1:
            self.problems.fail(codes.OVER, w.head.span, f"these bonds join {ends} sites, but {len(names)} indices are given",
                               "bind one index for each site, and optionally one for the number of the bond")
        return names[:ends], "".join(names[ends:])

    def short(self, w, family: str) -> Lattice:
        """`chain(n, periodic, 2)`, `square(nx, ny, open)`, `honeycomb(nx, ny, periodic).second`."""
        name = w.target.text
        if name not in CRYSTALS:
            self.problems.fail(codes.OVER, w.target.span, f"there is no lattice `{name}(...)`",
                               nearest(name, CRYSTALS))
        d = CRYSTALS[name].directions
        sizes, rest = w.args[:d], w.args[d:]
        distance = self.distance(rest.pop()) if name == "chain" and len(rest) > 1 else 1
        early = any(isinstance(s, Name) and s.name in BOUNDARIES for s in sizes)
        if early or len(sizes) < d or len(rest) not in (0, 1, d):
            self.problems.fail(codes.OVER, w.target.span, f"`{name}` takes {d} size"
                               f"{'s' * (d > 1)} and a boundary", self.form(name))
        periodic = tuple(self.word(b, name) for b in rest) * (d // len(rest)) if rest else (True,) * d
        size = tuple(self.formulas.count_of(s) for s in sizes)
        places = replace(places_of(name), assumed=True)
        bonds = self.shell(w, places, d) if distance == 1 else self.farther(w, distance)
        indices, number = self.matched(w, 2)
        return Lattice(indices, size, periodic, len(places.positions), bonds, family, places, number)

    def shell(self, w, places: Places, d: int) -> tuple:
        if w.member and w.member.text not in SHELLS:
            self.problems.fail(codes.UNKNOWN_NAME, w.member.span, f"there is no shell `{w.member.text}`", nearest(w.member.text, SHELLS))
        return shell_of(places, d, w.member or w.target, self.problems)

    def farther(self, w, distance: int) -> tuple:
        """Of a chain."""
        if w.member:
            self.problems.fail(codes.OVER, w.member.span, "the distance of these neighbours is already given", "write `chain(n, periodic).second`")
        return (((0, (0,)), (0, (distance,))),)

    def form(self, name: str) -> str:
        if name == "chain":
            return "write `chain(n, periodic)`, `chain(n, open)` or, for neighbours at distance 2, `chain(n, periodic, 2)`"
        sizes = SIZES[CRYSTALS[name].directions - 1]
        other = f" or `{name}({sizes}, {', '.join(['open', 'periodic', 'periodic'][:CRYSTALS[name].directions])})`" if CRYSTALS[name].directions == 2 else ""
        return f"write `{name}({sizes}, periodic)`" + other

    def word(self, node, name: str) -> bool:
        if not isinstance(node, Name) or node.name not in BOUNDARIES:
            self.problems.fail(codes.OVER, node.span, "a boundary must be `periodic` or `open`",
                               self.form(name))
        return node.name == "periodic"

    def distance(self, node) -> int:
        whole = isinstance(node, Number) and isinstance(node.value, int)
        if not whole or not 1 <= node.value <= limits.REACH:
            self.problems.fail(codes.BOND, node.span, "the distance of neighbours must be a whole "
                               f"number from 1 to {limits.REACH}", self.form("chain"))
        return node.value
