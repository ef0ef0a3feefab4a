"""Sparse polynomials with exact rational coefficients, and a bound on the work they may cause.

A polynomial is a dict monomial -> Fraction; a monomial a tuple of (generator, exponent), sorted
by generator; generators are integers that `algebra` gives a meaning. No zero is stored. Every
product is counted, so that a hostile formula ends in `TooMuch` after the same number of
operations on every machine.
"""
from __future__ import annotations

from fractions import Fraction

from . import bounds

ONE = ()


class TooMuch(Exception):
    """The operations allowed are spent: nothing may be concluded."""


class Budget:
    """Counts term products. Raises TooMuch past `bounds.PRODUCTS`."""

    def __init__(self, products: int | None = None):
        self.left = bounds.PRODUCTS if products is None else products

    def spend(self, products: int):
        self.left -= products
        if self.left < 0:
            raise TooMuch


def constant(value) -> dict:
    """A number; a float means the decimal number that is written for it."""
    value = Fraction(repr(float(value))) if isinstance(value, float) else Fraction(value)
    return {ONE: value} if value else {}


def generator(number: int, exponent: int = 1) -> dict:
    return {((number, exponent),): Fraction(1)} if exponent else {ONE: Fraction(1)}


def number_of(p: dict):
    """The Fraction that p is, or None when it is no number."""
    if not p:
        return Fraction(0)
    return p[ONE] if len(p) == 1 and ONE in p else None


def join(m: tuple, n: tuple) -> tuple:
    """The product of two monomials."""
    if not m or not n:
        return m or n
    exponents = dict(m)
    for g, e in n:
        exponents[g] = exponents.get(g, 0) + e
    return tuple(sorted(exponents.items()))


def add(p: dict, q: dict, factor=1) -> dict:
    """p + factor*q."""
    out = dict(p)
    for m, c in q.items():
        total = out.get(m, 0) + factor * c
        if total:
            out[m] = total
        else:
            out.pop(m, None)
    return out


def scaled(p: dict, factor) -> dict:
    return {m: factor * c for m, c in p.items()} if factor else {}


def times(p: dict, q: dict, budget: Budget) -> dict:
    """p q, paid for term by term; long coefficients cost more."""
    out: dict = {}
    for m, a in p.items():
        budget.spend(len(q) * (1 + a.numerator.bit_length() // 256))
        for n, b in q.items():
            k = join(m, n)
            total = out.get(k, 0) + a * b
            if total:
                out[k] = total
            else:
                out.pop(k, None)
    return out


def raised(p: dict, exponent: int, budget: Budget) -> dict:
    """p^exponent for exponent >= 0."""
    out = constant(1)
    for _ in range(exponent):
        out = times(out, p, budget)
    return out


def degree_in(p: dict, g: int) -> int:
    """The largest exponent of generator g."""
    return max((dict(m).get(g, 0) for m in p), default=0)


def split(p: dict, g: int) -> dict:
    """p as a polynomial in g alone: exponent -> coefficient polynomial."""
    parts: dict = {}
    for m, c in p.items():
        exponent = dict(m).get(g, 0)
        parts.setdefault(exponent, {})[tuple(x for x in m if x[0] != g)] = c
    return parts


def generators_of(p: dict) -> set:
    return {g for m in p for g, _ in m}


def derivative(p: dict, g: int) -> dict:
    """The partial derivative by generator g."""
    out: dict = {}
    for m, c in p.items():
        exponents = dict(m)
        e = exponents.get(g, 0)
        if e:
            exponents[g] = e - 1
            out[tuple((k, n) for k, n in exponents.items() if n)] = c * e
    return out
