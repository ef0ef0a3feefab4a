"""Lie-group methods by numpy: the witness's own. Every rotation is that of Rodrigues, from an axis and an angle."""
from __future__ import annotations

import numpy as np

from .splittings import turned


def by(turn, w):
    """Each w (sites, 3) turned by its angle vector."""
    angle = np.linalg.norm(turn, axis=1)
    return turned(w, turn / np.where(angle > 0, angle, 1)[:, None], angle)


def cf4(witness, w, t: float, h: float):
    """Celledoni, Marthinsen, Owren 2003: the classical Runge-Kutta method with rotations in place of sums."""
    def turn(x, part):
        return witness.spec.orientation * h * witness.field(x, t + part * h)
    one = turn(w, 0)
    second = by(one / 2, w)
    two = turn(second, 1 / 2)
    three = turn(by(two / 2, w), 1 / 2)
    four = turn(by(three - one / 2, second), 1)
    middle = by(one / 4 + (two + three) / 6 - four / 12, w)
    w = by(-one / 12 + (two + three) / 6 + four / 4, middle)
    return w if np.all(np.isfinite(w)) else None
