"""Graphs: edge tables in files, `edge(i, j, K) of g`."""
from __future__ import annotations

from ..language import limits
from ..language.spec import Graph
from ..language import codes
from .files import Files
from .formulas import Formulas
from .names import identifier
from .problems import Problems, nearest
from .text import meaning
from .tree import Node

TABLE = "rows `i, j` or `i, j, weight, ...` with sites counted from 0"


class Graphs:
    """The declared graphs by name: their rows."""

    def __init__(self, formulas: Formulas, files: Files, problems: Problems):
        self.formulas, self.files, self.problems = formulas, files, problems
        self.known: dict[str, list[tuple]] = {}
        self.broken: set[str] = set()

    def declare(self, node: Node) -> None:
        self.broken.add(node.name)
        node.table("file", "meaning")
        name, rows, _ = self.problems.together(
            lambda: identifier(self.problems, node.key, node.name, "graph"),
            lambda: self.rows(node), lambda: meaning(node, "meaning"))
        self.known[name] = rows
        self.broken.discard(name)

    def rows(self, node: Node) -> list[tuple]:
        child = node.need("file", 'name the table of edges: `file = "edges.csv"`')
        rows = self.files.rows(child, 2, TABLE)
        if len(rows) > limits.EDGES or len(rows[0]) > 2 + limits.COLUMNS:
            child.wrong(codes.LIMIT, f"at most {limits.EDGES} edges with {limits.COLUMNS} "
                        "weights are allowed", "use a smaller table")
        for i, j, *_ in rows:
            if not (isinstance(i, int) and isinstance(j, int) and i >= 0 and j >= 0) or i == j:
                child.wrong(codes.TABLE, f"`{child.raw}` has an edge from {i} to {j}",
                            "an edge joins two different sites, whole numbers from 0")
        return rows

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
                               f"columns, but {len(names)} are named", "write `edge(i, j) of "
                               f"{name}`, and a name for each weight that you use")
        columns = tuple((n, tuple(float(r[k + 2]) for r in rows))
                        for k, n in enumerate(names[2:]))
        return Graph(names[0], names[1], tuple((r[0], r[1]) for r in rows), columns, family)
