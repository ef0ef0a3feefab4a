"""The branch of solutions of the step equation, followed from u = 0 at h = 0 in growing steps of h.

It ends where J has a real eigenvalue 0: there the branch turns back (a fold), and no step of a
larger h is connected to the state. Predictor along du/dh, Newton, shorter paces near the end.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .equation import Nowhere, StepEquation

FIRST = 1 / 32          # of the cap: the first pace
SHORTEST = 1e-3         # of h: a shorter pace means that the end is reached
CLOSE = 0.15            # of the radius: the largest correction of a good prediction
SETTLED = 1e-8          # relative change that ends Newton
ITERATIONS = 7
PACES = 400
CENTRE = 0.1            # abs(mbar)/abs(w) below this at the end: the midpoint ran into the centre


@dataclass(frozen=True)
class Branch:
    """Where the branch was left: the largest h with a solution u; ends: does it end there?
    null, left: the directions in which J and its transpose are nearest to singular, shape (sites, 3); kind: 'fold', 'centre',
    'edge' (no field or no projection beyond) or 'open' (followed to the cap)."""
    h: float
    u: np.ndarray
    kind: str
    null: np.ndarray
    left: np.ndarray
    site: int = -1

    @property
    def ends(self) -> bool:
        return self.kind != "open"


def follow(equation: StepEquation, cap: float) -> Branch:
    """The branch from h = 0 up to `cap` > 0."""
    u, h, pace = np.zeros_like(equation.w), 0.0, FIRST * cap
    jacobian, site = np.eye(u.size), -1
    for _ in range(PACES):
        if h >= cap:
            return Branch(h, u, "open", *_null(jacobian, u))
        target = min(cap, h + pace)
        try:
            found, site = _point(equation, u, h, jacobian, target), -1
        except Nowhere as place:
            found, site = None, place.site
        if found is not None:
            (u, jacobian), h, pace = found, target, 1.6 * pace
        elif pace < SHORTEST * max(h, SHORTEST * cap):
            break
        else:
            pace /= 2
    return _ended(equation, h, u, *_null(jacobian, u), site)


def _point(equation, u, h, jacobian, target):
    """(u, J) at h = target by prediction and Newton; None when it is not on the branch, proved so or not."""
    try:
        v = u + (target - h) * equation.direction(u, h, jacobian)
        moved = np.inf
        for k in range(ITERATIONS):
            j = equation.jacobian(v, target)
            d = np.linalg.solve(j, equation.residual(v, target)).reshape(u.shape)
            size = float(np.max(np.linalg.norm(d, axis=1) / (equation.length + (equation.length == 0))))
            v = v - d
            if not size <= min(CLOSE, moved / 2):
                return None
            if size <= SETTLED:
                return (v, j) if _connected(j) else None
            moved = size
    except np.linalg.LinAlgError:
        pass
    return None


def _connected(jacobian) -> bool:
    """Has J no real eigenvalue <= 0?"""
    e = np.linalg.eigvals(jacobian)
    real = np.abs(e.imag) <= 1e-9 * np.abs(e)
    return not np.any(real & (e.real <= 0))


def _null(jacobian, u):
    left, _, right = np.linalg.svd(jacobian)
    return right[-1].reshape(u.shape), left[:, -1].reshape(u.shape)


def _ended(equation, h, u, null, left, site) -> Branch:
    """The branch with the kind of its end, and for a place in the state the site."""
    part = np.linalg.norm(equation.w + u / 2, axis=1) / (equation.length + (equation.length == 0))
    if np.any(near := (part < CENTRE) & (equation.length > 0)):
        return Branch(h, u, "centre", null, left, int(np.argmin(np.where(near, part, np.inf))))
    return Branch(h, u, "edge" if site >= 0 else "fold", null, left, site)
