"""Linear spaces of conserved functions, found by exact linear algebra with the torques.

An unknown combination sum_q a_q F_q has the derivative sum_q a_q P_q with polynomials P_q; it
vanishes for all states, indices and times exactly when every coefficient does. What depends on
parameters alone belongs to the coefficients.
"""
from __future__ import annotations

import itertools

import sympy as sp
from sympy.polys.domains import QQ
from sympy.polys.matrices import DomainMatrix

from . import bounds
from . import polynomial as poly
from .algebra import Algebra
from .constants import symbol
from .polynomial import TooMuch
from .torque import Torques

PAIRS = tuple(itertools.combinations_with_replacement(range(3), 2))      # xx xy xz yy yz zz


def linear_rows(found: Torques, families, feel: str) -> list:
    """Lists of P_q, q = (family, axis): the torque on a whole family. feel: 'own' or 'all'."""
    return [[_summed(o, f, c, getattr(o, "all" if o.watched else feel)) for f in families for c in range(3)]
            for o in found.orbits]


def _summed(orbit, family, c, torque) -> dict:
    out: dict = {}
    for slot in orbit.slots:
        if slot[0] == family:
            out = poly.add(out, torque[slot][c])
    return out


def own_rows(found: Torques, family) -> list:
    """Lists of P_q, q = axis: the torque on each site of a family by itself."""
    return [list(o.all[s] if o.watched else o.own[s]) for o in found.orbits for s in o.slots if s[0] == family]


def quadratic_rows(found: Torques, families) -> list:
    """Lists of P_q, q = (family, entry of a symmetric Q): sum over the sites of (Q w).tau."""
    return [[_all_sites(found.algebra, o, f, a, b) for f in families for a, b in PAIRS] for o in found.orbits]


def _all_sites(algebra, orbit, family, a, b) -> dict:
    out: dict = {}
    for slot in orbit.slots:
        if slot[0] == family:
            out = poly.add(out, _power(algebra, orbit, slot, a, b))
    return out


def own_quadratic_rows(found: Torques, family) -> list:
    """The same for each site by itself."""
    return [[_power(found.algebra, o, s, a, b) for a, b in PAIRS]
            for o in found.orbits for s in o.slots if s[0] == family]


def _power(algebra: Algebra, orbit, slot, a, b) -> dict:
    """(Q w).tau for Q with ones at (a, b) and (b, a)."""
    v, t = orbit.vectors[slot], (orbit.all if orbit.watched else orbit.own)[slot]
    out = algebra.times(v[a], t[b])
    return out if a == b else poly.add(out, algebra.times(v[b], t[a]))


def null_space(algebra: Algebra, rows: list, size: int) -> list[list]:
    """A basis, as lists of `size` sympy numbers, of the a with sum_q a_q P_q = 0 in each row."""
    equations: set = set()
    for row in rows:
        equations |= set(_equations(algebra, _on_one_denominator(algebra, row)))
        if len(equations) > bounds.EQUATIONS:
            raise TooMuch
    return _solved(algebra, [dict(e) for e in equations], size)


def _on_one_denominator(algebra: Algebra, row: list) -> list:
    """The row times its denominators; where that is too long, each 1/P stays a function of its own."""
    left = algebra.budget.left
    try:
        algebra.budget.left = left // 4
        return algebra.cleared(row)
    except TooMuch:
        return [algebra.reduced(p) for p in row]
    finally:
        algebra.budget.left = left - left // 4


def _equations(algebra: Algebra, row: list):
    """One equation a monomial in what is no parameter: frozenset of (q, coefficient items)."""
    found: dict = {}
    for q, p in enumerate(row):
        for m, c in p.items():
            outside = tuple(x for x in m if not algebra.table[x[0]].fixed)
            inside = tuple(x for x in m if algebra.table[x[0]].fixed)
            found.setdefault(outside, {}).setdefault(q, {})[inside] = c
    return (frozenset((q, frozenset(p.items())) for q, p in e.items()) for e in found.values())


def _solved(algebra, equations: list, size: int) -> list[list]:
    if not equations:
        return [[sp.Integer(int(q == k)) for q in range(size)] for k in range(size)]
    plain = all(poly.number_of(dict(p)) is not None for e in equations for p in e.values())
    matrix = _rational(equations, size) if plain else _with_roots(algebra, equations, size)
    basis = matrix.nullspace().to_Matrix()
    return [[sp.nsimplify(x) if x.is_Float else x for x in basis.row(k)] for k in range(basis.rows)]


def _rational(equations, size):
    entries = [[QQ(0)] * size for _ in equations]
    for line, e in zip(entries, equations):
        for q, p in e.items():
            c = poly.number_of(dict(p))
            line[q] = QQ(c.numerator, c.denominator)
    return DomainMatrix(sorted(entries), (len(entries), size), QQ)


def _with_roots(algebra, equations, size):
    """Square roots of numbers stay what they are; other constants become symbols."""
    if len(equations) * size > bounds.ROOTS:
        raise TooMuch
    lines = [[as_sympy(algebra, dict(e.get(q, ()))) for q in range(size)] for e in equations]
    return DomainMatrix.from_Matrix(sp.Matrix(lines), extension=True).to_field()


def as_sympy(algebra: Algebra, p: dict):
    """A polynomial in constants as sympy has it: roots of rationals are roots, the rest symbols."""
    out = sp.Integer(0)
    for m, c in p.items():
        term = sp.Rational(c.numerator, c.denominator)
        for g, e in m:
            term *= _constant(algebra, g) ** e
        out += term
    return sp.expand(out)


def _constant(algebra: Algebra, g: int):
    one = algebra.table[g]
    if one.kind == "sqrt":
        inside = poly.number_of(one.arguments[0])
        if inside is not None and inside > 0 and len(str(inside)) < bounds.LONG:
            return sp.sqrt(sp.Rational(inside.numerator, inside.denominator))
    return symbol(algebra, g)


def vanishes(algebra: Algebra, rows: list, vector) -> bool:
    """Is sum_q a_q P_q = 0 in each row, whatever the parameters? Entries of a: rational numbers."""
    if not all(x.is_Rational for x in vector):
        return False
    for row in rows:
        total: dict = {}
        for a, p in zip(vector, row):
            total = poly.add(total, poly.scaled(p, poly.Fraction(int(a.p), int(a.q))))
        if any(algebra.cleared([total])):
            return False
    return True
