"""Parallel projection with exact hidden lines for quadric surfaces.

A viewer far away in the direction d looks at the surface C(w) = w.(A w)/2 = c. The point p
of it is hidden where the ray p + s d, s > 0, meets the surface again. Since
C(p + s d) = C(p) + s d.(A p) + s^2 C(d), the other meeting is at s = -d.(A p)/C(d):
no mesh, no depth buffer. On the sphere (A = 1) this says: hidden where d.p < 0.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class View:
    """Where the viewer stands: azimuth from x towards y, elevation above the xy-plane (degrees)."""
    azimuth: float = 35.0
    elevation: float = 22.0

    @property
    def matrix(self) -> np.ndarray:
        """Rows: the directions right, up and towards the viewer."""
        a, e = np.radians([self.azimuth, self.elevation])
        right = [-np.sin(a), np.cos(a), 0.0]
        up = [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
        toward = [np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]
        return np.array([right, up, toward])

    def project(self, w) -> np.ndarray:
        """(..., 3) points -> (..., 3): right, up, depth towards the viewer."""
        return np.asarray(w, float) @ self.matrix.T


def visible(w, view: View, casimir=None, reach=np.inf) -> np.ndarray:
    """(...,) truth: is the point seen, with the surface w.(casimir w)/2 = const before it?

    reach: the surface is drawn only out to this distance from the origin along each axis.
    """
    A = np.eye(3) if casimir is None else np.asarray(casimir, float)
    d = view.matrix[2]
    slope, curve = np.asarray(w, float) @ (A @ d), 0.5 * d @ A @ d
    if flat(curve, A):
        return np.ones(slope.shape, bool)       # the ray meets the surface once
    s = -slope / curve
    meeting = np.asarray(w, float) + s[..., None] * d
    within = np.max(np.abs(meeting), axis=-1) <= reach * (1 + 1e-9)
    return ~(ahead(s, w) & within)


def flat(curve: float, casimir) -> bool:
    """Does a ray with this C(d) meet the surface once only, up to round-off?"""
    return abs(curve) < 1e-12 * np.abs(casimir).max()


def ahead(s, w):
    """Is the other meeting before the point w, at more than round-off?"""
    return s > 1e-9 * np.max(np.abs(w), axis=-1)


def runs_of(flags) -> list[tuple[bool, int, int]]:
    """(flag, first, last+1) of the stretches of equal flags."""
    flags = np.asarray(flags, bool)
    cuts = np.flatnonzero(flags[1:] != flags[:-1]) + 1
    edges = np.concatenate(([0], cuts, [len(flags)]))
    return [(bool(flags[a]), int(a), int(b)) for a, b in zip(edges[:-1], edges[1:]) if b > a]


def split(curve, view: View, casimir=None, reach=np.inf):
    """A curve (k, 3) -> (front, back): lists of projected (m, 2) pieces, joined at the cuts."""
    curve = np.asarray(curve, float)
    curve = curve[np.all(np.isfinite(curve), axis=1)]
    return parted(view.project(curve)[:, :2], visible(curve, view, casimir, reach))


def parted(flat, seen):
    """Projected points (k, 2) -> (front, back): the pieces where `seen` (k,) is true and false."""
    front, back = [], []
    if len(flat) == 0:
        return front, back
    for flag, a, b in runs_of(seen):
        (front if flag else back).append(flat[max(a - 1, 0):b] if flag else flat[a:b + 1])
    return front, back
