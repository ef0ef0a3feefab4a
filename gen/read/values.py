"""Values given to parameters: by a run's `set`, by a command, by a call."""
from __future__ import annotations

from ..evaluate import evaluate
from ..expr import Expr
from ..spec import Parameter, Spec
from . import codes
from .problems import nearest
from .scope import Declared
from .tree import Node


class ValueReader:
    """Reads `set = { J = 2.0, gamma = [1.0, 2.0] }`."""

    def __init__(self, declared: Declared):
        self.declared = declared

    def read(self, node: Node) -> tuple[str, object]:
        known = self.declared.parameters
        if node.name not in known:
            if node.name in self.declared.broken:
                node.wrong(codes.UNKNOWN_NAME, f"the parameter `{node.name}` has errors")
            node.problems.fail(codes.UNKNOWN_NAME, node.key, f"there is no parameter "
                               f"`{node.name}`", nearest(node.name, known))
        return node.name, self.value(node, known[node.name])

    def value(self, node: Node, p: Parameter):
        if p.kind == "array":
            if node.is_number():
                return (float(node.number()),)
            return tuple(float(e.number()) for e in node.entries("list of numbers"))
        value = node.number()
        if p.kind == "int" and not isinstance(value, int):
            node.wrong(codes.TYPE, f"`{p.name}` is an integer parameter, as its default is "
                       "written without a point", "write an integer, or the default as a real")
        return value if p.kind == "int" else float(value)


def defaults(spec: Spec) -> dict:
    """Parameter and table name -> default value."""
    return {**{p.name: p.default for p in spec.parameters}, **dict(spec.tables)}


def number(e: Expr, values: dict) -> float:
    """The value of a formula of parameters as a float."""
    return float(evaluate(e, values))


def integer(e: Expr, values: dict) -> int:
    """The value of an integer formula."""
    return int(evaluate(e, values))
