"""Graphs: edge tables in files, `edge(i, j, K) of g`."""
from __future__ import annotations

from operator import eq, itemgetter

from ..language import limits
from ..language.expr import Num
from ..language.spec import Graph
from ..language import codes
from .files import Files
from .formulas import Formulas
from .names import identifier
from .problems import Problems, nearest
from .text import meaning
from .tree import Node

POSITIONS = "rows `x, y` or `x, y, z`, one for each site"
TABLE = "rows `i, j` or `i, j, weight, ...` with sites counted from 0"


class Graphs:
    """The declared graphs by name: their rows."""

    def __init__(self, formulas: Formulas, files: Files, problems: Problems):
        self.formulas, self.files, self.problems = formulas, files, problems
        self.known: dict[str, list[tuple]] = {}
        self.places: dict[str, tuple | None] = {}
        self.broken: set[str] = set()

    def declare(self, node: Node) -> None:
        self.broken.add(node.name)
        node.table("file", "edges", "positions", "meaning")
        name, (rows, places), _ = self.problems.together(
            lambda: identifier(self.problems, node.key, node.name, "graph"),
            lambda: self.placed_rows(node), lambda: meaning(node, "meaning"))
        self.known[name], self.places[name] = rows, places
        self.broken.discard(name)

    def rows(self, node: Node) -> list[tuple]:
        if node.has("edges"):
            return self.listed(node)
        child = node.need("file", 'give the table of edges: `file = "edges.csv"`')
        return self.checked(child, self.files.rows(child, 2, TABLE), f"`{child.raw}`")

    def listed(self, node: Node) -> list[tuple]:
        """The rows that stand in the spec."""
        child = node.get("edges")
        if node.has("file"):
            child.wrong(codes.CONFLICT, f"`{node.label}` has both `edges` and a `file`", "give only one of them")
        rows = [tuple(whole(e.number()) if k < 2 else e.number() for k, e in enumerate(row.entries("row `[i, j, weight]`", 2 + limits.COLUMNS))) for row in child.entries("list of edges")]
        if not rows or any(len(row) < 2 or len(row) != len(rows[0]) for row in rows):
            child.wrong(codes.TABLE, "this is not a list of edges", f"they must be {TABLE}, all of the same length")
        return self.checked(child, rows, "the list")

    @staticmethod
    def checked(child: Node, rows: list[tuple], what: str) -> list[tuple]:
        if len(rows) > limits.EDGES or len(rows[0]) > 2 + limits.COLUMNS:
            child.wrong(codes.LIMIT, f"at most {limits.EDGES} edges with {limits.COLUMNS} "
                        "weights are allowed", "use a smaller table")
        i, j = (list(map(itemgetter(k), rows)) for k in (0, 1))
        if {*map(type, i), *map(type, j)} != {int} or min(i) < 0 or min(j) < 0 or any(map(eq, i, j)):
            first, second = next(row[:2] for row in rows if not joins(*row[:2]))
            child.wrong(codes.TABLE, f"{what} has an edge from {first} to {second}", "an edge joins two different sites, numbered from 0")
        return rows

    def placed_rows(self, node: Node) -> tuple:
        """(edges, where its sites stand or None)."""
        rows, places = self.problems.together(lambda: self.rows(node), lambda: self.positions(node.get("positions")) if node.has("positions") else None)
        highest = max(max(map(itemgetter(k), rows)) for k in (0, 1))
        if places is not None and highest >= len(places):
            node.get("positions").wrong(codes.COUNT, f"{len(places)} positions, but an edge names site {highest}", "give one for each site; they are counted from 0")
        return rows, places

    def positions(self, child: Node) -> tuple:
        """(x, y, z) of each site: a table in a file, or a list."""
        found = self.files.rows(child, 2, POSITIONS) if isinstance(child.raw, str) else [[e.number() for e in row.entries("row of numbers", 3)] for row in child.entries("list of positions")]
        for k, row in enumerate(found):
            if len(row) not in (2, 3) or len(row) != len(found[0]):
                child.wrong(codes.TABLE, f"row {k} has {len(row)} numbers", "each site has a position x, y or x, y, z")
        if len(set(map(tuple, found))) < len(found):
            first, again = doubled(found)
            child.wrong(codes.VALUE, f"sites {first} and {again} are at the same position", "give each site a different position")
        return tuple((*map(float, row), 0.0)[:3] for row in found)

    def home(self, node: Node) -> tuple:
        """(the number of its sites, itself) for a family that lies on a graph."""
        rows, places = self.known[node.raw], self.places[node.raw]
        edges = tuple(map(itemgetter(0, 1), rows))
        return Num(len(places) if places else 1 + max(map(max, edges))), Graph("", "", edges, (), "", places)

    def over(self, w, reader) -> Graph:
        family, name = reader.home(w), w.target.text
        if name in self.broken:
            self.formulas.silently()
        if name not in self.known:
            self.problems.fail(codes.UNKNOWN_NAME, w.target.span, f"there is no graph `{name}`",
                               nearest(name, self.known))
        rows, names = self.known[name], [i.text for i, _ in w.items]
        if not 2 <= len(names) <= len(rows[0]):
            self.problems.fail(codes.OVER, w.head.span, f"graph `{name}` has {len(rows[0])} "
                               f"columns, but {len(names)} are named", f"write `edge(i, j) of {name}`, followed by a name for each weight that is used")
        columns = tuple((n, tuple(map(float, map(itemgetter(k + 2), rows)))) for k, n in enumerate(names[2:]))
        return Graph(names[0], names[1], tuple(map(itemgetter(0, 1), rows)), columns, family, self.places[name])


def joins(i, j) -> bool:
    """Is this an edge between two sites?"""
    return isinstance(i, int) and isinstance(j, int) and i >= 0 and j >= 0 and i != j


def doubled(rows) -> tuple[int, int]:
    """The first two rows that are the same."""
    seen: dict = {}
    for k, row in enumerate(map(tuple, rows)):
        if row in seen:
            return seen[row], k
        seen[row] = k
    raise ValueError("all rows differ")


def whole(number):
    """An int where it is one."""
    return int(number) if number == int(number) else number
