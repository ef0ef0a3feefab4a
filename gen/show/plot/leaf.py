"""Symplectic leaves in R^3: one sheet of a quadric w.(A w)/2 = c, its mesh and hidden lines.

In the eigenvectors of A (rows of `frame`), with the sign of (A, c) chosen so that c > 0, the
sheet is, by the number of positive eigenvalues l1 >= l2 >= l3 and a_i = sqrt(2 c/|l_i|):

    3            ellipsoid           a_i n_i, n on the unit sphere
    2, l3 < 0    hyperboloid         (a1 cosh u cos v, a2 cosh u sin v, a3 sinh u)
    2, l3 = 0    elliptic cylinder   (a1 cos v, a2 sin v, u)
    1, l2 < 0    half hyperboloid    (+-a1 cosh u, a2 sinh u cos v, a3 sinh u sin v)
    1, l2 = 0    hyperbolic cylinder (+-a1 cosh u, v, a3 sinh u), or two planes when l3 = 0
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import UsageError
from .view import View, ahead, flat

FLAT = 1e-9      # eigenvalues below this fraction of the largest count as zero


@dataclass(frozen=True)
class Leaf:
    """One sheet: `casimir` A and `level` c > 0 (signs already chosen), eigenvalues `scale`,
    `frame` (3, 3) with eigenvectors as rows, `side` +-1 where there are two sheets (else 0),
    `low` and `high` (3,): the part that is drawn, in eigenvector coordinates."""
    casimir: np.ndarray
    level: float
    scale: np.ndarray
    frame: np.ndarray
    side: int
    low: np.ndarray
    high: np.ndarray

    def drawn(self, w) -> np.ndarray:
        """(...,) truth: does the point of the quadric belong to the part that is drawn?"""
        q = np.asarray(w, float) @ self.frame.T
        slack = 1e-6 * (self.high - self.low)
        inside = np.all((q >= self.low - slack) & (q <= self.high + slack), axis=-1)
        return inside if self.side == 0 else inside & (q[..., 0] * self.side > 0)

    def seen(self, w, view: View) -> np.ndarray:
        """(...,) truth: no drawn part of the sheet lies between the point and the viewer."""
        w, d = np.asarray(w, float), view.matrix[2]
        slope, bend = w @ (self.casimir @ d), 0.5 * d @ self.casimir @ d
        if flat(bend, self.casimir):
            return np.ones(slope.shape, bool)
        s = -slope / bend
        return ~(ahead(s, w) & self.drawn(w + s[..., None] * d))


def leaf_of(casimir, curves, margin: float = 1.18) -> Leaf:
    """The leaf that carries the trajectories `curves` (each (k, 3)), drawn a little beyond them.

    Raises UsageError when the start lies on C = 0 (a cone or a point, no leaf to draw).
    """
    A, w = np.asarray(casimir, float), np.concatenate([np.asarray(c, float) for c in curves])
    w = w[np.all(np.isfinite(w), axis=1)]
    level = 0.5 * w[0] @ A @ w[0]
    if abs(level) < 1e-12 * max(np.abs(A).max() * (w[0] @ w[0]), 1e-300):
        raise UsageError("the trajectory lies on C = 0, where there is no symplectic leaf to draw")
    A, level = (A, level) if level > 0 else (-A, -level)
    values, vectors = np.linalg.eigh(A)
    order = np.argsort(values)[::-1]
    values, frame = values[order], vectors.T[order]
    values = np.where(np.abs(values) < FLAT * np.abs(values).max(), 0.0, values)
    frame = frame * np.where(frame[np.arange(3), np.abs(frame).argmax(1)] < 0, -1, 1)[:, None]
    return bounded(A, level, values, frame, w @ frame.T, margin)


def bounded(A, level, values, frame, q, margin) -> Leaf:
    """A Leaf whose drawn part covers the coordinates q (k, 3) with a margin."""
    size = np.sqrt(2 * level / values[0])
    side = int(np.sign(q[0, 0])) if np.sum(values > 0) == 1 else 0
    middle = 0.5 * (q.max(0) + q.min(0))
    half = np.maximum(0.5 * margin * (q.max(0) - q.min(0)), 0.8 * size)
    low, high = middle - half, middle + half
    if side == 0:
        low[:2], high[:2] = -np.inf, np.inf
        if values[2] > 0:
            low[2], high[2] = -np.inf, np.inf
    elif values[1] < 0:
        rim = 1.0 * max(np.abs(q[:, 0]).max(), 1.35 * size) * margin
        low, high = np.array([-rim, -np.inf, -np.inf]), np.array([rim, np.inf, np.inf])
    else:
        low[0], high[0] = -np.inf, np.inf
    low, high = np.where(np.isinf(low), -1e30, low), np.where(np.isinf(high), 1e30, high)
    return Leaf(A, level, values, frame, side, low, high)


def mesh(leaf: Leaf, m: int = 40, n: int = 60) -> np.ndarray:
    """(m, n, 3) points of the sheet, on the parameters given at the head of this file."""
    l, side = leaf.scale, leaf.side
    a = np.sqrt(2 * leaf.level / np.where(l == 0, 1, np.abs(l)))
    round_ = np.linspace(0, 2 * np.pi, n)
    if side == 0:
        q = closed_sheet(leaf, a, np.linspace(0, 1, m), round_)
    elif l[1] < 0:
        u = np.linspace(0, np.arccosh(leaf.high[0] / a[0]), m)[:, None]
        q = (side * a[0] * np.cosh(u) + 0 * round_, a[1] * np.sinh(u) * np.cos(round_),
             a[2] * np.sinh(u) * np.sin(round_))
    else:
        v = np.linspace(leaf.low[1], leaf.high[1], n)
        x = np.linspace(leaf.low[2], leaf.high[2], m)[:, None]
        bend = (x / a[2]) ** 2 if l[2] < 0 else 0 * x
        q = (side * a[0] * np.sqrt(1 + bend) + 0 * v, v + 0 * x, x + 0 * v)
    return np.stack(q, axis=-1) @ leaf.frame


def closed_sheet(leaf: Leaf, a, along, around):
    """Eigenvector coordinates of an ellipsoid, a one-sheet hyperboloid or an elliptic cylinder."""
    if leaf.scale[2] > 0:
        polar = np.pi * along[:, None]
        return (a[0] * np.sin(polar) * np.cos(around), a[1] * np.sin(polar) * np.sin(around),
                a[2] * np.cos(polar) + 0 * around)
    x = (leaf.low[2] + (leaf.high[2] - leaf.low[2]) * along)[:, None]
    wide = np.sqrt(1 + (x / a[2]) ** 2) if leaf.scale[2] < 0 else 1 + 0 * x
    return a[0] * wide * np.cos(around), a[1] * wide * np.sin(around), x + 0 * around
