"""Formulas of every kind, from a TOML value to an `Expr` in the right scope."""
from __future__ import annotations

from typing import Optional

from ..language.expr import Expr, Num, Op, walk
from ..language import codes
from ..language.units import ANY, NONE, quotient, said
from .parse import parse
from .problems import Bad, Problems
from .resolve import Resolver, integral
from .scope import Declared, Scope, Typed
from .source import Span, Text
from .syntax import Syntax
from .tree import Node

NOT_IN_COUNTS = {"^": "write a power as a product: `n*n`", "/": "a count cannot contain a division: declare half of it as a parameter, `m`, and write `2*m`"}
FREE = "a formula of parameters"
WITHOUT_POINT = "a parameter is an integer if its default is written without a decimal point: `n = { default = 100 }`"


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

    def scalar(self, text: Text, scope: Scope, what: str = "", wanted=ANY) -> Expr:
        """A formula whose value is a number; with [units] `what` has the dimension `wanted`."""
        result = self.number(text, scope)
        self.fits(result, text.whole, what, wanted)
        return result.expr

    def number(self, text: Text, scope: Scope) -> Typed:
        result = self.typed(text, scope)
        if result.kind != "s":
            what = {"v": "a vector", "b": "a condition"}[result.kind]
            hint = "take a component or `dot(a, b)`" if result.kind == "v" else \
                "write `if(condition, 1, 0)`"
            self.problems.fail(codes.KIND, text.whole, f"a number is needed here, but this is {what}",
                               hint)
        return result

    def fits(self, found: Typed, span: Span, what: str, wanted) -> None:
        """Refuse what has another dimension than it should."""
        units = self.declared.units
        if units is None or ANY in (wanted, found.dimension) or wanted == found.dimension:
            return
        if found.dimension == NONE:
            self.problems.fail(codes.MEASURE, span, f"{what} must be {said(wanted)}, but this has no unit", f"write a unit after the number: `1 {units.spelt(wanted)}`")
        if wanted == NONE:
            self.problems.fail(codes.MEASURE, span, f"{what} must be a number without a unit, but this is {said(found.dimension)}", f"divide it by {said(found.dimension)}")
        self.problems.fail(codes.DIMENSION, span, f"{what} must be {said(wanted)}, but this is {said(found.dimension)}", lacking(wanted, found.dimension))

    def vector(self, text: Text, scope: Scope, what: str = "", wanted=ANY) -> Expr:
        """A formula whose value is a vector."""
        result = self.vector_number(text, scope)
        self.fits(result, text.whole, what, wanted)
        return result.expr

    def vector_number(self, text: Text, scope: Scope) -> Typed:
        result = self.typed(text, scope)
        if result.kind != "v":
            self.problems.fail(codes.KIND, text.whole, f"a vector is needed here, but this is {'a number' if result.kind == 's' else 'a condition'}",
                               "such as `cross(w[i], p)` or `vec(x, y, z)`")
        return result

    def free(self, node: Node, place: str, index: Optional[str] = None, wanted=ANY, family: str = "") -> Expr:
        """A number, or a formula of parameters (and of `index`, which runs over a family), without vectors or time."""
        result = self.measured(node, place, index, family)
        self.fits(result, node.span, place, wanted)
        return result.expr

    def measured(self, node: Node, place: str, index: Optional[str] = None, family: str = "") -> Typed:
        """The same with its dimension."""
        if node.is_number():
            return Typed(Num(node.number()), "s", dimension=NONE if node.number() else ANY)
        indices = {index: ""} if index else {}
        return self.number(node.text(), Scope(self.declared, place, families=False, indices=indices, site=family))

    def condition(self, node: Node, place: str, index: str, key: str, family: str) -> Expr:
        """A condition on parameters and an index, without vectors or time."""
        found = self.typed(node.text(), Scope(self.declared, place, families=False, indices={index: ""}, site=family))
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
        self.problems.fail(codes.INTEGER, span, "a count must be a formula of integers and integer parameters with + - *", hint)


def lacking(wanted, given) -> str:
    """What is to be done to a formula of another dimension."""
    factor, inverse = quotient(wanted, given), quotient(given, wanted)
    return f"a factor {said(factor)} is missing" if sum(factor) >= sum(inverse) else f"it has an extra factor {said(inverse)}"
