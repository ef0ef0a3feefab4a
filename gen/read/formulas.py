"""Formulas of every kind, from a TOML value to an `Expr` in the right scope."""
from __future__ import annotations

from typing import Optional

from ..language.expr import Expr, Num, Op, walk
from ..language import codes
from .parse import parse
from .problems import Bad, Problems
from .resolve import Resolver, integral
from .scope import Declared, Scope, Typed
from .source import Span, Text
from .syntax import Syntax
from .tree import Node

NOT_IN_COUNTS = {"^": "write a power as a product: `n*n`", "/": "a count has no division: make half of it a parameter, `m`, and write `2*m`"}
FREE = "a formula of parameters"
WITHOUT_POINT = "a parameter is an integer when its default is written without a point: `n = { default = 100 }`"


class Formulas:
    """Reads formulas against the declared names."""

    def __init__(self, declared: Declared, problems: Problems):
        self.declared, self.problems = declared, problems

    def silently(self):
        """Give up what hangs on a declaration whose errors are already noted."""
        raise Bad

    def typed(self, text: Text, scope: Scope) -> Typed:
        resolver = Resolver(scope, self.problems)
        result = resolver.resolve(parse(text, self.problems))
        self.problems.places.update({(text.whole, e): s for e, s in resolver.places.items()})
        return result

    def scalar(self, text: Text, scope: Scope) -> Expr:
        """A formula whose value is a number."""
        result = self.typed(text, scope)
        if result.kind != "s":
            what = {"v": "a vector", "b": "a condition"}[result.kind]
            hint = "take a component or `dot(a, b)`" if result.kind == "v" else \
                "write `if(condition, 1, 0)`"
            self.problems.fail(codes.KIND, text.whole, f"a number is needed here, this is {what}",
                               hint)
        return result.expr

    def vector(self, text: Text, scope: Scope) -> Expr:
        """A formula whose value is a vector."""
        result = self.typed(text, scope)
        if result.kind != "v":
            self.problems.fail(codes.KIND, text.whole, f"a vector is needed here, this is {'a number' if result.kind == 's' else 'a condition'}",
                               "such as `cross(w[i], p)` or `vec(x, y, z)`")
        return result.expr

    def free(self, node: Node, place: str, index: Optional[str] = None) -> Expr:
        """A number, or a formula of parameters (and of `index`), without vectors or time."""
        if node.is_number():
            return Num(node.number())
        indices = {index: ""} if index else {}
        return self.scalar(node.text(), Scope(self.declared, place, families=False,
                                              indices=indices))

    def condition(self, node: Node, place: str, index: str, key: str) -> Expr:
        """A condition on parameters and an index, without vectors or time."""
        found = self.typed(node.text(), Scope(self.declared, place, families=False, indices={index: ""}))
        if found.kind != "b":
            node.wrong(codes.KIND, f"`{key}` needs a condition", f'such as `{key} = "{index} < 10"` or `{key} = "uniform(7, {index}) < 0.1"`')
        return found.expr

    def count(self, node: Node) -> Expr:
        """[int]: an integer or an integer formula of integer parameters."""
        if isinstance(node.raw, str):
            return self.count_of(parse(node.text(), self.problems))
        if not node.is_integer():
            node.wrong(codes.INTEGER, f"`{node.label}` must be an integer or a formula of "
                       "integer parameters", "such as `4`, `\"n\"` or `\"2*nx*ny\"`")
        return Num(node.number())

    def count_of(self, tree: Syntax) -> Expr:
        scope = Scope(self.declared, "a count", families=False)
        expr = Resolver(scope, self.problems).resolve(tree).expr
        if not integral(expr, self.declared.parameters):
            used = {e.op for e in walk(expr) if isinstance(e, Op)}
            self.not_integral(tree.span, next((hint for op, hint in NOT_IN_COUNTS.items() if op in used), WITHOUT_POINT))
        return expr

    def not_integral(self, span: Span, hint: str = WITHOUT_POINT):
        self.problems.fail(codes.INTEGER, span, "a count is made of integers and integer parameters with + - *", hint)
