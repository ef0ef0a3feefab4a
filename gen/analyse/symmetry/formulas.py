"""Formulas of a spec as elements of the algebra: scalars are polynomials, vectors triples."""
from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import sympy as sp

from ...language import draws
from ...language.expr import Elem, Expr, Idx, Num, Op, Par, Spin, Time, Weight, is_draw
from . import bounds
from . import polynomial as poly
from .algebra import Algebra



class NotDecided(Exception):
    """What a formula means is outside of what the algebra knows; the message says what."""


@dataclass
class Formulas:
    """Reads formulas of one term. values: numbers of parameters and tables by name, or None
    for parameters that stay symbols; indices: index name -> site number, or a label where it
    stays any; columns: graph column -> its number, missing where it stays any."""
    algebra: Algebra
    values: dict | None
    numbers: dict
    indices: dict
    columns: dict

    def value(self, e: Expr):
        return getattr(self, "_" + type(e).__name__.lower())(e)

    def _num(self, e: Num):
        return self.algebra.leaf("pi", True) if e.value == math.pi else poly.constant(e.value)

    def _par(self, e: Par):
        if self.values is None:
            return self.algebra.leaf(f"p.{e.name}", True)
        return poly.constant(_finite(self.values[e.name]))

    def _time(self, e: Time):
        return self.algebra.leaf("t", False)

    def _idx(self, e: Idx):
        place = self.indices[e.name]
        return poly.constant(place) if isinstance(place, int) else self.algebra.leaf(f"i.{place}", False)

    def _weight(self, e: Weight):
        if e.name in self.columns:
            return poly.constant(_finite(self.columns[e.name]))
        return self.algebra.leaf(f"e.{e.name}", False)

    def _spin(self, e: Spin):
        return self.algebra.vector(e.family, self.indices.get(e.slot, e.slot))

    def _elem(self, e: Elem):
        """An entry: a number where entry and table are known, or where all entries are equal."""
        index, table = self.value(e.index), self._table(e.name)
        at = poly.number_of(index)
        if table is not None and at is not None and at.denominator == 1 and 0 <= at < len(table):
            return poly.constant(_finite(table[int(at)]))
        if table is not None and len(table) and np.all(table == table[0]):
            return poly.constant(_finite(table[0]))
        name = self.algebra.leaf(f"a.{e.name}", True)
        return self.algebra.of("element", name, index)

    def _table(self, name: str):
        """The numbers of an array parameter or of a table of the spec; None: they stay symbols."""
        given = self.numbers if self.values is None else self.values
        return np.asarray(given[name], float) if name in given else None

    def _op(self, e: Op):
        if is_draw(e):
            return self._draw(e)
        arguments = [self.value(a) for a in e.args]
        return _OPERATIONS[e.op](self, *arguments)

    def _draw(self, e: Op):
        """A random number: itself where its seed and sites are known, else a function of them."""
        arguments = [self.value(a) for a in e.args]
        if e.op == "kept":
            return arguments[0]
        known = [poly.number_of(a) for a in arguments]
        if None not in known:
            return poly.constant(_finite(float(getattr(draws, e.op)(*map(int, known)))))
        seed, *sites = arguments
        return self.algebra.of(e.op, seed, *sorted(sites, key=repr))

    def add(self, a, b, sign=1):
        if isinstance(a, tuple):
            return tuple(poly.add(x, y, sign) for x, y in zip(a, b))
        return poly.add(a, b, sign)

    def negative(self, a):
        return tuple(poly.scaled(x, -1) for x in a) if isinstance(a, tuple) else poly.scaled(a, -1)

    def multiply(self, a, b):
        if isinstance(b, tuple):
            a, b = b, a
        times = self.algebra.times
        return tuple(times(x, b) for x in a) if isinstance(a, tuple) else times(a, b)

    def divide(self, a, b):
        try:
            return self.multiply(a, self.algebra.inverse(b))
        except ZeroDivisionError:
            raise NotDecided("a formula divides by zero") from None

    def power(self, a, b):
        """a^b: whole and half exponents are products and roots, others functions."""
        exponent = poly.number_of(self.algebra.reduced(b))
        if exponent is None or exponent.denominator > 2:
            return self.algebra.of("power", a, b)
        if exponent.denominator == 2:
            a, exponent = self.root(a), 2 * exponent
        power = poly.raised(a, abs(int(exponent)), self.algebra.budget)
        return self.divide(poly.constant(1), power) if exponent < 0 else power

    def root(self, a):
        return self.function("sqrt", a)

    def function(self, name: str, a):
        """A function of one argument; of a number, what sympy makes of it."""
        a = self.algebra.reduced(a)
        constant = self._constant(name, a) if self.algebra.fixed(a) else None
        return self.algebra.of(name, a) if constant is None else constant

    def _constant(self, name: str, a):
        """f(a) of a number a that is rational or a rational multiple of pi, where it is simple."""
        number = _as_sympy(self.algebra, a)
        if number is None or len(str(number)) > bounds.LONG:
            return None
        return self._from_sympy(getattr(sp, name)(number))

    def _from_sympy(self, x):
        """A polynomial in square roots of rationals, or None."""
        if x.is_Rational:
            return poly.constant(Fraction(int(x.p), int(x.q)))
        if x == sp.pi:
            return self.algebra.leaf("pi", True)
        if x.is_Pow and x.exp == sp.Rational(1, 2) and x.base.is_Rational and x.base > 0:
            return self.algebra.of("sqrt", poly.constant(Fraction(int(x.base.p), int(x.base.q))))
        if not (x.is_Add or x.is_Mul):
            return None
        parts = [self._from_sympy(part) for part in x.args]
        if any(p is None for p in parts):
            return None
        out = parts[0]
        for part in parts[1:]:
            out = self.add(out, part) if x.is_Add else self.algebra.times(out, part)
        return out

    def quotient(self, above: str, below: str, a):
        return self.divide(self.function(above, a), self.function(below, a))

    def condition(self, a, b, watched: bool = True):
        """chi of a < b. What `if` watches may make the energy jump, so it is remembered."""
        difference = self.algebra.reduced(poly.add(a, b, -1))
        number = poly.number_of(difference)
        if number is not None:
            return poly.constant(int(number < 0))
        return self._watched("condition", difference, watched)

    def equality(self, a, b):
        difference = self.algebra.reduced(poly.add(a, b, -1))
        number = poly.number_of(difference)
        if number is not None:
            return poly.constant(int(number == 0))
        return self._watched("equality", difference, True)

    def _watched(self, kind, p, watched):
        if watched:
            self.algebra.conditions.append(p)
        return self.algebra.of(kind, p)

    def opposite(self, chi):
        return poly.add(poly.constant(1), chi, -1)

    def either(self, a, b):
        return poly.add(poly.add(a, b), self.algebra.times(a, b), -1)

    def choose(self, chi, a, b):
        """chi a + (1 - chi) b"""
        return self.add(self.multiply(a, chi), self.multiply(b, self.opposite(chi)))

    def lesser(self, a, b, order=1):
        """min(a, b) or, order -1, max: continuous, so that the condition need not be watched."""
        chi = self.condition(a, b, watched=False) if order > 0 else self.condition(b, a, watched=False)
        return self.choose(chi, a, b)

    def floor(self, a):
        a = self.algebra.reduced(a)
        number = poly.number_of(a)
        return poly.constant(math.floor(number)) if number is not None else self._watched("floor", a, True)

    def modulo(self, a, b):
        return self.add(a, self.multiply(b, self.floor(self.divide(a, b))), -1)


