"""Residuals of steps in ulps: |W - w - h X(m)|, recomputed by the interpreter in extended precision."""
from __future__ import annotations

import numpy as np

from ...chance import generator
from ...errors import RunError
from ...extremes import largest
from .case import EPS, Case, size
from .reversible import stretch

RESIDUAL = 8            # ulps: what the rounding of W itself and of the carry leaves, and little more
NUDGE = 1e-9            # relative change of m that shows how a formula enlarges round-off
NUDGES = 4


def worst(case: Case, subject, states, t0, h) -> float:
    """The largest residual of consecutive states (count + 1, sites, 3) in ulps of w.

    Where it is more than RESIDUAL, in ulps of what round-off may grow to within that step.
    """
    left = np.abs(case.witness.residuals(states, t0, h, case.settings.method)).max(axis=(1, 2))
    ulps = left / (EPS * np.abs(states[:-1]).max(axis=(1, 2)))
    if not np.all(np.isfinite(ulps)):
        return np.inf
    found = 0.0
    for k in np.argsort(-ulps):
        if ulps[k] <= max(found, RESIDUAL):
            return float(max(found, ulps[k]))
        found = largest(found, float(ulps[k]) / growth(case, subject, states[k], states[k + 1], t0 + k * h, h))
        if not found <= RESIDUAL:
            break
    return found


def growth(case: Case, subject, w, after, t, h) -> float:
    """How much a step enlarges round-off: it stretches distances, and the formula of the field may cancel."""
    try:
        slope = stretch(subject, w, after, t, h)
    except RunError:
        slope = 1.0
    m = np.array(case.leaves.polished((w + after) / 2), float)
    return slope + float((abs(h) * cancelled(case, m, t + h / 2)).max()) / size(w)


def cancelled(case: Case, m, t) -> np.ndarray:
    """How much of the round-off of m, in units of eps, the formula of X makes of it: (sites,)."""
    dice, at = generator("cancellation"), case.witness.vector_field
    moved = [at(m * (1 + NUDGE * dice.uniform(-1, 1, m.shape)), t) for _ in range(NUDGES)]
    return np.abs(np.array(moved) - at(m, t)).max(axis=(0, 2)) / NUDGE
