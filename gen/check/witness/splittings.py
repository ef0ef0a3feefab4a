"""Explicit splittings by numpy: the witness's own. Every rotation is that of Rodrigues, from an axis and an angle; gradients are
those of all of H, of which each part takes what is its own.
"""
from __future__ import annotations

import numpy as np


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
