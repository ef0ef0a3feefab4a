"""Trajectories for pictures: paths of a compiled model, starts spread evenly."""
from __future__ import annotations

import numpy as np

from ..plot.equilibria import tangents


def path(model, w, h: float, outputs: int, every: int = 1) -> np.ndarray:
    """States (outputs+1, sites, 3) of `model` from w, one each `every` steps. Raises RunError."""
    model.start(np.array(w, float), h=h)
    states = np.empty((outputs + 1, model.sites, 3))
    states[0] = model.state()
    for k in range(outputs):
        if model.advance(every) < every:
            raise model.failure()
        states[k + 1] = model.state()
    return states


def spiral(count: int) -> np.ndarray:
    """(count, 3) points spread over the unit sphere."""
    i = np.arange(count) + 0.5
    polar, around = np.arccos(1 - 2 * i / count), np.pi * (1 + 5**0.5) * i
    return np.stack([np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar),
                     np.cos(polar)], axis=1)


def covering(trace, gap: float, first=(), seeds: int = 500, most: int = 60):
    """Curves [trace(w)] (k, 3) until no seed is farther than `gap` from all of them.

    Farthest seeds first, after the starts `first`. trace may return None: that start is
    passed over.
    """
    points = spiral(seeds)
    distance, curves = np.full(seeds, np.inf), []
    queue = list(first)
    while len(curves) < most and (queue or distance.max() > gap):
        pick = None if queue else int(np.argmax(distance))
        curve = trace(queue.pop(0) if pick is None else points[pick])
        if pick is not None:
            distance[pick] = 0
        if curve is not None:
            curves.append(curve)
            distance = np.minimum(distance, gaps(points, curve))
    return curves


def gaps(points, curve) -> np.ndarray:
    """Distance of each point (n, 3) from the nearest point of the curve (k, 3)."""
    thin = curve[::max(1, len(curve) // 400)]
    return np.sqrt(np.maximum(2 - 2 * np.max(points @ thin.T, axis=1), 0))


def beside(marks, offset: float = 2e-3):
    """Two starts a little off each saddle: their curves draw the separatrices."""
    found = []
    for w, kind in marks:
        if kind == "unstable":
            for side in tangents(w):
                start = w + offset * side
                found.append(start / np.linalg.norm(start))
    return found


def closed(curve, tolerance: float = 0.02) -> np.ndarray:
    """The curve up to its first return to within `tolerance` of its start, joined there."""
    away = np.linalg.norm(curve - curve[0], axis=1)
    left = int(np.argmax(away > 3 * tolerance))
    back = np.flatnonzero(away[left:] < tolerance)
    if left == 0 or len(back) == 0:
        return curve
    end = left + int(back[0])
    stay = np.flatnonzero(away[end:] >= tolerance)
    end += int(np.argmin(away[end:end + (int(stay[0]) if len(stay) else 1)]))
    return np.concatenate([curve[:end + 1], curve[:1]])
