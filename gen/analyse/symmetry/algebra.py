"""The algebra of a spec's formulas: polynomials in vectors, leaves and functions of those.

Every leaf (a component, an index, a parameter) and every function of a polynomial that is none
itself (1/P, sqrt P, sin P, ..) is a generator of its own. An identity that holds for independent
generators holds for the functions: what is found here is never wrong, though a relation that
only the functions have may be missed. Relations that are used: s^2 = P for s = sqrt P,
cos^2 = 1 - sin^2, cosh^2 = 1 + sinh^2, chi^2 = chi for a condition chi, and |v|^2 = r^2 on
spheres of a known radius.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

from . import polynomial as poly
from .polynomial import Budget


@dataclass(frozen=True)
class Generator:
    """kind 'vector' (family, label, component), 'leaf' (name, is it a constant of the motion's
    law: a parameter), or the name of a function with the polynomials it is applied to."""
    kind: str
    key: tuple
    arguments: tuple = ()
    fixed: bool = False       # depends on parameters and numbers alone


@dataclass
class Algebra:
    """Generators by number. spheres: family -> polynomial r^2, where |v|^2 = r^2 may be used."""
    budget: Budget
    spheres: dict = field(default_factory=dict)
    table: list = field(default_factory=list)
    known: dict = field(default_factory=dict)
    slopes: dict = field(default_factory=dict)
    conditions: list = field(default_factory=list)    # polynomials that `if`, floor and mod look at

    # generators

    def _number(self, kind, key, arguments=(), fixed=False) -> int:
        if (kind, key) not in self.known:
            self.known[kind, key] = len(self.table)
            self.table.append(Generator(kind, key, arguments, fixed))
        return self.known[kind, key]

    def vector(self, family: str, label) -> tuple:
        """The three components of one site's vector."""
        return tuple(poly.generator(self._number("vector", (family, label, c))) for c in range(3))

    def leaf(self, name, fixed: bool) -> dict:
        return poly.generator(self._number("leaf", (name,), fixed=fixed))

    def of(self, function: str, *arguments: dict) -> dict:
        """A function of polynomials, as a generator."""
        arguments = tuple(self.reduced(a) for a in arguments)
        key = (function, *(frozenset(a.items()) for a in arguments))
        fixed = all(self.table[g].fixed for a in arguments for g in poly.generators_of(a))
        return poly.generator(self._number(function, key, arguments, fixed))

    def fixed(self, p: dict) -> bool:
        """Does p depend on parameters and numbers alone?"""
        return all(self.table[g].fixed for g in poly.generators_of(p))

    # arithmetic

    def times(self, p: dict, q: dict) -> dict:
        return poly.times(p, q, self.budget)

    def dot(self, a, b) -> dict:
        out: dict = {}
        for x, y in zip(a, b):
            out = poly.add(out, self.times(x, y))
        return out

    def cross(self, a, b) -> tuple:
        def minor(i, j):
            return poly.add(self.times(a[i], b[j]), self.times(a[j], b[i]), -1)
        return minor(1, 2), minor(2, 0), minor(0, 1)

    def inverse(self, p: dict) -> dict:
        """1/p; of a number it is one, otherwise 1/(c P) = (1/c) 1/P with P monic."""
        p = self.reduced(p)
        number = poly.number_of(p)
        if number is not None:
            if number == 0:
                raise ZeroDivisionError
            return poly.constant(1 / number)
        if len(p) == 1 and len(m := next(iter(p))) == 1 and self.table[m[0][0]].kind == "inverse":
            g, e = m[0]                                              # 1/(c/P^e) = P^e/c
            return poly.scaled(poly.raised(self.table[g].arguments[0], e, self.budget), 1 / p[m])
        lead = p[min(p)]
        return poly.scaled(self.of("inverse", poly.scaled(p, 1 / lead)), 1 / lead)

    # differentiation

    def derivative(self, p: dict, g: int) -> dict:
        """d p/d g, through all functions."""
        out = poly.derivative(p, g)
        for f in poly.generators_of(p):
            if self.table[f].arguments:
                slope = self.slope(f, g)
                if slope:
                    out = poly.add(out, self.times(poly.derivative(p, f), slope))
        return out

    def slope(self, f: int, g: int) -> dict:
        """The derivative of the function f by generator g: sum of outer times inner slopes."""
        if (f, g) not in self.slopes:
            total: dict = {}
            one = self.table[f]
            for k, argument in enumerate(one.arguments):
                inner = self.derivative(argument, g)
                if inner:
                    total = poly.add(total, self.times(self.outer(f, one, k), inner))
            self.slopes[f, g] = total
        return self.slopes[f, g]

    def outer(self, f: int, one: Generator, k: int) -> dict:
        """The derivative of a function by its argument k."""
        return _SLOPES[one.kind](self, poly.generator(f), *one.arguments)[k]

    # normal forms

    def reduced(self, p: dict) -> dict:
        """p with the relations of its generators used; linear in p, the newest generators first."""
        done: set = set()
        while left := poly.generators_of(p) - done:
            done.add(g := max(left))
            relation = self._square(g) or self._sphere(g)
            if relation:
                p = self._lowered(p, g, relation)
        return p

    def _square(self, g: int):
        """The polynomial that g^2 is, or None."""
        one = self.table[g]
        if one.kind == "sqrt":
            return one.arguments[0]
        if one.kind in ("cos", "cosh"):
            partner = self.of({"cos": "sin", "cosh": "sinh"}[one.kind], *one.arguments)
            square = self.times(partner, partner)
            return poly.add(poly.constant(1), square, -1 if one.kind == "cos" else 1)
        return poly.generator(g) if one.kind == "condition" else None

    def _sphere(self, g: int):
        """r^2 - x^2 - y^2 for the z component of a vector on a sphere."""
        one = self.table[g]
        if one.kind != "vector" or one.key[2] != 2 or one.key[0] not in self.spheres:
            return None
        x, y, _ = self.vector(*one.key[:2])
        out = self.spheres[one.key[0]]
        for v in (x, y):
            out = poly.add(out, self.times(v, v), -1)
        return out

    def _lowered(self, p: dict, g: int, square: dict) -> dict:
        """p with g^2 replaced by `square`."""
        if poly.degree_in(p, g) < 2:
            return p
        out: dict = {}
        for exponent, part in poly.split(p, g).items():
            low = poly.generator(g, exponent % 2)
            if square == poly.generator(g):                      # g^2 = g
                low, power = poly.generator(g, min(exponent, 1)), poly.constant(1)
            else:
                power = poly.raised(square, exponent // 2, self.budget)
            out = poly.add(out, self.times(self.times(part, low), power))
        return out

    def cleared(self, ps: list) -> list:
        """The polynomials times a common denominator: 1/P is gone where it multiplies sums."""
        for g in sorted({g for p in ps for g in poly.generators_of(p)}, reverse=True):
            if self.table[g].kind == "inverse":
                most = max(poly.degree_in(p, g) for p in ps)
                ps = [self._without(p, g, most) for p in ps]
        return [self.reduced(p) for p in ps]

    def _without(self, p: dict, g: int, most: int) -> dict:
        """p P^most with P^k 1/P^k = 1."""
        out: dict = {}
        for exponent, part in poly.split(p, g).items():
            power = poly.raised(self.table[g].arguments[0], most - exponent, self.budget)
            out = poly.add(out, self.times(part, power))
        return out


def _one(p):
    return poly.constant(p)


def _over_root(a: Algebra, p: dict, sign: int) -> dict:
    """1/sqrt(1 + sign p^2)"""
    return a.inverse(a.of("sqrt", poly.add(_one(1), a.times(p, p), sign)))


def _turn(a: Algebra, y: dict, x: dict) -> tuple:
    """Slopes of atan2(y, x): x/(x^2 + y^2), -y/(x^2 + y^2)."""
    over = a.inverse(poly.add(a.times(x, x), a.times(y, y)))
    return a.times(x, over), poly.scaled(a.times(y, over), -1)


# function -> slopes by each argument, from (algebra, the function itself, its arguments)
_SLOPES = {
    "inverse": lambda a, f, p: (poly.scaled(a.times(f, f), -1),),
    "sqrt": lambda a, f, p: (poly.scaled(a.inverse(f), Fraction(1, 2)),),
    "exp": lambda a, f, p: (f,),
    "log": lambda a, f, p: (a.inverse(p),),
    "sin": lambda a, f, p: (a.of("cos", p),),
    "cos": lambda a, f, p: (poly.scaled(a.of("sin", p), -1),),
    "sinh": lambda a, f, p: (a.of("cosh", p),),
    "cosh": lambda a, f, p: (a.of("sinh", p),),
    "atan": lambda a, f, p: (a.inverse(poly.add(_one(1), a.times(p, p))),),
    "asin": lambda a, f, p: (_over_root(a, p, -1),),
    "acos": lambda a, f, p: (poly.scaled(_over_root(a, p, -1), -1),),
    "atan2": lambda a, f, y, x: _turn(a, y, x),
    "power": lambda a, f, p, n: (a.times(a.times(n, f), a.inverse(p)), a.times(f, a.of("log", p))),
    "element": lambda a, f, p: ({},),
    "condition": lambda a, f, p: ({},),
    "equality": lambda a, f, p: ({},),
    "floor": lambda a, f, p: ({},),
}
