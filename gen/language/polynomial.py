"""Formulas as polynomials with exact coefficients: do two of them say the same?

The variables are the components of vectors, parameters, the time, and whatever else is no sum, product or whole power: a function of polynomials is a
variable of its own, the same one for the same arguments. A polynomial is {monomial: coefficient}, a monomial ((variable, exponent), ..) in the order of
the variables; quotients by a single term have negative exponents.
"""
from __future__ import annotations

from fractions import Fraction

from .expr import Elem, Expr, Idx, Num, Op, Par, Spin, Time, Weight, kind_of

MOST = 4000             # terms of a polynomial
POWER = 16              # of an exponent that is multiplied out
AXES = "xyz"
ONE = {(): Fraction(1)}


class TooLong(Exception):
    """A formula with too many terms when it is multiplied out."""


class Polynomials:
    """The variables that formulas share. spin, square: the vector whose square is known, |spin|^2 = square, a formula, or None."""

    def __init__(self, spin: Spin | None = None, square: Expr | None = None):
        self.variables: dict = {}       # what a variable stands for -> its number
        self.spin = self.square = None
        if square is not None:
            self.square, self.spin = self.scalar(square), [self.number(("component", spin, a)) for a in AXES]

    def number(self, what) -> int:
        return self.variables.setdefault(what, len(self.variables))

    def variable(self, what) -> dict:
        return {((self.number(what), 1),): Fraction(1)}

    # -- formulas -------------------------------------------------------------------------------
    def scalar(self, e: Expr) -> dict:
        if isinstance(e, Num):
            return plain({(): Fraction(str(e.value))})
        if not isinstance(e, Op):
            return self.variable(e)
        if e.op in AXES:
            return self.vector(e.args[0])[AXES.index(e.op)]
        found = getattr(self, NAMES.get(e.op, "function"))(e)
        if len(found) > MOST:
            raise TooLong
        return found

    def vector(self, e: Expr) -> tuple:
        """Its three components."""
        if isinstance(e, Spin):
            return tuple(self.variable(("component", e, a)) for a in AXES)
        if e.op == "vec":
            return tuple(map(self.scalar, e.args))
        if e.op == "cross":
            return cross(*map(self.vector, e.args))
        if e.op in ("+", "-", "neg"):
            first, *other = map(self.vector, e.args)
            return tuple(added(a, b, -1 if e.op == "-" else 1) for a, b in zip(first, other[0])) if other else tuple(scaled(a, -1) for a in first)
        if e.op == "if":
            test = self.variable(("holds", e.args[0]))
            a, b = map(self.vector, e.args[1:])
            return tuple(added(product(test, x), product(added(ONE, test, -1), y)) for x, y in zip(a, b))
        a, b = e.args if kind_of(e.args[0]) == "v" else e.args[::-1]
        by = self.scalar(b) if e.op == "*" else self.inverse(b)
        return tuple(product(x, by) for x in self.vector(a))

    def sum(self, e: Op) -> dict:
        return added(self.scalar(e.args[0]), self.scalar(e.args[1]), -1 if e.op == "-" else 1)

    def negative(self, e: Op) -> dict:
        return scaled(self.scalar(e.args[0]), -1)

    def times(self, e: Op) -> dict:
        return product(*map(self.scalar, e.args))

    def over(self, e: Op) -> dict:
        return product(self.scalar(e.args[0]), self.inverse(e.args[1]))

    def inverse(self, e: Expr) -> dict:
        """1/e: of one term another one, else a variable."""
        below = self.reduced(self.scalar(e))
        if len(below) != 1:
            return self.variable(("inverse", key(below)))
        (monomial, coefficient), = below.items()
        return {tuple((v, -n) for v, n in monomial): 1 / coefficient}

    def power(self, e: Op) -> dict:
        base, exponent = e.args
        whole = isinstance(exponent, Num) and exponent.value == int(exponent.value) and abs(exponent.value) <= POWER
        if whole and isinstance(base, Op) and base.op == "norm" and exponent.value % 2 == 0:
            base, exponent = Op("dot", base.args * 2), Num(int(exponent.value) // 2)
        if not whole:
            return self.function(e)
        factor, found = self.scalar(base) if exponent.value >= 0 else self.inverse(base), ONE
        for _ in range(abs(int(exponent.value))):
            found = product(found, factor)
        return found

    def dot(self, e: Op) -> dict:
        return dot(*map(self.vector, e.args))

    def triple(self, e: Op) -> dict:
        a, b, c = map(self.vector, e.args)
        return dot(a, cross(b, c))

    def function(self, e: Op) -> dict:
        """A variable of its own, by its name and arguments."""
        return self.variable((e.op, *map(self.argument, e.args)))

    def argument(self, e: Expr):
        kind = kind_of(e)
        return e if kind == "b" else key(self.reduced(self.scalar(e))) if kind == "s" else tuple(key(self.reduced(x)) for x in self.vector(e))

    # -- on the sphere --------------------------------------------------------------------------
    def reduced(self, p: dict) -> dict:
        """p with square - x^2 - y^2 in place of z^2, x, y, z the components of the vector whose square is known."""
        if self.square is None:
            return p
        x, y, z = self.spin
        rest = added(added(self.square, {((x, 2),): Fraction(1)}, -1), {((y, 2),): Fraction(1)}, -1)
        while any(dict(m).get(z, 0) > 1 for m in p):
            found: dict = {}
            for m, c in p.items():
                powers = dict(m)
                if powers.get(z, 0) > 1:
                    powers[z] -= 2
                    found = added(found, product({ordered(powers): c}, rest))
                else:
                    found = added(found, {m: c})
            p = found
        return p

    # -- as text --------------------------------------------------------------------------------
    def text(self, p: dict, most: int = 4) -> str:
        names = {n: what for what, n in self.variables.items()}
        terms = [self.term(m, c, names) for m, c in list(p.items())[:most]]
        whole = " + ".join(terms).replace("+ -", "- ")
        return whole + (f" + {len(p) - most} more terms" if len(p) > most else "")

    def term(self, monomial, coefficient, names) -> str:
        factors = [self.named(names[v]) + (f"^{n}" if n > 1 else f"^({n})" if n < 0 else "") for v, n in monomial]
        size = abs(coefficient)
        number = [] if size == 1 and factors else [str(size.numerator if size.denominator == 1 else float(size))]
        return ("-" if coefficient < 0 else "") + "*".join(number + factors)

    def named(self, what) -> str:
        """A variable as the spec writes it; of a function its name alone."""
        if isinstance(what, tuple):
            return f"{named(what[1])}.{what[2]}" if what[0] == "component" else "(..)" if what[0] == "inverse" else f"{what[0]}(..)"
        return named(what)


NAMES = {"+": "sum", "-": "sum", "neg": "negative", "*": "times", "/": "over", "^": "power", "dot": "dot", "triple": "triple"}


def named(e) -> str:
    if isinstance(e, (Spin, Elem)):
        name, at = (e.family, e.slot) if isinstance(e, Spin) else (e.name, e.index)
        return f"{name}[{at if isinstance(at, (str, int)) else named(at)}]"
    if isinstance(e, Num):
        return str(e.value)
    return "t" if isinstance(e, Time) else e.name if isinstance(e, (Par, Idx, Weight)) else "(..)"


# Arithmetic

def plain(p: dict) -> dict:
    return {m: c for m, c in p.items() if c}


def added(p: dict, q: dict, sign: int = 1) -> dict:
    found = dict(p)
    for m, c in q.items():
        found[m] = found.get(m, 0) + sign * c
    return plain(found)


def scaled(p: dict, c) -> dict:
    return {m: c * x for m, x in p.items()}


def product(p: dict, q: dict) -> dict:
    if len(p) * len(q) > MOST:
        raise TooLong
    found: dict = {}
    for m, c in p.items():
        for n, d in q.items():
            powers = dict(m)
            for v, k in n:
                powers[v] = powers.get(v, 0) + k
            both = ordered(powers)
            found[both] = found.get(both, 0) + c * d
    return plain(found)


def ordered(powers: dict) -> tuple:
    return tuple(sorted((v, n) for v, n in powers.items() if n))


def key(p: dict) -> tuple:
    return tuple(sorted(p.items()))


def dot(u, v) -> dict:
    return added(added(product(u[0], v[0]), product(u[1], v[1])), product(u[2], v[2]))


def cross(u, v) -> tuple:
    return tuple(added(product(u[i], v[j]), product(u[j], v[i]), -1) for i, j in ((1, 2), (2, 0), (0, 1)))
