"""From the syntax tree to `Expr`: names resolved, formulas expanded, kinds checked."""
from __future__ import annotations

import math
from dataclasses import replace

from ..language import limits
from ..language.expr import SIGNATURES, Elem, Idx, Num, Op, Par, Spin, Time, Weight
from ..language import codes
from ..language.harmonics import NORMS
from ..language.units import ANY, NONE, TIME, Unit
from .arithmetic import CONSTANT
from .dimensions import Dimensions
from .guesses import SELDOM, meant
from .harmonics import harmonics
from .names import FUNCTIONS, PLACE, UNRESERVED
from .problems import Bad, Problems, TooBig, nearest
from .quantities import continued, exact
from .scope import Scope, Typed, is_single
from .source import Span
from .syntax import Call, Component, Item, Name, Number, Operation, Quantity, Syntax
from .units import in_units
from .vectors import vector

WORDS = {"s": "number", "v": "vector", "b": "condition"}


class Resolver:
    """Resolves one formula in one scope; `resolve` returns a `Typed`."""

    def __init__(self, scope: Scope, problems: Problems):
        self.scope, self.problems, self.depth = scope, problems, 0
        self.places: dict = {}      # Spin and Elem -> where it stands first
        self.failed: set = set()    # formulas whose body has errors with these arguments

    def resolve(self, node: Syntax) -> Typed:
        self.depth += 1
        self.bounded(self.depth, 0, node.span)
        result = self.METHODS[type(node)](self, node)
        self.bounded(result.depth, result.nodes, node.span)
        self.depth -= 1
        return result

    def bounded(self, depth: int, nodes: int, span: Span) -> None:
        hint = "split it into several effects, or sum over an index family"
        if nodes > limits.NODES:
            self.stop(codes.BIG, span, f"the formula expands to more than {limits.NODES} "
                      "operations and operands", hint)
        if depth > limits.TREE:
            self.stop(codes.BIG, span, f"more than {limits.TREE} nested operations (a sum counts one for each term)", hint)

    def stop(self, *told) -> None:
        """Report a formula that is too big, and leave it."""
        try:
            self.fail(*told)
        except Bad:
            raise TooBig from None

    def operands(self, nodes) -> list[Typed]:
        """All of them resolved; an error in one hides none in the next."""
        found, bad, depth = [], False, self.depth
        for node in nodes:
            try:
                found.append(self.resolve(node))
            except TooBig:
                raise
            except Bad:
                bad, self.depth = True, depth
        if bad:
            raise Bad
        return found

    def fail(self, code: str, span: Span, cause: str, hint: str):
        inside = self.scope.inside
        note = f" (in formula `{inside[-1]}`)" if inside else ""
        self.problems.fail(code, span, cause + note, hint)

    # Leaves

    def number(self, node: Number) -> Typed:
        return Typed(Num(node.value), "s", value=float(node.value), dimension=NONE if node.value else ANY)

    def quantity(self, node: Quantity) -> Typed:
        found = Unit(exact(node.value), NONE) * node.unit
        value = in_units(found, self.scope.declared.units, node.span, self.problems)
        return Typed(Num(value), "s", value=value, dimension=found.dimension)

    def name(self, node: Name) -> Typed:
        name, scope, declared = node.name, self.scope, self.scope.declared
        if name in scope.args:
            return scope.args[name]
        if name in scope.indices:
            return Typed(Idx(name), "s")
        if name in scope.numbers:
            return Typed(Idx(name, bond=True), "s")
        if name in scope.weights:
            return Typed(Weight(name), "s")
        if name in declared.parameters:
            return self.parameter(node)
        if name in declared.families:
            return self.family(node)
        if name in declared.formulas:
            return self.expand(Call(name, (), node.span, node.span))
        return self.constant(node)

    def constant(self, node: Name) -> Typed:
        if node.name == "pi":
            return Typed(Num(math.pi), "s", value=math.pi)
        if node.name == "t" and self.scope.time:
            return Typed(Time(), "s", dimension=self.dimension(TIME))
        if node.name == "t":
            self.fail(codes.NOT_HERE, node.span, f"time `t` is not allowed in {self.scope.place}",
                      "time enters through effects: `energy = \"B*cos(t)*w.z\"`")
        if node.name in FUNCTIONS | UNRESERVED:
            self.fail(codes.SYNTAX, node.span, f"`{node.name}` is a function, but is given no arguments",
                      f"write `{node.name}(...)`")
        return self.unknown(node.name, node.span)

    def unknown(self, name: str, span: Span, index: bool = False):
        declared = self.scope.declared
        if name in declared.pending:
            self.fail(codes.NOT_HERE, span, f"`{name}` is not allowed in {self.scope.place}",
                      nearest("", self.scope.known()))
        if name in declared.broken or declared.nameless:
            raise Bad
        self.fail(codes.UNKNOWN_NAME, span, f"`{name}` is not declared", meant(name, self.scope, index))

    def parameter(self, node: Name) -> Typed:
        p = self.scope.declared.parameters[node.name]
        if p.kind != "array":
            return Typed(Par(p.name), "s", dimension=self.of(p.name))
        if p.name in self.scope.declared.vectors:
            parts = tuple(Elem(p.name, Num(k)) for k in range(3))
            return Typed(Op("vec", parts), "v", 7, 3, dimension=self.of(p.name))
        self.fail(codes.INDEX, node.span, f"`{p.name}` is an array",
                  f"take an entry, such as `{p.name}[i]`, or declare it with `vector = true`")

    def family(self, node: Name) -> Typed:
        family = self.family_here(node.name, node.span)
        if self.scope.whole == node.name:
            return Typed(Spin(node.name, "i"), "v", dimension=self.of(node.name))
        if is_single(family) or node.name in self.scope.declared.unread:
            return Typed(Spin(node.name, 0), "v", dimension=self.of(node.name))
        self.fail(codes.INDEX, node.span, f"`{node.name}` is a family of vectors",
                  f"select one of them, such as `{node.name}[i]` or `{node.name}[0]`")

    def of(self, name: str) -> tuple:
        """The dimension of a parameter or of the vectors of a family."""
        return self.scope.declared.dimensions.get(name, NONE)

    def family_here(self, name: str, span: Span):
        family = self.scope.declared.families[name]
        if not self.scope.families or self.scope.whole not in ("", name):
            self.fail(codes.NOT_HERE, span, f"`{name}` is a vector of the state, which is not allowed in {self.scope.place}", nearest("", self.scope.known()))
        return family

    # Indexing

    def item(self, node: Item) -> Typed:
        declared = self.scope.declared
        if node.name in declared.families:
            return self.spin(node)
        if node.name in declared.parameters:
            return self.entry(node)
        if node.name in self.scope.known():
            self.fail(codes.INDEX, node.head, f"`{node.name}` has no entries",
                      "only arrays have entries, such as `gamma[i]`, and families have vectors, such as `w[i]`")
        return self.unknown(node.name, node.head)

    def spin(self, node: Item) -> Typed:
        self.family_here(node.name, node.head)
        slot = self.slot(node)
        if isinstance(slot, int):
            return self.placed(Typed(Spin(node.name, slot), "v", dimension=self.of(node.name)), node)
        owner = self.indices().get(slot, "")
        if slot not in self.indices() and isinstance(found := self.resolve(node.index).expr, Idx) and found.bond:
            self.fail(codes.INDEX, node.index.span, f"`{slot}` is the number of a bond, not of a site", "the last index is the number of the bond, not a site")
        if owner != node.name:
            over = f"sites of `{owner}`" if owner else "something else"
            self.fail(codes.INDEX, node.index.span, f"`{slot}` runs over {over}, "
                      f"not over the sites of `{node.name}`", f"for all combinations, write `each(i of {owner or 'p'}, k of {node.name})`; "
                      "to pair sites with the same number, use one family on a lattice with `sites = 2`")
        return self.placed(Typed(Spin(node.name, slot), "v", dimension=self.of(node.name)), node)

    def placed(self, result: Typed, node: Syntax) -> Typed:
        self.places.setdefault(result.expr, node.span)
        return result

    def indices(self) -> dict[str, str]:
        """Bound index -> family, those of the caller included."""
        return self.scope.indices

    def slot(self, node: Item):
        """A bound index name or a literal: what may stand in `w[...]`."""
        index = node.index
        if isinstance(index, Number) and isinstance(index.value, int):
            return index.value
        if isinstance(index, Name) and index.name not in self.scope.known():
            self.unknown(index.name, index.span, index=True)
        found = self.resolve(index).expr if isinstance(index, Name) else None
        if isinstance(found, Idx):
            return found.name
        if isinstance(found, Num) and isinstance(found.value, int):
            return found.value
        self.fail(codes.INDEX, index.span, "the index of a vector must be a bound index or an integer constant",
                  "write neighbours as bonds: `over = \"bond(i, j) of chain(n, periodic)\"`")

    def entry(self, node: Item) -> Typed:
        p = self.scope.declared.parameters[node.name]
        if p.kind != "array":
            self.fail(codes.INDEX, node.head, f"`{p.name}` is a single number and has no entries",
                      f"write `{p.name}`, or make it an array: `{{ default = 1.0, size = \"n\" }}`")
        index = self.resolve(node.index)
        if not integral(index.expr, self.scope.declared.parameters):
            self.fail(codes.INDEX, node.index.span, "an index must be a formula of integers, integer parameters and indices with + - *", "such as `gamma[i]` or `gamma[2*i + 1]`")
        if p.name in self.scope.declared.lists:
            return self.row(p.name, index, node)
        return self.placed(Typed(Elem(p.name, index.expr), "s", index.nodes + 1,
                                 index.depth + 1, dimension=self.of(p.name)), node)

    def row(self, name: str, index: Typed, node: Item) -> Typed:
        """The vector of three entries."""
        first = Op("*", (Num(3), index.expr))
        parts = tuple(Elem(name, Op("+", (first, Num(k)))) for k in range(3))
        for part in parts:
            self.places.setdefault(part, node.span)
        return Typed(Op("vec", parts), "v", 3 * index.nodes + 13, index.depth + 4, dimension=self.of(name))

    # Operators and functions

    def component(self, node: Component) -> Typed:
        base = self.resolve(node.base)
        if base.kind != "v":
            self.fail(codes.KIND, node.base.span, f"a {WORDS[base.kind]} has no component "
                      f"`.{node.axis}`", "only vectors have components")
        return Typed(Op(node.axis, (base.expr,)), "s", base.nodes + 1, base.depth + 1, dimension=base.dimension)

    def operation(self, node: Operation) -> Typed:
        measured = self.problems.measured and continued(node, self.taken)
        if measured:
            return self.quantity(measured)
        return self.apply(node.op, self.operands(node.args), node.sign, node)

    def call(self, node: Call) -> Typed:
        if node.name in self.scope.declared.formulas:
            return self.expand(node)
        if node.name in NORMS:
            return self.harmonics(node)
        if node.name == PLACE:
            return vector(self, node, self.operands(node.args))
        if node.name in UNRESERVED:
            return self.draw(node)
        if node.name not in FUNCTIONS:
            if node.name in self.scope.known():
                self.fail(codes.SYNTAX, node.head, f"`{node.name}` is not a function",
                          f"entries are written `{node.name}[i]`, products with `*`")
            names = FUNCTIONS | UNRESERVED | set(self.scope.declared.formulas)
            if node.name in self.scope.declared.broken:
                self.operands(node.args)
                raise Bad
            self.fail(codes.UNKNOWN_NAME, node.head, f"there is no function `{node.name}`",
                      SELDOM.get(node.name) or nearest(node.name, names))
        return self.apply(node.name, self.operands(node.args), node.head, node)

    def taken(self, name: str) -> bool:
        """Does something here have this name?"""
        declared = self.scope.declared
        return name in self.scope.known() | declared.names() | declared.broken | declared.pending

    def harmonics(self, node: Call) -> Typed:
        found = harmonics(self, node)
        if self.scope.declared.units is None:
            return found
        coefficients, vector = node.args
        if self.resolve(vector).dimension != NONE:
            self.fail(codes.DIMENSION, vector.span, f"the vector of `{node.name}` has a unit", "harmonics are functions of a direction: divide the vector by its length")
        return replace(found, dimension=self.of(coefficients.name))

    def draw(self, node: Call) -> Typed:
        """A random number of a seed and one or two sites: integers all."""
        args = self.operands(node.args)
        found = self.apply(node.name, args, node.head, node)
        for a, written in zip(args, node.args):
            if not integral(a.expr, self.scope.declared.parameters):
                self.fail(codes.INTEGER, written.span, f"`{node.name}` takes a seed and one or two indices: integers, integer parameters and indices with + - *",
                          f"such as `{node.name}(7, i)` of a site, or `{node.name}(7, i, j)` of a bond")
        return found

    def apply(self, op: str, args: list[Typed], sign: Span, node: Syntax) -> Typed:
        kinds = "".join(a.kind for a in args)
        result = dict(SIGNATURES[op]).get(kinds)
        if result is None:
            self.misfit(op, kinds, sign, node)
        if op == "/" and args[1].value == 0:
            self.fail(codes.VALUE, node.args[1].span, "this divides by zero", "divide by something else")
        if op == "^":
            self.exponent(args[1], node.args[1].span)
        value = self.folded(op, args, node.span)
        return Typed(Op(op, tuple(a.expr for a in args)), result,
                     1 + sum(a.nodes for a in args), 1 + max(a.depth for a in args), value, self.fitting(op, args, node))

    def fitting(self, op: str, args: list[Typed], node: Syntax):
        """The dimension of an operation; none where numbers have no units."""
        if self.scope.declared.units is None:
            return NONE
        return Dimensions(self.fail).of(op, args, [a.span for a in node.args])

    def dimension(self, known: tuple) -> tuple:
        return NONE if self.scope.declared.units is None else known

    def misfit(self, op: str, kinds: str, sign: Span, node: Syntax):
        """Say which argument does not fit."""
        wanted = [k for k, _ in SIGNATURES[op]]
        if len(kinds) not in {len(k) for k in wanted}:
            self.fail(codes.ARITY, sign, f"`{op}` takes {len(wanted[0])} argument"
                      f"{'s' * (len(wanted[0]) > 1)}, not {len(kinds)}",
                      "it takes " + spoken(wanted[0]))
        shown = "-" if op == "neg" else op
        self.fail(codes.KIND, sign if isinstance(node, Operation) else
                  self.culprit(wanted, kinds, node),
                  f"`{shown}` does not take {spoken(kinds)}", self.advice(op, kinds, wanted))

    def culprit(self, wanted, kinds: str, node: Syntax) -> Span:
        """The first argument whose kind no signature has at its place."""
        for k, kind in enumerate(kinds):
            if kind not in {w[k] for w in wanted}:
                return node.args[k].span
        return node.args[-1].span

    def advice(self, op: str, kinds: str, wanted) -> str:
        if op == "*" and kinds == "vv":
            return "write `dot(a, b)` or `cross(a, b)`"
        if op == "^" and kinds[0] == "v":
            return "write `dot(w, w)` for the square of a vector"
        if op == "if" and kinds[0] != "b":
            return "the first argument is a condition, such as `t < 2`"
        if op in ("<", "<=", ">", ">=", "==", "!=", "abs") and "v" in kinds:
            return "compare components or `norm(w)`"
        if "b" in kinds:
            return "a condition is only allowed as the first argument of `if(condition, a, b)`"
        return "it takes " + ", or ".join(map(spoken, wanted))

    def exponent(self, exponent: Typed, span: Span) -> None:
        if exponent.value is not None and abs(exponent.value) > limits.EXPONENT:
            self.fail(codes.EXPONENT, span, "a constant exponent must be at most "
                      f"{limits.EXPONENT} in absolute value", "use `exp` and `log`")

    def folded(self, op: str, args: list[Typed], span: Span):
        """The value of an operation on constants; an error when it is not finite."""
        values = [a.value for a in args]
        if op not in CONSTANT or None in values:
            return None
        try:
            value = float(CONSTANT[op](*values))
        except (ArithmeticError, ValueError, TypeError):
            value = math.nan
        if not math.isfinite(value) or abs(value) > limits.LARGEST:
            self.fail(codes.VALUE, span, "the value of this constant is not finite, or too large or too small",
                      f"its absolute value must be below {limits.LARGEST:g}")
        return value

    # Named formulas

    def expand(self, node: Call) -> Typed:
        formula = self.scope.declared.formulas[node.name]
        if node.name in self.scope.inside:
            raise Bad       # reported where the formulas are declared
        if len(node.args) != len(formula.args):
            self.fail(codes.ARITY, node.head, f"formula `{node.name}` takes "
                      f"{len(formula.args)} argument{'s' * (len(formula.args) != 1)}, "
                      f"not {len(node.args)}", self.declaration(formula))
        args = dict(zip(formula.args, self.operands(node.args)))
        if node.name in self.failed:
            raise Bad       # reported already, and not to be expanded again and again
        try:
            return Inner(self, formula, args).resolve(formula.body)
        except Bad:
            self.failed.add(node.name)
            raise

    def declaration(self, formula) -> str:
        arguments = f"({', '.join(formula.args)})" if formula.args else ""
        return f"it is declared as `{formula.name}{arguments}`"

    METHODS = {Number: number, Name: name, Item: item, Component: component,
               Operation: operation, Call: call, Quantity: quantity}


class Inner(Resolver):
    """Resolves a formula's body; indices handed over as arguments keep their family."""

    def __init__(self, outer: Resolver, formula, args: dict[str, Typed]):
        super().__init__(outer.scope.enter(formula, args), outer.problems)
        self.depth, self.bound, self.places = outer.depth, outer.indices(), outer.places
        self.failed = outer.failed

    def indices(self) -> dict[str, str]:
        return self.bound


def spoken(kinds: str) -> str:
    """`a vector and a number`; `a condition, a number and a number`."""
    words = ["a " + WORDS[k] for k in kinds]
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def integral(e, parameters) -> bool:
    """Is `e` made of integers, int parameters and indices with + - *."""
    if isinstance(e, Num):
        return isinstance(e.value, int)
    if isinstance(e, Par):
        return parameters[e.name].kind == "int"
    if isinstance(e, Op):
        return e.op in ("+", "-", "*", "neg") and all(integral(a, parameters) for a in e.args)
    return isinstance(e, Idx)
