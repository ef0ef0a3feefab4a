"""Explicit splittings by numpy: the witness's own. Every rotation is that of Rodrigues, from an axis and an angle; gradients are
those of all of H, of which each part takes what is its own.
"""
from __future__ import annotations

import numpy as np

from ...compile.plan.splitting import sublattices as sublattices_of
from ...language.evaluate import integer


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


def sublattices(witness, w, t: float, h: float):
    """The colours one after the other for half the step, the last for all of it, and back; each site about its field, by twice the
    arcus tangent of half of |h b|."""
    w, colour = np.array(w, float), colours(witness)
    order = [*range(colour.max() + 1), *reversed(range(colour.max()))]
    for which in order:
        part, here = 1.0 if which == colour.max() else 0.5, colour == which
        b = witness.spec.orientation * part * h * witness.field(w, t + h / 2)[here]
        size = np.linalg.norm(b, axis=1)
        w[here] = turned(w[here], b / np.where(size > 0, size, 1)[:, None], 2 * np.arctan(size / 2))
    return w if np.all(np.isfinite(w)) else None
