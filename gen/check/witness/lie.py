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
        return witness.spec.orientation * h * witness.turning(x, t + part * h)
    one = turn(w, 0)
    second = by(one / 2, w)
    two = turn(second, 1 / 2)
    three = turn(by(two / 2, w), 1 / 2)
    four = turn(by(three - one / 2, second), 1)
    middle = by(one / 4 + (two + three) / 6 - four / 12, w)
    w = by(-one / 12 + (two + three) / 6 + four / 4, middle)
    return w if np.all(np.isfinite(w)) else None


def heun(witness, w, t: float, h: float, kick=0):
    """Garcia-Palacios and Lazaro 1998, with noise in the sense of Stratonovich: kick (sites, 3) turns with h b. Both points are brought to |w|."""
    def slope(x, part):
        return np.cross(x, witness.spec.orientation * h * witness.turning(x, t + part * h) + kick)

    def projected(x):
        length, size = np.linalg.norm(w, axis=1), np.linalg.norm(x, axis=1)
        return x * np.where(size > 0, length / np.where(size > 0, size, 1), 1)[:, None]
    one = slope(w, 0)
    w = projected(w + (one + slope(projected(w + one), 1)) / 2)
    return w if np.all(np.isfinite(w)) else None


def depondt_mertens(witness, w, t: float, h: float, kick=0):
    """Depondt and Mertens 2009: turned by the mean of the angles at w and at the point ahead, kick in both."""
    def turn(x, part):
        return witness.spec.orientation * h * witness.turning(x, t + part * h) + kick
    one = turn(w, 0)
    w = by((one + turn(by(one, w), 1)) / 2, w)
    return w if np.all(np.isfinite(w)) else None


MOST = 1000     # iterations
PATIENCE = 5    # of them without a smaller change: round-off is reached


def at_rest(iterate, x):
    """The fixed point of x -> iterate(x), to round-off; None where there is none to be found."""
    least, idle = np.inf, 0
    for _ in range(MOST):
        new = iterate(x)
        change, x = np.abs(new - x).max(), new
        if not np.isfinite(change):
            return None
        idle, least = (0, change) if change < least else (idle + 1, least)
        if change == 0 or idle > PATIENCE and least <= 1e-12 * np.abs(x).max():
            return x
    return None


def matrices(v):
    """x -> v x x, (sites, 3, 3)."""
    return np.cross(v[:, None, :], np.eye(3)[None]).swapaxes(1, 2)


def isospectral(witness, w, t: float, h: float):
    """Modin and Viviani 2020, in matrices: w = (1 - h B/2) V (1 + h B/2), W = (1 + h B/2) V (1 - h B/2), B = -b as a matrix, b at V."""
    start = matrices(w)

    def factors(V):
        half = -witness.spec.orientation * h / 2 * matrices(witness.turning(np.stack([V[:, 2, 1], V[:, 0, 2], V[:, 1, 0]], 1), t + h / 2))
        return np.eye(3) - half, np.eye(3) + half

    def stage(V):
        left, right = factors(V)
        return np.linalg.solve(left, np.linalg.solve(right.swapaxes(1, 2), start.swapaxes(1, 2)).swapaxes(1, 2))
    V = at_rest(stage, start)
    if V is None:
        return None
    left, right = factors(V)
    W = right @ V @ left
    return np.stack([W[:, 2, 1], W[:, 0, 2], W[:, 1, 0]], 1)


def geodesic(witness, w, t: float, h: float):
    """The great circle through w whose direction halfway is that of X there, as long as |h X|. X halfway, brought back to w along the
    circle, is its part across w, as long as X."""
    r = np.linalg.norm(w, axis=1)[:, None]
    r = np.where(r > 0, r, 1)

    def along(direction, part):
        size = np.linalg.norm(direction, axis=1)[:, None]
        return np.cos(part * size / r) * w + r * np.sin(part * size / r) * direction / np.where(size > 0, size, 1)

    def velocity(direction):
        x = h * witness.vector_field(along(direction, 1 / 2), t + h / 2)
        across = x - np.sum(x * w, axis=1)[:, None] * w / r**2
        size = np.linalg.norm(across, axis=1)[:, None]
        return across * np.linalg.norm(x, axis=1)[:, None] / np.where(size > 0, size, 1)
    direction = at_rest(velocity, np.zeros_like(w))
    return None if direction is None else along(direction, 1)


def exponential(witness, w, t: float, h: float):
    """w = v - v x x/2 + k ((x.v) x - a^2 v), W = w + v x x, with x = h b at v, a = |x|, k = (1 - (a/2) cot(a/2))/a^2: linear equations for v."""
    def turn(v):
        return witness.spec.orientation * h * witness.turning(v, t + h / 2)

    def stage(v):
        x = turn(v)
        square = np.sum(x * x, axis=1)
        half = np.maximum(np.sqrt(square) / 2, 1e-4)    # below, k is 1/12
        k = ((1 - half / np.tan(half)) / (4 * half * half))[:, None, None]
        outer = x[:, :, None] * x[:, None, :] - square[:, None, None] * np.eye(3)
        return np.linalg.solve(np.eye(3) + matrices(x) / 2 + k * outer, w[:, :, None])[:, :, 0]
    v = at_rest(stage, w)
    return None if v is None else w + np.cross(v, turn(v))
