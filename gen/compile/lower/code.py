"""The intermediate form: loops over index families, kernels and buffers as data. Printers (`gen/compile/emit/print_*.py`)
turn it into text; nothing of C stands in it but the names of the model's and the runtime's own variables and functions.

A body is a tuple of statements. Integers are those of `integers.py`; real numbers are sympy expressions with what their
symbols stand for, in the arithmetic of whichever printer writes them.
"""
from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import sympy as sp

from .integers import Int, Node


# What the symbols of a real number stand for (an integer of `integers.py` among them)

@dataclass(frozen=True)
class Component(Node):
    """x, y or z (axis 0, 1, 2) of the vector of a site."""
    vector: str
    axis: int

    def names(self):
        return (self.vector,)


@dataclass(frozen=True)
class Local(Node):
    """A number that has a name here: a common part, an argument, the weight of an edge."""
    name: str
    exact: bool = False     # an input, of ordinary precision

    def names(self):
        return (self.name,)


@dataclass(frozen=True)
class Held(Node):
    """A value kept with the coefficients `holder`: what was hoisted, the step h, the time t; of_model: in the model that these are of."""
    name: str
    holder: str
    of_model: bool = False

    def names(self):
        return (self.holder,)


@dataclass(frozen=True)
class Parameter(Node):
    """A real parameter, or one entry of an array of them."""
    name: str
    place: Int | None = None

    def names(self):
        return ("c",)


@dataclass(frozen=True)
class Constant(Node):
    """A parameter whose value is compiled in."""
    value: float


@dataclass(frozen=True)
class Entry(Node):
    """An entry of a constant table of real numbers."""
    table: str
    place: Int

    def names(self):
        return (self.table,)


@dataclass(frozen=True)
class Drawn(Node):
    """A random number: `uniform` or `normal`, of a seed and one or two sites."""
    kind: str
    of: tuple[Int, ...]

    def names(self):
        return (f"smg_{self.kind}_number",)


@dataclass(frozen=True)
class OfSite(Node):
    """What a function of the coefficients gives of a site."""
    function: str
    place: Int

    def names(self):
        return (self.function, "c")


@dataclass(frozen=True)
class Real(Node):
    """A real number (or truth value): a sympy expression, and what its symbols stand for."""
    expr: sp.Basic
    leaves: dict = field(default_factory=dict, compare=False)

    def parts(self):
        return iter(self.leaves.values())

    def is_number(self, value: float) -> bool:
        return bool(self.expr.is_Number) and float(self.expr) == value


def real_of(leaf: Node) -> Real:
    """The number that is one leaf."""
    return Real(sp.Symbol("it"), {"it": leaf})


# Other values

@dataclass(frozen=True)
class Name(Node):
    """A variable, or an entry of one: `sum[0]`."""
    text: str

    def names(self):
        return (self.text.partition("[")[0],)


@dataclass(frozen=True)
class Member(Node):
    """What a pointer's struct has under a name, as `s->m`."""
    of: str
    name: str

    def names(self):
        return (self.of,)


@dataclass(frozen=True)
class Element(Node):
    """An entry of an array of numbers as the target has them."""
    array: str
    place: int

    def names(self):
        return (self.array,)


@dataclass(frozen=True)
class At(Node):
    """The place `offset` of an array, handed to a function; written: whether that one writes there."""
    array: Node
    offset: Int
    written: bool = False


@dataclass(frozen=True)
class Unary(Node):
    """`&x`, `*x`, or a conversion `(kind)x`."""
    op: str
    of: Node


@dataclass(frozen=True)
class Ordered(Node):
    """+, -, * or / of real numbers just as it stands: rounding is part of what it says."""
    op: str
    left: Node
    right: Node


@dataclass(frozen=True)
class Number(Node):
    value: float


@dataclass(frozen=True)
class Call(Node):
    """Of a function; a value, or a statement."""
    function: str
    args: tuple

    def names(self):
        return (self.function,)


@dataclass(frozen=True)
class Braces(Node):
    """The members of a struct or an array, one after the other."""
    args: tuple


# Statements

class Declaration(Node):
    """A statement after which its name is known."""


@dataclass(frozen=True)
class Let(Declaration):
    """A constant of a kind, an integer unless it is said."""
    name: str
    value: Node
    kind: str = "const int64_t"


@dataclass(frozen=True)
class Value(Declaration):
    """A real number of the target, or a truth value, under a name."""
    name: str
    value: Real


@dataclass(frozen=True)
class Variable(Declaration):
    """What is assigned later; `start`: to begin with."""
    kind: str
    name: str
    start: Node | None = None


@dataclass(frozen=True)
class Zeros(Declaration):
    """An array of zeros."""
    name: str
    size: int


@dataclass(frozen=True)
class Assign(Node):
    """A statement; also a value, what has been assigned."""
    target: Node
    value: Node
    op: str = "="


