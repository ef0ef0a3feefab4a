"""Values given to parameters: by a run's `set`, by a command, by a call."""
from __future__ import annotations

from dataclasses import replace

from ..language import limits
from ..language.evaluate import evaluate
from ..language.expr import Expr
from ..language.spec import Parameter, Spec
from ..language import codes
from ..language.units import NONE
from .problems import nearest
from .scope import Declared
from .tree import Node
from .units import Measure


class ValueReader:
    """Reads `set = { J = 2.0, gamma = [1.0, 2.0] }`."""

    def __init__(self, declared: Declared):
        self.declared = declared

    def read(self, node: Node) -> tuple[str, object]:
        known = self.declared.parameters
        if node.name not in known:
            if node.name in self.declared.broken:
                node.wrong(codes.UNKNOWN_NAME, f"the parameter `{node.name}` has errors",
                           "correct its declaration first")
            node.problems.fail(codes.UNKNOWN_NAME, node.key, f"there is no parameter "
                               f"`{node.name}`", nearest(node.name, known))
        return node.name, self.value(node, known[node.name])

    def value(self, node: Node, p: Parameter):
        number = self.numbers(p)
        if p.kind == "array":
            if node.is_number() or self.declared.units and isinstance(node.raw, str):
                if p.vector:
                    node.wrong(codes.COUNT, p.too_few.replace("'", "`"), "such as `[0, 0, 1]`")
                return (float(number(node)),)
            return tuple(float(number(e)) for e in node.entries("list of numbers"))
        value = number(node)
        if p.kind == "int" and not isinstance(value, int):
            node.wrong(codes.TYPE, f"`{p.name}` is an integer parameter, because its default is "
                       "written without a decimal point", "write an integer, or give the default a decimal point")
        return value if p.kind == "int" else float(value)

    def numbers(self, p: Parameter):
        """What reads a number of this parameter."""
        if self.declared.units is None:
            return Node.number
        measure = Measure(self.declared.units)
        if p.unit:
            measure.bare = f"`{p.name}` is in {p.unit}, but this number has no unit"
        measure.dimension = self.declared.dimensions.get(p.name, NONE)
        return measure.number


def defaults(spec: Spec) -> dict:
    """Parameter and table name -> default value."""
    return {**{p.name: p.default for p in spec.parameters}, **dict(spec.tables)}


def number(e: Expr, values: dict) -> float:
    """The value of a formula of parameters as a float."""
    return float(evaluate(e, values))


def integer(e: Expr, values: dict) -> int:
    """The value of an integer formula."""
    return int(evaluate(e, values))


def with_values(spec: Spec, values: dict, given: dict) -> dict:
    """`values` with those `given`; arrays of one repeated number follow their size."""
    values, room = {**values, **given}, limits.ARRAY
    for p in spec.parameters:
        if p.kind != "array":
            continue
        have = values[p.name]
        if p.fill and p.name not in given or p.name in given and len(have) == 1:
            size = integer(p.size, values)
            if 0 < size <= room:
                values[p.name] = tuple(have[:1]) * size
        room -= len(values[p.name])
    return values


def filled(spec: Spec) -> Spec:
    """Defaults that are one repeated number, at the default size."""
    values = with_values(spec, defaults(spec), {})
    return replace(spec, parameters=tuple(
        replace(p, default=values[p.name]) if p.kind == "array" else p
        for p in spec.parameters))
