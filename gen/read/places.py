"""Where the sites of a declared lattice stand: `name = "kagome"`, or `vectors` and `positions`; and shells by their names."""
from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import UsageError
from ..language import codes, limits
from ..language.crystals import CRYSTALS
from ..language.evaluate import evaluate
from ..language.shells import SAME, SHELLS, Unclear, shell
from ..language.spec import Places
from ..language.units import LENGTH, NONE, unit
from .formulas import Formulas
from .names import plural
from .problems import Problems, nearest
from .tree import Node

KEYS = ("name", "vectors", "positions", "constant")
FLAT = 1e-9         # a volume below it, of unit vectors, is 0


class PlaceReader:
    """Reads these keys of a lattice."""

    def __init__(self, formulas: Formulas, problems: Problems):
        self.formulas, self.problems = formulas, problems

    def read(self, node: Node, directions: int, sites: int | None) -> Places | None:
        """None where the lattice gives no positions; sites: in a cell, where the lattice says so."""
        if node.has("name"):
            return self.named(node, directions)
        if not node.has("vectors"):
            self.idle(node)
            return None
        rows = node.get("vectors").entries("list of vectors", 3)
        length = self.length_of(rows)
        vectors, (value, measured) = self.problems.together(lambda: self.vectors(node, rows, directions, NONE if length is None else LENGTH), lambda: self.constant(node))
        if length is not None and measured:
            node.get("constant").wrong(codes.CONFLICT, "the vectors are lengths, but so is the constant", "remove `constant`, or write the vectors without units")
        length = node.get("constant") if measured else length
        positions = self.positions(node, vectors, directions, sites)
        return checked(Places(scaled(vectors, value), positions, measured=length is not None, unit=length_in(length)), node, directions)

    def length_of(self, rows: list[Node]) -> Node | None:
        """The first entry of the vectors that is a length; None where they are numbers."""
        if self.formulas.declared.units is None:
            return None
        entries = [entry for row in rows if isinstance(row.raw, list) for entry in row.entries() if isinstance(entry.raw, str)]
        return next((e for e in entries if self.formulas.measured(e, "a lattice vector").dimension == LENGTH), None)

    def idle(self, node: Node) -> None:
        for key in ("positions", "constant"):
            if node.has(key):
                node.get(key).wrong(codes.MISSING, f"`{node.label}` has `{key}` but no `vectors`",
                                    'give `vectors = [[1, 0], [0, 1]]`, or the `name` of a lattice')

    def named(self, node: Node, directions: int) -> Places:
        """Of a lattice of the table."""
        child, name = node.get("name"), node.get("name").string()
        for key in ("vectors", "positions"):
            if node.has(key):
                node.get(key).wrong(codes.CONFLICT, f"a {name} lattice has its own `{key}`", f"remove `{key}` or `name`")
        if name not in CRYSTALS:
            child.wrong(codes.CHOICE, f"there is no lattice `{name}`", nearest(name, CRYSTALS))
        if CRYSTALS[name].directions != directions:
            node.get("size").wrong(codes.COUNT, f"`{name}` has {plural(CRYSTALS[name].directions, 'direction')}, `size` has {directions}",
                                   "give one size for each direction")
        value, measured = self.constant(node)
        return replace(places_of(name, value), measured=measured, unit=length_in(node.get("constant") if measured else None))

    def constant(self, node: Node) -> tuple[float, bool]:
        """(the unit of length of the vectors, is it one with a unit?)."""
        if not node.has("constant"):
            return 1.0, False
        child = node.get("constant")
        measured = self.formulas.declared.units is not None and self.formulas.measured(child, "a lattice constant").dimension == LENGTH
        value = self.number(child, "a lattice constant", LENGTH if measured else NONE)
        if not value > 0:
            child.wrong(codes.VALUE, f"the lattice constant is {value:g}", "it must be a positive length")
        return value, measured

    def number(self, node: Node, what: str = "a lattice vector or position", wanted=NONE) -> float:
        """A number, or a formula without names, such as "sqrt(3)/2"."""
        try:
            value = float(evaluate(self.formulas.free(node, what, wanted=wanted), {}))
        except UsageError:
            node.wrong(codes.NOT_HERE, "vectors and positions must be numbers, without parameters", 'such as `0.5` or `"sqrt(3)/2"`')
        if not abs(value) <= limits.LARGEST:
            node.wrong(codes.VALUE, f"`{node.label}` is {value:g}", "give a finite number")
        return value

    def row(self, node: Node, most: int, wanted=NONE) -> tuple[float, ...]:
        return tuple(self.problems.together(*(lambda e=e: self.number(e, wanted=wanted) for e in node.entries("row of numbers", most))))

    def vectors(self, node: Node, rows: list[Node], directions: int, wanted) -> tuple:
        """Rows (x, y, z), linearly independent; wanted: their dimension, a length or none."""
        child = node.get("vectors")
        found = self.problems.together(*(lambda r=r: self.row(r, 3, wanted) for r in rows))
        if len(found) < directions:
            child.wrong(codes.COUNT, f"{plural(len(found), 'vector')} for {plural(directions, 'direction')}",
                        "give one vector for each direction; one more may follow, for positions out of their plane or line")
        length = max(map(len, found))
        for row, numbers in zip(rows, found):
            if len(numbers) != length or not length:
                row.wrong(codes.COUNT, f"this vector has {plural(len(numbers), 'component')}, but another has {length}", "give all of them two components, or all three")
            if not any(numbers):
                row.wrong(codes.VALUE, "this vector is zero", "neighbouring cells must not coincide")
        padded = np.zeros((len(found), 3))
        padded[:, :length] = found
        units = padded / np.linalg.norm(padded, axis=1, keepdims=True)
        if len(found) > length or np.linalg.det(units @ units.T) < FLAT:
            child.wrong(codes.VALUE, "these vectors are linearly dependent: cells would overlap", "give vectors that span a cell")
        return tuple(map(tuple, padded.tolist()))

    def positions(self, node: Node, vectors: tuple, directions: int, sites: int | None) -> tuple:
        """Fractions of the vectors, of each site of a cell."""
        if not node.has("positions"):
            if sites not in (None, 1):
                node.get("vectors").wrong(codes.MISSING, f"a cell of `{node.label}` has {sites} sites, which need positions",
                                          "give `positions`, a row of fractions of the vectors for each site")
            return ((0.0,) * len(vectors),)
        child = node.get("positions")
        rows = child.entries("list of positions", limits.CELL)
        if not rows or sites not in (None, len(rows)):
            child.wrong(codes.COUNT, f"{plural(len(rows), 'position')} for {plural(sites or 1, 'site')} of a cell", "give one for each site, and remove `sites`")
        return tuple(self.problems.together(*(lambda r=r: self.position(r, len(vectors), directions) for r in rows)))

    def position(self, node: Node, count: int, directions: int) -> tuple:
        found = self.row(node, 3)
        if len(found) != count:
            node.wrong(codes.COUNT, f"this position has {plural(len(found), 'number')} for {plural(count, 'vector')}", "give a fraction of each vector")
        for k, value in enumerate(found[:directions]):
            if not 0 <= value < 1:
                node.wrong(codes.VALUE, f"this position lies outside the cell: {value:.6g} of vector {k + 1}",
                           f"fractions must be at least 0 and less than 1; the equivalent site of this cell is at {value % 1:.6g}")
        return found


