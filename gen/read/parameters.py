"""[parameters] and [formulas]: numbers and named sub-formulas."""
from __future__ import annotations

import re
from dataclasses import replace

from ..language import limits
from ..language.expr import Num, Op
from ..language.spec import Parameter
from ..language import codes
from ..language.units import NONE
from .files import Files
from .formulas import Formulas
from .names import CONSTANTS, FUNCTIONS, UNRESERVED, identifier
from .parse import parse
from .problems import Problems, nearest
from .resolve import SELDOM
from .scope import Declared, Formula
from .syntax import Call, Component, Item, Name, Operation
from .text import meaning
from .tree import Node
from .units import Measure

HEAD = re.compile(r"\s*([^\s(]+)\s*(?:\(([^()]*)\)\s*)?\Z")


class ParameterReader:
    """Reads [parameters] into `declared.parameters`."""

    def __init__(self, declared: Declared, formulas: Formulas, files: Files, problems: Problems):
        self.declared, self.formulas, self.files, self.problems = declared, formulas, files, problems

    def read(self, section: Node) -> None:
        bounded(section.table(), limits.PARAMETERS, "parameters")
        self.declared.pending = {node.name for node in section.items()}
        for node in sorted(section.items(), key=lambda n: sized(n)):
            self.declared.broken.add(node.name)
            with self.problems.guard():
                self.parameter(node)
            self.declared.pending.discard(node.name)
        order = [n.name for n in section.items()]
        kept = self.declared.parameters
        self.declared.parameters = {n: kept[n] for n in order if n in kept}

    def parameter(self, node: Node) -> None:
        name, p = self.problems.together(
            lambda: identifier(self.problems, node.key, node.name, "parameter"), lambda: self.value(node.name, node))
        self.declared.parameters[name] = p
        self.declared.broken.discard(name)

    def value(self, name: str, node: Node) -> Parameter:
        self.measure = Measure(self.declared.units)
        if node.is_number() or self.declared.units and isinstance(node.raw, str):   # J = 1.0, J = "5.7 meV"
            value = self.measure.number(node)
            return self.measured(Parameter(name, kind(value), value))
        if isinstance(node.raw, list):
            form = "vector = true" if len(node.raw) == 3 else f"size = {len(node.raw)}"
            node.wrong(codes.TYPE, f"`{node.label}` is a list", f"write `{node.name} = {{ default = [..], {form} }}`")
        node.table("default", "file", "size", "vector", "fixed", "unit", "meaning")
        p, unit, said, fixed = self.problems.together(
            lambda: self.with_unit(name, node), lambda: meaning(node, "unit"), lambda: meaning(node, "meaning"),
            lambda: node.has("fixed") and node.get("fixed").flag())
        return self.measured(replace(p, unit=unit, meaning=said, fixed=fixed))

    def with_unit(self, name: str, node: Node) -> Parameter:
        self.measure = Measure(self.declared.units, node.get("unit"))
        return self.table(name, node)

    def measured(self, p: Parameter) -> Parameter:
        """Notes its dimension; its unit is that of the numbers, which the C has too."""
        units, dimension = self.declared.units, self.measure.found
        if units is None:
            return p
        self.declared.dimensions[p.name] = dimension
        return replace(p, unit=self.measure.of_angles if dimension == NONE else units.spelt(dimension))

    def table(self, name: str, node: Node) -> Parameter:
        if node.has("file"):
            return self.filed(name, node)
        default = node.need("default", "give its value: `{ default = 1.0 }`")
        if isinstance(default.raw, list) or node.has("size") or node.has("vector"):
            return self.array(name, node, default)
        value = self.measure.number(default)
        return Parameter(name, kind(value), value)

    def filed(self, name: str, node: Node) -> Parameter:
        """An array whose entries are the rows of a file: numbers, or with `vector` vectors."""
        if node.has("default"):
            node.get("file").wrong(codes.CONFLICT, f"`{name}` has both a file and a default", "give only one of them")
        width = 3 if node.has("vector") and node.get("vector").flag() else 1
        size, rows = self.problems.together(lambda: self.size(node), lambda: self.files.numbers(node.get("file"), width))
        if len(rows) * width > limits.ARRAY:
            node.get("file").wrong(codes.LIMIT, f"`{name}` has {len(rows) * width} entries; at most {limits.ARRAY} are allowed", "use a smaller table")
        return self.rows(name, width, size, self.measure.rows(node.get("file"), rows))

    def rows(self, name: str, width: int, size, rows) -> Parameter:
        if width == 1:
            return Parameter(name, "array", tuple(float(x) for (x,) in rows), size)
        self.declared.lists.add(name)
        return Parameter(name, "array", tuple(float(x) for row in rows for x in row), Op("*", (Num(3), size)), vector=True)

    def vectors(self, name: str, node: Node, default: Node) -> Parameter:
        """A list of vectors, with their number."""
        def three(entry):
            row = entry.entries("vector of three numbers")
            if len(row) != 3:
                entry.wrong(codes.COUNT, f"a vector has three components, not {len(row)}", "write `[x, y, z]`")
            return tuple(float(self.measure.number(c)) for c in row)
        size, rows = self.problems.together(lambda: self.size(node), lambda: [three(e) for e in default.entries("list of vectors")])
        return self.rows(name, 3, size, rows)

    def array(self, name: str, node: Node, default: Node) -> Parameter:
        """A list with a size; or one number that every entry has."""
        if node.has("size") and node.has("vector") and node.get("vector").flag() and isinstance(default.raw, list) and all(isinstance(x, list) for x in default.raw):
            return self.vectors(name, node, default)
        size, values = self.problems.together(lambda: self.length(name, node, default),
                                              lambda: self.entries(name, default))
        return Parameter(name, "array", values, size, fill=not isinstance(default.raw, list), vector=name in self.declared.vectors)

    def length(self, name: str, node: Node, default: Node):
        if node.has("vector") and node.get("vector").flag():
            return self.vector(name, node, default)
        return self.size(node)

    def entries(self, name: str, default: Node) -> tuple[float, ...]:
        if not isinstance(default.raw, list):
            return (float(self.measure.number(default)),)
        values = tuple(float(self.measure.number(e)) for e in default.entries())
        if not values:
            default.wrong(codes.COUNT, f"`{name}` has no entries", "give at least one number")
        return values

    def vector(self, name: str, node: Node, default: Node) -> Num:
        """Three numbers that formulas use as a vector."""
        if node.has("size"):
            node.get("size").wrong(codes.CONFLICT, f"the vector `{name}` has three entries",
                                   "omit `size`, or give a list of vectors, `[[0, 0, 1], ..]`")
        if not isinstance(default.raw, list) or len(default.raw) != 3:
            default.wrong(codes.COUNT, f"the vector `{name}` needs three numbers",
                          "write `default = [0.0, 0.0, 1.0]`")
        self.declared.vectors.add(name)
        return Num(3)

    def size(self, node: Node):
        child = node.get("size")
        if child is not None:
            return self.formulas.count(child)
        self.problems.fail(codes.MISSING, node.key, f"the array `{node.name}` has no `size`",
                           'give its length: `size = "n"`, or `vector = true` for a vector')


