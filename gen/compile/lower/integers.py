"""Integers as data: sizes, indices, numbers of sites. Sums and products are simplified as they are made, so that nobody
writes `3*(i)` or `x - 0`.
"""
from __future__ import annotations

import operator
from dataclasses import dataclass


class Node:
    """A piece of the intermediate form: immutable, equal to what is written alike."""

    def parts(self) -> list:
        """The nodes directly inside."""
        found: list = []
        for value in vars(self).values():
            if isinstance(value, Node):
                found.append(value)
            elif isinstance(value, tuple):
                found += [part for part in value if isinstance(part, Node)]
        return found

    def names(self) -> tuple:
        """Variables, functions and tables that this node itself mentions."""
        return ()


class Int(Node):
    """An integer expression; `+`, `-` and `*` simplify."""

    def __add__(self, other):
        return total(self, other)

    def __radd__(self, other):
        return total(other, self)

    def __sub__(self, other):
        return total(self, times(-1, other))

    def __mul__(self, other):
        return times(self, other)

    def __rmul__(self, other):
        return times(other, self)


@dataclass(frozen=True)
class Whole(Int):
    value: int


@dataclass(frozen=True)
class Index(Int):
    """A variable: the number of a site, a cell, an edge."""
    name: str

    def names(self):
        return (self.name,)


@dataclass(frozen=True)
class Field(Int):
    """A member of a struct that is held by value, as `at.k`."""
    of: str
    name: str

    def names(self):
        return (self.of,)


@dataclass(frozen=True)
class Pointed(Int):
    """A member of a struct that is pointed to."""
    of: str
    name: str

    def names(self):
        return (self.of,)


@dataclass(frozen=True)
class Size(Int):
    """A size that is known at run time, computed once: a member of the coefficients."""
    name: str

    def names(self):
        return ("c",)


@dataclass(frozen=True)
class Given(Int):
    """An integer parameter."""
    name: str

    def names(self):
        return ("c",)


@dataclass(frozen=True)
class Cell(Int):
    """An entry of a constant table of integers."""
    table: str
    places: tuple

    def names(self):
        return (self.table,)


@dataclass(frozen=True)
class Sum(Int):
    terms: tuple


@dataclass(frozen=True)
class Product(Int):
    factors: tuple


@dataclass(frozen=True)
class Divided(Int):
    """`%` or `/` of integers that are not negative."""
    op: str
    above: Int
    below: Int


@dataclass(frozen=True)
class Computed(Int):
    """The value of a function of the runtime."""
    function: str
    args: tuple

    def names(self):
        return (self.function,)


ZERO, ONE = Whole(0), Whole(1)


def whole(x) -> Int:
    return Whole(x) if isinstance(x, int) else x


def total(*parts) -> Int:
    """The sum: like terms together in the order in which they came, the number last."""
    found: dict = {}
    for part in parts:
        for factor, term in terms_of(whole(part)):
            found[term] = found.get(term, 0) + factor
    number = found.pop(ONE, 0)
    terms = [times(factor, term) for term, factor in found.items() if factor]
    terms += [Whole(number)] if number or not terms else []
    return terms[0] if len(terms) == 1 else Sum(tuple(terms))


def terms_of(e: Int):
    """[(number, rest)] of a sum."""
    if isinstance(e, Whole):
        return [(e.value, ONE)]
    if isinstance(e, Sum):
        return [pair for term in e.terms for pair in terms_of(term)]
    if isinstance(e, Product) and isinstance(e.factors[0], Whole):
        return [(e.factors[0].value, times(*e.factors[1:]))]
    return [(1, e)]


def times(*factors) -> Int:
    """The product, its number first; a minus sign goes into a sum."""
    number, rest = 1, []
    for factor in map(whole, factors):
        for f in factor.factors if isinstance(factor, Product) else (factor,):
            number, rest = (number * f.value, rest) if isinstance(f, Whole) else (number, [*rest, f])
    if number == 0 or not rest:
        return Whole(number)
    if number == -1 and len(rest) == 1 and isinstance(rest[0], Sum):
        return total(*(times(-1, term) for term in rest[0].terms))
    rest = rest if number == 1 else [Whole(number), *rest]
    return rest[0] if len(rest) == 1 else Product(tuple(rest))


def remainder(a: Int, b) -> Int:
    return ZERO if whole(b) == ONE else Divided("%", a, whole(b))


def quotient(a: Int, b) -> Int:
    return a if whole(b) == ONE else Divided("/", a, whole(b))


def wrapped(x: Int, n: Int) -> Int:
    """x in a ring of n, from at most n outside of it."""
    return Computed("smg_wrap", (x, n))


def modulo(a, n) -> Int:
    """The remainder that is not negative."""
    return Computed("smg_mod", (whole(a), whole(n)))


# Comparisons

@dataclass(frozen=True)
class Compare(Node):
    left: Node
    op: str
    right: Node


_OPERATORS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne}


def compare(left, op: str, right):
    """A comparison, or its truth where both sides are numbers."""
    left, right = whole(left), whole(right)
    if isinstance(left, Whole) and isinstance(right, Whole):
        return _OPERATORS[op](left.value, right.value)
    return Compare(left, op, right)
