"""Explicit splittings by numpy: the witness's own. Every rotation is that of Rodrigues, from an axis and an angle; gradients are
those of all of H, of which each part takes what is its own.
"""
from __future__ import annotations

import ctypes
import functools
import itertools
import math
import operator
from dataclasses import dataclass, replace

import numpy as np

from ...errors import RunError
from ...language.evaluate import integer
from ...language.expr import slots_of
from ...language.instances import instances_of
from ...language.spec import Lattice
from . import native


def turned(w, axis, angle):
    """Each w (sites, 3) about a unit axis as w' = w x axis has it: from the axis backward, hence the sign."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = np.sum(w * axis, axis=1)[:, None] * axis
    return along + c * (w - along) + s * np.cross(w, axis)


def axes(witness, w, t: float, h: float):
    """x, y for half the step, z for all of it, y, x: the time in the middle. Where no effect joins sites each angle is twice the
    arcus tangent of its half."""
    joined = any(one.site.shape[1] > 1 for one in witness.programs.values())
    for a, part in ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)):
        angle = witness.spec.orientation * part * h * witness.field(w, t + h / 2)[:, a]
        w = turned(w, np.eye(3)[a], angle if joined else 2 * np.arctan(angle / 2))
    return w if np.all(np.isfinite(w)) else None


@dataclass(frozen=True)
class Rule:
    """The colour of a site: (weights . cell + shift of its place) modulo their number."""
    number: int
    weights: tuple
    shift: tuple

    def of(self, place, cell):
        """place: numbers; cell: an array, one row a direction."""
        return (np.tensordot(self.weights, cell, 1) + np.array(self.shift)[place]) % self.number


def colours(witness) -> np.ndarray:
    """The colour of every site, by the definition of the method: on a lattice whose rings fit that of its place; 0 where no term joins
    sites; else every site is its own."""
    if all(one.site.shape[1] < 2 for one in witness.programs.values()):
        return np.zeros(witness.sites, int)
    found, _ = lattice_colours(witness)
    return np.arange(witness.sites) if found is None else found


@functools.lru_cache(maxsize=4)
def lattice_colours(witness):
    """(the colours of all sites of a lattice whose rings fit, the rule); else None for both."""
    terms = [e for e in witness.spec.energies if e.name in witness.programs]
    overs = [e.over for e in terms if isinstance(e.over, Lattice)]
    off = [e for e in terms if not isinstance(e.over, Lattice) and witness.programs[e.name].site.shape[1] > 1]
    if off or not overs or any((o.size, o.sites) != (overs[0].size, overs[0].sites) for o in overs) or not all_have_bonds(witness, terms):
        return None, None
    rule, families = first_rule([in_one_cell(witness, over) for over in overs]), len(witness.families)
    if rule is None:
        return None, None
    size = [integer(e, witness.values, "the size of a lattice") for e in overs[0].size]
    cell = np.tile(np.indices(size[::-1]).reshape(len(size), -1)[::-1].repeat(overs[0].sites, axis=1), families)
    number = np.arange(witness.sites)
    colour = rule.of(number % overs[0].sites + number // (witness.sites // families) * overs[0].sites, cell)
    return (colour, rule) if all(continues(witness, over, rule, colour) for over in overs) else (None, None)


def all_have_bonds(witness, terms) -> bool:
    """Of several families: is each an end of a bond, and none of tracers?"""
    ends = {name for e in terms if witness.programs[e.name].site.shape[1] > 1 for name in e.over.families or (e.over.family,)}
    return len(witness.families) == 1 or ends == set(witness.families) and not any(f.tracer for f in witness.spec.families)


def in_one_cell(witness, over):
    """The bonds with other numbers for the places of later families."""
    return replace(over, sites=over.sites * len(witness.families), bonds=tuple(tuple((place + shift, cell) for (place, cell), shift in zip(bond, behind(witness, over))) for bond in over.bonds))


def behind(witness, over) -> list:
    """How many places of other families come before those of each end."""
    return [list(witness.families).index(name) * over.sites for name in over.families or [over.family] * len(over.indices)]


def first_rule(overs) -> Rule | None:
    """Of two to eight colours the first rule by which the ends of all bonds differ: fewest colours, largest weights, least shifts. The fastest
    direction takes all colours in turn, or none counts. One of the first thousand goes before it that has 300 kinds of rows at most, or 1000."""
    directions, places = len(overs[0].size), overs[0].sites
    bonds = [tuple(dict.fromkeys(bond)) for over in overs for bond in over.bonds]
    for number in range(2, 9):
        found = list(itertools.islice(rules(number, directions, places, bonds), 1000))
        for most in (300, 1000, math.inf) if found else ():
            for rule in found:
                if kinds_of_rows(rule, bonds) <= most:
                    return rule
    return None


def rules(number: int, directions: int, places: int, bonds):
    """In order; none where those bonds that stand in one cell need more colours, whatever these are called."""
    inside = [bond for bond in bonds if len({cell for _, cell in bond}) == 1]
    if next(continued(Rule(number, (0,) * directions, (0,)), places, inside, True), None) is None:
        return
    for weights in itertools.product(reversed(range(number)), repeat=directions):
        if math.gcd(weights[0], number) == 1 or not any(weights):
            yield from continued(Rule(number, weights, (0,)), places, bonds, False)


def continued(rule: Rule, places: int, bonds, renamed: bool):
    """With shifts of all places, by which bonds between places that have one are kept apart; renamed: a new place takes at most one new colour."""
    have = len(rule.shift)
    if not all(apart_by(rule, bond) for bond in bonds if max(place for place, _ in bond) == have - 1):
        return
    if have == places:
        yield rule
        return
    for shift in range(min(rule.number, max(rule.shift) + 2) if renamed else rule.number):
        yield from continued(replace(rule, shift=(*rule.shift, shift)), places, bonds, renamed)


def apart_by(rule: Rule, members) -> bool:
    found = {(sum(map(operator.mul, rule.weights, cell)) + rule.shift[place]) % rule.number for place, cell in members}
    return len(found) == len(members)


def kinds_of_rows(rule: Rule, bonds) -> int:
    """By the colour and place of a row, how it begins, and how near it is to the ends of the other directions."""
    spans = [max(abs(a[d] - b[d]) for bond in bonds for _, a in bond for _, b in bond) for d in range(1, len(rule.weights))]
    stride, places = (rule.number, len(rule.shift)) if any(rule.weights) else (1, len(rule.shift) // rule.number)
    second, others = (spans[0], spans[1:]) if spans else (0, [])
    return rule.number * places * stride * (2 * second + stride) * math.prod(2 * span + 1 for span in others)


def continues(witness, over, rule: Rule, colour) -> bool:
    """Do the ends of every bond differ by the same colours, also where it goes on at the other end of a ring?"""
    for bond in over.bonds:
        found, homes = instances_of(replace(over, bonds=(bond,)), witness.values, {})[0], over.families or [over.family] * len(over.indices)
        ends = [found[index] + witness.families[home][0] for index, home in zip(over.indices, homes)]
        should = [int(rule.of(place, np.array(cell))) for place, cell in in_one_cell(witness, replace(over, bonds=(bond,))).bonds[0]]
        for end, own in zip(ends, should):
            if np.any((colour[end] - colour[ends[0]] - own + should[0]) % rule.number):
                return False
    return True


def proper(witness, colour) -> np.ndarray:
    """The colours; RunError where a term couples two sites of the same colour."""
    for name, one in witness.programs.items():
        of_terms = np.sort(colour[one.site], axis=1)
        if np.any(of_terms[:, 1:] == of_terms[:, :-1]):
            raise RunError(f"effect {name} couples two sites of the same colour: the sublattices do not belong to this model")
    return colour


def sublattices(witness, w, t: float, h: float):
    """The colours one after the other for half the step, the last for all of it, and back; each site about its field, by twice the
    arcus tangent of half of |h b|."""
    w, colour = np.array(w, float), proper(witness, colours(witness))
    order = [*range(colour.max() + 1), *reversed(range(colour.max()))]
    for which in order:
        part, here = 1.0 if which == colour.max() else 0.5, colour == which
        b = witness.spec.orientation * part * h * witness.field(w, t + h / 2)[here]
        size = np.linalg.norm(b, axis=1)
        w[here] = turned(w[here], b / np.where(size > 0, size, 1)[:, None], 2 * np.arctan(size / 2))
    return w if np.all(np.isfinite(w)) else None


def bonds(witness):
    """(i, j, system of that term alone) of all terms of two sites, in the order in which the interpreter has them."""
    for one in witness.programs.values():
        for k, (i, j) in enumerate(one.site if one.site.shape[1] == 2 else ()):
            arrays = [np.ascontiguousarray(a) for a in (one.code, one.site[k:k + 1], one.data[k:k + 1], one.table, one.feels)]
            program = native.ProgramStruct(len(one.code), 2, one.data.shape[1], 1, *(a.ctypes.data for a in arrays))
            system = native.SystemStruct(witness.sites, 1, 0, ctypes.addressof(program), None, *(a.ctypes.data for a in witness._arrays),
                                         witness.spec.orientation)
            yield i, j, (system, program, arrays)


def classes(witness, found):
    """[(bonds, part of the step)], the classes for half of it, the last for all, and back; None where bonds go one after the other: off
    lattices, on rings that do not fit, and where a bond does not begin in its cell. A class has the bonds of one effect that are the same one of its
    list, and whose first end has one colour."""
    colour, rule = lattice_colours(witness) if len(witness.families) == 1 else (None, None)
    if colour is None:
        return None
    members, left = {}, iter(found)
    for e, term in enumerate(witness.spec.energies):
        if term.name not in witness.programs or witness.programs[term.name].site.shape[1] != 2:
            continue
        over, first = term.over, min(term.over.indices.index(index) for _, index in slots_of(term.value))
        if not all(any(not any(offset) for _, offset in bond) for bond in over.bonds):
            return None
        for k, bond in enumerate(over.bonds):
            ends = instances_of(replace(over, bonds=(bond,)), witness.values, {})[0][over.indices[first]]
            for which in range(rule.number) if any(rule.weights) else (rule.shift[bond[first][0]],):
                members[e, k, which] = []
            for end in ends:
                members[e, k, colour[end]].append(next(left))
    groups = [apart(members[key]) for key in sorted(members)]
    return [*((group, 0.5) for group in groups[:-1]), (groups[-1], 1.0), *((group, 0.5) for group in groups[-2::-1])]


def apart(group) -> list:
    """The bonds; RunError where two of them meet."""
    ends = [k for i, j, _ in group for k in (i, j)]
    if len(set(ends)) < len(ends):
        raise RunError("two bonds of a class share a site: the classes do not belong to this model")
    return group


def pairs(witness, w, t: float, h: float):
    """Bond after bond for half the step, and back, or so class after class: both ends about their momentum, by twice the arcus tangent of
    half the angle."""
    w, found = np.array(w, float), list(bonds(witness))
    order = classes(witness, found) or [(found, 0.5), (found[::-1], 0.5)]
    b = np.empty_like(w)
    for (i, j, (system, *_)), part in ((one, part) for group, part in order for one in group):
        if witness._c.witness_field(ctypes.addressof(system), t + h / 2, w.ctypes.data, b.ctypes.data):
            return None
        one, other = witness.kappa[i], witness.kappa[j]
        momentum = one * w[i] + other * w[j]
        slope = one * (b[i] @ w[j]) / (w[j] @ w[j])         # f', for dH/dw_i = f' w_j
        size = np.linalg.norm(momentum)
        angle = witness.spec.orientation * part * h * slope * size / (one * other)
        if size > 0:
            w[[i, j]] = turned(w[[i, j]], momentum / size, np.full(2, 2 * np.arctan(angle / 2)))
    return w if np.all(np.isfinite(w)) else None