def kind(value) -> str:
    return "int" if isinstance(value, int) else "real"


def sized(node: Node) -> bool:
    """Arrays come after the integers that their sizes are made of."""
    return isinstance(node.raw, dict) and "size" in node.raw


def bounded(section: Node, most: int, what: str) -> None:
    """Report a section with too many entries."""
    if len(section.raw) > most:
        section.problems.note(codes.LIMIT, section.key, f"{len(section.raw)} {what}; "
                              f"at most {most} are allowed",
                              "split the model, or use arrays and index families")


class FormulaReader:
    """Reads [formulas] into `declared.formulas`, and refuses recursion."""

    def __init__(self, declared: Declared, problems: Problems):
        self.declared, self.problems = declared, problems

    def read(self, section: Node) -> None:
        bounded(section.table(), limits.FORMULAS, "formulas")
        for node in section.items():
            with self.problems.guard():
                self.formula(node)
        for formula in list(self.declared.formulas.values()):
            with self.problems.guard():
                self.acyclic(formula)

    def formula(self, node: Node) -> None:
        """`"name(a, b)" = "..."`."""
        match = HEAD.match(node.name)
        if match is None:
            self.problems.fail(codes.SYNTAX, node.key, f"`{node.name}` is not a valid declaration of a formula", 'write `"name(a, b)" = "..."` or `name = "..."`')
        name = match.group(1)
        taken = name in self.declared.names()
        self.declared.broken |= set() if taken else {name}
        _, args, body = self.problems.together(
            lambda: self.fresh(node, identifier(self.problems, node.key, name, "formula")),
            lambda: self.arguments(node, match.group(2)), lambda: parse(node.text(), self.problems))
        self.declared.broken.discard(name)
        self.declared.formulas[name] = Formula(name, args, body, node.key)

    def fresh(self, node: Node, name: str) -> None:
        if name in self.declared.names():
            self.problems.fail(codes.CLASH, node.key, f"`{name}` is declared already",
                               "choose another name")

    def arguments(self, node: Node, text) -> tuple[str, ...]:
        if text is None:
            return ()
        names = [a.strip() for a in text.split(",")]
        for k, a in enumerate(names):
            identifier(self.problems, node.key, a, "argument")
            if a in names[:k] or a in self.declared.names():
                self.problems.fail(codes.CLASH, node.key, f"the name of the argument `{a}` is already in use", "choose another name")
        if len(names) > limits.ARGUMENTS:
            self.problems.fail(codes.LIMIT, node.key, f"at most {limits.ARGUMENTS} arguments "
                               "are allowed", "split the formula")
        return tuple(names)

    def acyclic(self, formula: Formula) -> None:
        """Depth-first search for a way back to `formula`."""
        seen, todo = set(), [formula]
        while todo:
            for node in called(todo.pop().body):
                if node.name == formula.name:
                    self.declared.formulas.pop(formula.name, None)
                    self.declared.broken.add(formula.name)
                    self.problems.fail(codes.RECURSION, formula.span,
                                       f"formula `{formula.name}` uses itself",
                                       "formulas are expanded; they cannot be recursive")
                other = self.declared.formulas.get(node.name)
                if other is not None and other.name not in seen:
                    seen.add(other.name)
                    todo.append(other)


