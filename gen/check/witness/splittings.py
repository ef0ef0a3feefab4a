"""Explicit splittings by numpy: the witness's own. Every rotation is that of Rodrigues, from an axis and an angle; gradients are
those of all of H, of which each part takes what is its own.
"""
from __future__ import annotations

import ctypes

import numpy as np

from ...errors import RunError
from ...language.evaluate import integer
from . import native


def turned(w, axis, angle):
    """Each w (sites, 3) about a unit axis as w' = w x axis has it: from the axis backward, hence the sign."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = np.sum(w * axis, axis=1)[:, None] * axis
    return along + c * (w - along) + s * np.cross(w, axis)


def axes(witness, w, t: float, h: float):
    """x, y for half the step, z for all of it, y, x: the time in the middle. Where no effect joins sites each angle is twice the
    arcus tangent of its half."""
    joined = any(one.site.shape[1] > 1 for one in witness.effects.values())
    for a, part in ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)):
        angle = witness.spec.orientation * part * h * witness.field(w, t + h / 2)[:, a]
        w = turned(w, np.eye(3)[a], angle if joined else 2 * np.arctan(angle / 2))
    return w if np.all(np.isfinite(w)) else None


def colours(witness) -> np.ndarray:
    """The colour of every site, by the definition of the method: on a lattice whose rings fit, (weights . cell + shift) modulo their
    number; 0 where no term joins sites; else every site is its own."""
    from ...compile.plan.splitting import sublattices as sublattices_of     # sympy is imported for this method alone
    found = sublattices_of(witness.spec)
    if all(one.site.shape[1] < 2 for one in witness.effects.values()):
        return np.zeros(witness.sites, int)
    if found is None:
        return np.arange(witness.sites)
    over, rule = found.over, found.colours
    size = [integer(e, witness.values, "the size of a lattice") for e in over.size]
    if any(ring and w * n % rule.colours for ring, w, n in zip(over.periodic, rule.weights, size)):
        return np.arange(witness.sites)
    sub, cell = np.arange(witness.sites) % over.sites, np.arange(witness.sites) // over.sites
    colour = np.array(rule.shift)[sub]
    for n, weight in zip(size, rule.weights):
        colour, cell = colour + weight * (cell % n), cell // n
    return colour % rule.colours


def proper(witness, colour) -> np.ndarray:
    """The colours; RunError where a term joins two sites of one colour, for the plan gave the rule and the witness does not trust it."""
    for name, one in witness.effects.items():
        of_terms = np.sort(colour[one.site], axis=1)
        if np.any(of_terms[:, 1:] == of_terms[:, :-1]):
            raise RunError(f"effect {name} joins two sites of one colour: the sublattices are not those of this model")
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
    for one in witness.effects.values():
        for k, (i, j) in enumerate(one.site if one.site.shape[1] == 2 else ()):
            arrays = [np.ascontiguousarray(a) for a in (one.code, one.site[k:k + 1], one.data[k:k + 1], one.table, one.feels)]
            program = native.ProgramStruct(len(one.code), 2, one.data.shape[1], 1, *(a.ctypes.data for a in arrays))
            system = native.SystemStruct(witness.sites, 1, ctypes.addressof(program), *(a.ctypes.data for a in witness._arrays),
                                         witness.spec.orientation)
            yield i, j, (system, program, arrays)


def pairs(witness, w, t: float, h: float):
    """Bond after bond for half the step, and back: both ends about their momentum, by twice the arcus tangent of half the angle."""
    w, found = np.array(w, float), list(bonds(witness))
    b = np.empty_like(w)
    for i, j, (system, *_) in [*found, *reversed(found)]:
        if witness._c.witness_field(ctypes.addressof(system), t + h / 2, w.ctypes.data, b.ctypes.data):
            return None
        one, other = witness.kappa[i], witness.kappa[j]
        momentum = one * w[i] + other * w[j]
        slope = one * (b[i] @ w[j]) / (w[j] @ w[j])         # f', for dH/dw_i = f' w_j
        size = np.linalg.norm(momentum)
        angle = witness.spec.orientation * h / 2 * slope * size / (one * other)
        if size > 0:
            w[[i, j]] = turned(w[[i, j]], momentum / size, np.full(2, 2 * np.arctan(angle / 2)))
    return w if np.all(np.isfinite(w)) else None