def length_in(node: Node | None) -> str:
    """The unit in which a length is written, `angstrom` of "3 angstrom"; "" of any other text."""
    word = node.raw.split()[-1] if node is not None and isinstance(node.raw, str) and node.raw.strip() else ""
    found = unit(word)
    return word if found is not None and found.dimension == LENGTH else ""


def scaled(vectors, constant: float) -> tuple:
    return tuple(tuple(constant * float(x) for x in row) for row in vectors)


def places_of(name: str, constant: float = 1.0) -> Places:
    """Of a lattice of the table."""
    crystal = CRYSTALS[name]
    return Places(scaled(crystal.vectors, constant), tuple(tuple(map(float, row)) for row in crystal.positions), name)


def checked(places: Places, node: Node, directions: int) -> Places:
    """Sites of their own places."""
    at = np.array(places.positions)
    for k, row in enumerate(at):
        apart = at[:k] - row
        apart[:, :directions] -= np.rint(apart[:, :directions])
        close = np.flatnonzero(np.abs(apart).max(axis=1, initial=0) < SAME)
        if close.size:
            node.get("positions").wrong(codes.VALUE, f"sites {close[0]} and {k} of a cell are at the same position", "give each site a different position")
    return places


def shell_of(places: Places, directions: int, token, problems: Problems) -> tuple:
    """The bonds of a shell by its name; token: where it stands, the lattice itself for the first."""
    name = token.text if token.text in SHELLS else SHELLS[0]
    try:
        bonds = shell(places.vectors, places.positions, directions, SHELLS.index(name))
    except Unclear as reason:
        problems.fail(codes.BOND, token.span, str(reason), 'give more digits, such as "sqrt(3)/2", or list the bonds')
    if len(bonds) > limits.BONDS:
        problems.fail(codes.LIMIT, token.span, f"this shell has {len(bonds)} bonds per cell; at most {limits.BONDS} are allowed", "choose a nearer shell")
    return bonds