def _finite(x):
    """A number of the run: integers exactly, floats as the decimal written for them."""
    if not math.isfinite(x):
        raise NotDecided("a value is not finite")
    return int(x) if float(x).is_integer() and abs(x) < 2 ** 53 else float(x)


def _as_sympy(algebra: Algebra, p: dict):
    """r + s pi with rational r, s, as sympy has it; None when p is something else."""
    out = sp.Integer(0)
    for m, c in p.items():
        if any(algebra.table[g].key != ("pi",) for g, _ in m):
            return None
        out += sp.Rational(c.numerator, c.denominator) * sp.pi ** sum(e for _, e in m)
    return out


def _plain(name):
    return lambda f, a: f.function(name, a)


_OPERATIONS = {
    "+": Formulas.add, "-": lambda f, a, b: f.add(a, b, -1), "neg": Formulas.negative,
    "*": Formulas.multiply, "/": Formulas.divide, "^": Formulas.power, "mod": Formulas.modulo,
    "vec": lambda f, *v: v, "x": lambda f, a: a[0], "y": lambda f, a: a[1], "z": lambda f, a: a[2],
    "dot": lambda f, a, b: f.algebra.dot(a, b), "cross": lambda f, a, b: f.algebra.cross(a, b),
    "triple": lambda f, a, b, c: f.algebra.dot(a, f.algebra.cross(b, c)),
    "norm": lambda f, a: f.root(f.algebra.dot(a, a)),
    **{name: _plain(name) for name in ("sqrt", "exp", "log", "sin", "cos", "asin", "acos", "atan", "sinh", "cosh")},
    "tan": lambda f, a: f.quotient("sin", "cos", a), "tanh": lambda f, a: f.quotient("sinh", "cosh", a),
    "atan2": lambda f, a, b: f.algebra.of("atan2", a, b), "floor": Formulas.floor,
    "abs": lambda f, a: f.lesser(a, f.negative(a), -1),
    "min": Formulas.lesser, "max": lambda f, a, b: f.lesser(a, b, -1), "if": Formulas.choose,
    "<": Formulas.condition, "<=": Formulas.condition,
    ">": lambda f, a, b: f.condition(b, a), ">=": lambda f, a, b: f.condition(b, a),
    "==": Formulas.equality, "!=": lambda f, a, b: f.opposite(f.equality(a, b)),
    "and": Formulas.multiply, "or": Formulas.either, "not": Formulas.opposite,
}