@dataclass(frozen=True)
class Add(Node):
    """target += value, in the arithmetic of the target."""
    target: Component
    value: Real


@dataclass(frozen=True)
class Return(Node):
    value: Node | None = None


class Block(Node):
    """A statement with a body; scopes in it that keep nothing apart are dissolved."""

    def __post_init__(self):
        object.__setattr__(self, "body", tidy(self.body))


@dataclass(frozen=True)
class For(Block):
    """index = start, start + step, .. below end; of step -1 the same numbers as of step 1, the last one first. over: what is counted, for targets that share work out: `sites`, `pairs`,
    `edges`, `cells` of a lattice, `entries` of an array, or `colours`: one after the other, and within one no two sites meet. few: there may be
    so few that each gets a copy of the body."""
    index: str
    start: Int
    end: Int
    body: tuple
    step: int | Int = 1
    over: str = "sites"
    few: bool = False

    def names(self):
        return (self.index,)


@dataclass(frozen=True)
class If(Block):
    """body, where all tests hold."""
    tests: tuple
    body: tuple


@dataclass(frozen=True)
class Either(Node):
    """A test that holds where one of these does."""
    tests: tuple


@dataclass(frozen=True)
class Not(Node):
    test: Node


@dataclass(frozen=True)
class Scope(Block):
    """A body whose names are its own."""
    body: tuple


def tidy(body) -> tuple:
    """The body without scopes whose names nothing else in it declares."""
    body = tuple(body)
    if not any(isinstance(statement, Scope) for statement in body):
        return body
    names = [declared(statement) for statement in body]
    times = Counter(name for each in names for name in each)
    return tuple(inner for statement, each in zip(body, names)
                 for inner in (statement.body if isinstance(statement, Scope) and (apart(statement) or all(times[name] == 1 for name in each)) else (statement,)))


def apart(scope) -> bool:
    """Has each of its statements a scope of its own?"""
    return all(isinstance(one, Block) for one in scope.body)


def declared(statement) -> set:
    """Names that a statement declares, in itself or deeper."""
    own = {statement.name} if isinstance(statement, Declaration) else {statement.index} if isinstance(statement, For) else set()
    return own.union(*map(declared, statement.body)) if isinstance(statement, Block) else own


def where(tests, body) -> Node:
    """The body under some tests, or by itself under none."""
    tests = tuple(dict.fromkeys(test for test in tests if test is not True))
    return If(tests, body) if tests else Scope(body)


# Definitions

@dataclass(frozen=True)
class Argument:
    """Of a function; signature: of a pointer to a function, its arguments."""
    kind: str
    name: str
    signature: str = ""


@dataclass(frozen=True)
class Function(Block):
    """target: the printer that writes it (`gen/compile/emit/targets.py`); wanted: it stays where nothing here mentions it;
    inlined: `usual`, `always` (and the calls in it), `never`; `lanes`: nothing calls it where there is one lane."""
    kind: str
    name: str
    arguments: tuple
    body: tuple
    target: str = "scalar"
    wanted: bool = False
    inlined: str = "usual"


@dataclass(frozen=True)
class Struct(Node):
    """A type of numbers of the target."""
    name: str
    members: tuple
    wanted: bool = True
    target: str = "scalar"


@dataclass(frozen=True)
class Table(Node):
    """Constants; columns: entries of a row, where there are rows."""
    name: str
    kind: str
    values: tuple = field(repr=False)
    columns: int = 0
    wanted: bool = False

    def parts(self) -> list:
        """No nodes: the values are numbers."""
        return []


# What a tree says

def walk(node: Node):
    """The node and all inside it."""
    left = [node]
    while left:
        one = left.pop()
        yield one
        left += one.parts()


def mentions(*nodes) -> set:
    """The names that they mention."""
    return {name for node in nodes for one in walk(node) for name in one.names()}


def written(*nodes) -> set:
    """The places that they write: of arrays handed to functions, and components that are assigned or added to."""
    found = [one for node in nodes for one in walk(node)]
    return {one for one in found if isinstance(one, At) and one.written} | {
        one.target for one in found if isinstance(one, (Add, Assign))}


def needed(definitions, rest) -> list:
    """Those that are wanted, or mentioned by `rest` or by a later one that stays; a function follows what it calls."""
    known, kept = set(rest), []
    for one in reversed(list(definitions)):
        if one.wanted or one.name in known:
            kept.append(one)
            known |= mentions(one)
    return kept[::-1]


def refuse(*tests) -> tuple:
    """Statements that return SMG_BAD_PARAMETER where one of the tests holds; none where none can."""
    open_ = tuple(test for test in tests if test is not False)
    if not open_:
        return ()
    bad = (Return(Name("SMG_BAD_PARAMETER")),)
    if True in open_:
        return bad
    return (If((Either(open_) if len(open_) > 1 else open_[0],), bad),)