def called(tree):
    """All names, calls and entries in a syntax tree."""
    todo = [tree]
    while todo:
        node = todo.pop()
        if isinstance(node, (Name, Call, Item)):
            yield node
        todo.extend(children(node))


def children(node) -> tuple:
    if isinstance(node, (Call, Operation)):
        return node.args
    if isinstance(node, Item):
        return (node.index,)
    return (node.base,) if isinstance(node, Component) else ()


def undeclared(declared: Declared, problems: Problems) -> None:
    """Names in formulas that nothing declares, also in formulas that nothing uses."""
    for formula in declared.formulas.values():
        known = declared.names() | declared.broken | set(formula.args) | CONSTANTS
        for node in called(formula.body):
            if node.name in known or isinstance(node, Call) and node.name in FUNCTIONS | UNRESERVED:
                continue
            where = node.span if isinstance(node, Name) else node.head
            problems.note(codes.UNKNOWN_NAME, where, f"`{node.name}` is not declared "
                          f"(in formula `{formula.name}`)", SELDOM.get(node.name)
                          or index_advice(node) or nearest(node.name, known, FUNCTIONS))


def index_advice(node) -> str:
    """One-letter names are most often indices, which a formula takes as arguments."""
    return "an index is an argument: `\"name(i)\" = \"...\"`" if node.name in "ijk" else ""
