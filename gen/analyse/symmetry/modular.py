"""How many forms can be conserved at most? By values at random points, in arithmetic modulo a prime.

A conserved form has P.q = 0 at every state; so the null space at some states is no smaller than that of all, and modulo a prime
none of a rational matrix shrinks. Where as many are known already, there are no others, and no polynomial was multiplied out.
"""
from __future__ import annotations

import numpy as np

from ...chance import generator
from .algebra import Algebra
from .torque import Torques

PRIME = 2 ** 31 - 1     # 3 modulo 4, so that a^((p + 1)/4) is a root of a, if it has one; products fit 63 bits
MORE = 8                # states beyond the number of unknowns
TRIES = 200


class NoValue(Exception):
    """A function that has no value modulo a prime."""


def most(found: Torques, velocities, places, entries) -> int | None:
    """The dimension of the null space at random states; None where the field is no rational function of the state."""
    draw, lines = generator("values modulo a prime"), []
    try:
        while len(lines) < len(entries) + MORE:
            lines += _lines(found, velocities, places, entries, draw)
    except (NoValue, RecursionError):
        return None
    return len(entries) - rank(np.array(lines, dtype=np.int64))


def _lines(found: Torques, velocities, places, entries, draw):
    """A row for each orbit, at one state: v_i s_j + v_j s_i."""
    for _ in range(TRIES):
        at = Values(found.algebra, draw)
        try:
            v = [at.of(c) for place in places for c in found.algebra.vector(*place)]
            slopes = [[at.of(p) for p in velocities(o)] for o in found.orbits]
        except ZeroDivisionError:
            continue
        return [[v[i] * s[i] % PRIME if i == j else (v[i] * s[j] + v[j] * s[i]) % PRIME for i, j in entries] for s in slopes]
    raise NoValue


def rank(rows: np.ndarray) -> int:
    """Of a matrix of residues."""
    rows, found = rows % PRIME, 0
    for column in range(rows.shape[1] if rows.size else 0):
        pivot = next((k for k in range(found, len(rows)) if rows[k, column]), None)
        if pivot is None:
            continue
        rows[[found, pivot]] = rows[[pivot, found]]
        rows[found] = rows[found] * pow(int(rows[found, column]), -1, PRIME) % PRIME
        rows[found + 1:] = (rows[found + 1:] - rows[found + 1:, column, None] * rows[found] % PRIME) % PRIME
        found += 1
    return found


def residue(x) -> int:
    """Of a rational number, of sympy's or a Fraction."""
    top, bottom = (x.p, x.q) if hasattr(x, "p") else (x.numerator, x.denominator)
    return int(top) * pow(int(bottom), -1, PRIME) % PRIME


class Values:
    """Generators at one random state: vectors on their spheres, other leaves anywhere."""

    def __init__(self, algebra: Algebra, draw: np.random.Generator):
        self.algebra, self.draw, self.known = algebra, draw, {}

    def of(self, p: dict) -> int:
        """The value of a polynomial. Raises ZeroDivisionError at a pole, NoValue."""
        total = 0
        for monomial, c in p.items():
            term = residue(c)
            for g, e in monomial:
                term = term * pow(self.generator(g), e, PRIME) % PRIME
            total += term
        return total % PRIME

    def generator(self, g: int) -> int:
        if g not in self.known:
            one = self.algebra.table[g]
            if one.kind == "vector":
                self._place(one)
            elif one.kind == "leaf":
                self.known[g] = int(self.draw.integers(PRIME))
            elif one.kind == "inverse":
                value = self.of(one.arguments[0])
                if not value:
                    raise ZeroDivisionError
                self.known[g] = pow(value, -1, PRIME)
            else:
                raise NoValue
        return self.known[g]

    def _place(self, one) -> None:
        """All three components of a vector."""
        family, label, _ = one.key
        numbers = [next(iter(c))[0][0] for c in self.algebra.vector(family, label)]
        square = self.algebra.spheres.get(family)
        for _ in range(TRIES):
            x, y, z = map(int, self.draw.integers(PRIME, size=3))
            if square is not None:
                left = (self.of(square) - x * x - y * y) % PRIME
                z = pow(left, (PRIME + 1) // 4, PRIME)
                if z * z % PRIME != left:
                    continue
            self.known.update(zip(numbers, (x, y, z)))
            return
        raise NoValue
