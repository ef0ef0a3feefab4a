"""Resolved expressions: the one language that every later stage reads.

The reader turns spec text into these nodes (names resolved, sub-formulas expanded,
types checked); `derive` turns them into sympy, the witness interprets them.
A node is a scalar, a vector of R^3 or a truth value: `kind_of` says which.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Union


@dataclass(frozen=True)
class Num:
    """A number literal. `value` is an int, or a float from the spec's text."""
    value: Union[int, float]


@dataclass(frozen=True)
class Par:
    """A scalar parameter (real or int) of the spec."""
    name: str


@dataclass(frozen=True)
class Elem:
    """Entry `index` of an array parameter or of a constant table (`Spec.tables`)."""
    name: str
    index: "Expr"


@dataclass(frozen=True)
class Time:
    """The time t."""


@dataclass(frozen=True)
class Idx:
    """The integer value (0-based) of an index bound by the index family, as a number; bond: that of a bond, not of a site."""
    name: str
    bond: bool = False


@dataclass(frozen=True)
class Weight:
    """A column of the graph file, bound by name in `edge(i, j, J) of g`."""
    name: str


@dataclass(frozen=True)
class Spin:
    """The vector of one site: `family[slot]`; slot is a bound index name or a fixed integer."""
    family: str
    slot: Union[str, int]


@dataclass(frozen=True)
class Op:
    """Operator or function applied to `args`; the names are those of `ARITY`."""
    op: str
    args: tuple["Expr", ...]


Expr = Union[Num, Par, Elem, Time, Idx, Weight, Spin, Op]

# Random numbers that integers decide, a seed and one or two indices: a node of their own to whoever differentiates or evaluates.
DRAWS = ("uniform", "normal")

# op -> (argument kinds, result kind); s scalar, v vector, b truth value.
SIGNATURES = {
    "+": [("ss", "s"), ("vv", "v")], "-": [("ss", "s"), ("vv", "v")],
    "neg": [("s", "s"), ("v", "v")],
    "*": [("ss", "s"), ("sv", "v"), ("vs", "v")],
    "/": [("ss", "s"), ("vs", "v")],
    "^": [("ss", "s")],
    "vec": [("sss", "v")], "x": [("v", "s")], "y": [("v", "s")], "z": [("v", "s")],
    "dot": [("vv", "s")], "cross": [("vv", "v")], "triple": [("vvv", "s")],
    "norm": [("v", "s")],
    **{f: [("s", "s")] for f in (
        "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan",
        "sinh", "cosh", "tanh", "abs", "floor")},
    "atan2": [("ss", "s")], "mod": [("ss", "s")],
    "min": [("ss", "s")], "max": [("ss", "s")],
    "if": [("bss", "s"), ("bvv", "v")],
    "<": [("ss", "b")], "<=": [("ss", "b")], ">": [("ss", "b")], ">=": [("ss", "b")],
    "==": [("ss", "b")], "!=": [("ss", "b")],
    **{f: [("ss", "s"), ("sss", "s")] for f in DRAWS}, "kept": [("s", "s")],
    "and": [("bb", "b")], "or": [("bb", "b")], "not": [("b", "b")],
}


def kind_of(e: Expr) -> str:
    """'s', 'v' or 'b'. Raises KeyError when the arguments do not fit the operator."""
    if isinstance(e, Spin):
        return "v"
    if isinstance(e, Op):
        kinds = "".join(kind_of(a) for a in e.args)
        return dict(SIGNATURES[e.op])[kinds]
    return "s"


def is_draw(e: Expr) -> bool:
    """Is it a number that integers decide, a random one or one that is `kept`: the value of a formula of a single site that a state keeps?"""
    return isinstance(e, Op) and (e.op in DRAWS or e.op == "kept")


def walk(e: Expr):
    """All nodes of `e`, parents first."""
    yield e
    for a in getattr(e, "args", ()):
        yield from walk(a)
    if isinstance(e, Elem):
        yield from walk(e.index)


def timed(*formulas) -> bool:
    """Does the time enter one of them?"""
    return any(isinstance(node, Time) for e in formulas for node in walk(e))


def slots_of(e: Expr) -> tuple:
    """The distinct (family, slot) pairs of an expression, in order of appearance."""
    return tuple(dict.fromkeys((n.family, n.slot) for n in walk(e) if isinstance(n, Spin)))


def with_index(e: Expr, name: str, number: Expr) -> Expr:
    """`e` with `number` in place of the index `name`."""
    if isinstance(e, Idx):
        return number if e.name == name else e
    if isinstance(e, Elem):
        return Elem(e.name, with_index(e.index, name, number))
    return Op(e.op, tuple(with_index(a, name, number) for a in e.args)) if isinstance(e, Op) else e
