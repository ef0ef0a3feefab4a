"""Torques: tau_k = grad C(w_k) x dH/dw_k of every slot of every orbit, as polynomials.

A linear function sum a_f . (kappa w) summed over families f has the time derivative
sum_f a_f . sum_k tau_k, up to the orientation; a quadratic one, sum kappa w.(Q w), has
2 sum (Q w_k) . tau_k. So conservation is linear algebra with the torques.
"""
from __future__ import annotations

from dataclasses import dataclass, field

from ...language.expr import Idx, walk
from ...language.spec import Spec
from . import polynomial as poly
from .algebra import Algebra
from .formulas import Formulas
from .orbits import passive

Slot = tuple        # (family, label)


@dataclass
class Orbit:
    """One elementary sum: per slot its vector, the torque that it feels (own: of the motion,
    all: of H with every slot, tracers' sources too), and the sum of the terms."""
    slots: list = field(default_factory=list)
    vectors: dict = field(default_factory=dict)
    normals: dict = field(default_factory=dict)
    own: dict = field(default_factory=dict)
    all: dict = field(default_factory=dict)
    energy: dict = field(default_factory=dict)      # of the effects without tracers
    total: dict = field(default_factory=dict)
    watched: bool = False                           # a condition: must be unchanged by itself


@dataclass
class Torques:
    """The orbits of a scene for one choice of what is a number and what a symbol."""
    spec: Spec
    algebra: Algebra
    orbits: list


def torques(spec: Spec, sums, values, numbers: dict, budget, on_sphere: bool) -> Torques:
    """values: parameter values, or None for symbols; numbers: tables of the spec."""
    algebra = Algebra(budget)
    if on_sphere:
        algebra.spheres = _spheres(spec, algebra, values, numbers)
    found = []
    for bounds in sums:
        found += _orbit(spec, algebra, bounds, values, numbers)
    return Torques(spec, algebra, found)


def _spheres(spec, algebra, values, numbers) -> dict:
    """family -> r^2 for spheres of one radius."""
    found = {}
    for f in spec.families:
        if f.kind == "sphere" and f.radius is None:
            found[f.name] = poly.constant(1)
        elif f.kind == "sphere" and not any(isinstance(e, Idx) for e in walk(f.radius)):
            r = Formulas(algebra, values, numbers, {}, {}).value(f.radius)
            found[f.name] = algebra.times(r, r)
    return found


def _orbit(spec, algebra, bounds, values, numbers) -> list:
    """The orbit of terms over the same sites, and one for each condition in them."""
    tracers = {f.name for f in spec.families if f.tracer}
    one, others = Orbit(), []
    for bound in bounds:
        algebra.conditions = []
        formulas = Formulas(algebra, values, numbers, bound.indices, bound.columns)
        value = algebra.reduced(formulas.value(bound.term.value))
        is_passive = passive(bound.term, tracers)
        slots = _slots(algebra, value)
        _extend(spec, formulas, one, slots, bound)
        _feel(algebra, one, value, slots, tracers if is_passive else None)
        if not is_passive:
            one.energy = poly.add(one.energy, value)
        one.total = poly.add(one.total, value)
        others += [_condition(spec, formulas, bound, c) for c in algebra.conditions]
    return [one, *others]


def _condition(spec, formulas, bound, p) -> Orbit:
    """What an `if` or a floor looks at, as if it were an energy."""
    one = Orbit(watched=True)
    slots = _slots(formulas.algebra, p)
    _extend(spec, formulas, one, slots, bound)
    _feel(formulas.algebra, one, p, slots, None)
    return one


def _slots(algebra: Algebra, value: dict) -> list:
    """The (family, label) whose vectors `value` holds, also inside functions."""
    found, seen, left = {}, set(), list(poly.generators_of(value))
    while left:
        g = left.pop()
        if g in seen:
            continue
        seen.add(g)
        one = algebra.table[g]
        if one.kind == "vector":
            found[one.key[:2]] = True
        left += [n for p in one.arguments for n in poly.generators_of(p)]
    return sorted(found, key=str)


def _extend(spec, formulas, one: Orbit, slots, bound):
    for slot in slots:
        if slot not in one.vectors:
            one.slots.append(slot)
            one.vectors[slot] = formulas.algebra.vector(*slot)
            one.normals[slot] = normal(spec, formulas, slot, one.vectors[slot])
            one.own[slot], one.all[slot] = ({}, {}, {}), ({}, {}, {})


def normal(spec, formulas: Formulas, slot: Slot, vector) -> tuple:
    """grad C of a slot: the vector itself on spheres and in R^3."""
    family = next(f for f in spec.families if f.name == slot[0])
    if family.kind != "nambu":
        return vector
    here = Formulas(formulas.algebra, formulas.values, formulas.numbers, {"i": slot[1]}, {})
    return tuple(formulas.algebra.dot([here.value(e) for e in row], vector) for row in family.casimir)


def _feel(algebra: Algebra, one: Orbit, value, slots, only):
    """Add the torques of one term; `only`: families that feel it (tracers), None for all."""
    for slot in slots:
        gradient = [algebra.derivative(value, next(iter(c))[0][0]) for c in one.vectors[slot]]
        torque = algebra.cross(one.normals[slot], gradient)
        one.all[slot] = _sum(one.all[slot], torque)
        if only is None or slot[0] in only:
            one.own[slot] = _sum(one.own[slot], torque)


def _sum(a, b):
    return tuple(poly.add(x, y) for x, y in zip(a, b))
