"""The energy as an integral: does H depend on time, and is it of a form that the method keeps?"""
from __future__ import annotations

import itertools

import numpy as np
import sympy as sp

from ...methods import METHODS
from ...language.expr import timed
from ...run.step.evaluated import casimir_matrices
from . import polynomial as poly
from .conserved import PAIRS
from .energy import Energy
from .integrals import WHY, Integral
from .orbits import passive
from .questions import Asked, attempt


def time_dependent(asked: Asked):
    """Does the energy that moves the state depend on t? None: not decided."""
    if not _holds_time(asked.spec):
        return False
    return None if asked.now is None else attempt(lambda: _timed(asked.now))


def _holds_time(spec) -> bool:
    """Is t in any formula of the energy? No work is too much for this question."""
    return any(timed(e.value) for e in spec.energies)


def _timed(found, of: str = "energy") -> bool:
    """of: that of the effects without tracers, or the total."""
    t = next(iter(found.algebra.leaf("t", False)))[0][0]
    return any(t in _deep(found.algebra, p) for o in found.orbits if not o.watched
               for p in found.algebra.cleared([getattr(o, of)]))


def _deep(algebra, p: dict) -> set:
    """All generators of p, those inside functions too."""
    found, left = set(), set(poly.generators_of(p))
    while left:
        g = left.pop()
        found.add(g)
        left |= {n for a in algebra.table[g].arguments for n in poly.generators_of(a)} - found
    return found


def energy_integral(asked: Asked, method: str, changes):
    """The energy, unless H depends on time; tracers move in a given flow and have none of their own."""
    tracers = {f.name for f in asked.spec.families if f.tracer}
    active = [e.name for e in asked.spec.energies if not passive(e, tracers)]
    if changes is not False or not active:
        return
    always = not _holds_time(asked.spec) or asked.always is not None and attempt(lambda: _timed(asked.always)) is False
    kept, why = _kept(asked, method)
    name = "energy" if len(active) == len(asked.spec.energies) else f"energy of {', '.join(active)}"
    held: list = []

    def numbers(w):
        if not held:
            held.append(Energy(asked.spec, None, active))
        return np.array([held[0](w)])
    yield Integral(name, "energy", "H", kept, why, always, 1, numbers)


def _kept(asked: Asked, method: str):
    if METHODS[method].free_body:
        return True, WHY["body"]
    if METHODS[method].keeps_energy:
        return True, WHY["turns"]
    if not METHODS[method].keeps_quadratic:
        return False, WHY["bounded" if METHODS[method].symplectic else "drift"]
    otherwise = WHY["bounded" if METHODS[method].symplectic else "drift"]
    if not METHODS[method].onto_leaf:
        return (True, WHY["every"]) if attempt(lambda: _quadratic(asked.off)) else (False, otherwise)
    return (True, WHY["energy"]) if attempt(lambda: _single_site(asked)) else (False, otherwise)


def _quadratic(found) -> bool:
    """Is H a polynomial of degree 2 or less in all vectors together?"""
    return found is not None and all(d is not None and d[0] <= 2 for d in _degrees(found))


def _single_site(asked: Asked) -> bool:
    """Is H, family by family, a linear or a homogeneous quadratic function of single sites?"""
    found = asked.written or asked.now
    if found is None:
        return False
    kinds: dict = {}
    for degree in _degrees(found):
        if degree is None or degree[0] > 2 or len(degree[1]) > 1:
            return False
        if degree[0]:
            kinds.setdefault(next(iter(degree[1]))[0], set()).add(degree[0])
    return all(len(k) == 1 or _commute(found, name) for name, k in kinds.items())


def _degrees(found):
    """(degree in the vectors, slots) of each term of the energy; None where a vector is inside a function."""
    for o in found.orbits:
        for m in o.energy if not o.watched else ():
            yield _degree(found.algebra, m)


def _degree(algebra, m):
    degree, slots = 0, set()
    for g, e in m:
        one = algebra.table[g]
        if one.kind == "vector":
            degree += e
            slots.add(one.key[:2])
        elif any(algebra.table[n].kind == "vector" for a in one.arguments for n in _deep(algebra, a)):
            return None
    return degree, slots


def _commute(found, name: str) -> bool:
    """Does the linear part of a family's energy commute with the quadratic part, site by site?

    {l, q} = grad l . (grad C x grad q) up to strength and sign; only where one sum holds the family.
    """
    here = [(o, s) for o in found.orbits if not o.watched for s in o.slots if s[0] == name]
    if len({id(o) for o, _ in here}) > 1:
        return False
    return all(_zero_bracket(found.algebra, o, s) for o, s in here)


def _zero_bracket(algebra, o, slot) -> bool:
    parts = [{m: c for m, c in o.energy.items() if (d := _degree(algebra, m))[0] == k and slot in d[1]} for k in (1, 2)]
    linear, quadratic = ([algebra.derivative(p, next(iter(c))[0][0]) for c in o.vectors[slot]] for p in parts)
    bracket = algebra.dot(linear, algebra.cross(o.normals[slot], quadratic))
    return not any(algebra.cleared([bracket]))


def energy_form(asked: Asked) -> list:
    """The quadratic form of the energy of a single body: [Q], so that it is not reported twice, or []."""
    found = asked.now
    if found is None or len(found.orbits) != 1 or len(found.orbits[0].slots) != 1 or time_dependent(asked):
        return []
    if sum(count for _, count in asked.places.values()) > 1 or not attempt(lambda: _single_site(asked)):
        return []
    one, (slot,) = found.orbits[0], found.orbits[0].slots
    x = [next(iter(c))[0][0] for c in one.vectors[slot]]
    entries = [poly.number_of(poly.derivative(poly.derivative(one.energy, x[a]), x[b])) for a, b in PAIRS]
    return [] if None in entries else [[sp.Rational(e.numerator, e.denominator) for e in entries]]


# Discrete symmetries

def parity(asked: Asked) -> list:
    """Sign patterns (sx, sy, sz), applied to all vectors, that leave H and every C unchanged; none where tracers are carried in a way that changes with t."""
    found = asked.written or asked.now
    matrices = casimir_matrices(asked.spec, asked.values)
    patterns = [s for s in itertools.product((1, -1), repeat=3) if s != (1, 1, 1)]
    if found is None or _holds_time(asked.spec) and attempt(lambda: _timed(found, "total")) is not False:
        return []
    return [s for s in patterns if np.all(matrices * np.outer(s, s) == matrices)
            and attempt(lambda: all(_even(found.algebra, o.total, s) for o in found.orbits if not o.watched))]


def _even(algebra, p: dict, signs) -> bool:
    """Is p unchanged when component c of every vector is multiplied by signs[c]?"""
    for m in p:
        sign = 1
        for g, e in m:
            one = algebra.table[g]
            if one.kind == "vector":
                sign *= signs[one.key[2]] ** e
            elif not all(_even(algebra, a, signs) for a in one.arguments):
                return False
        if sign < 0:
            return False
    return True
