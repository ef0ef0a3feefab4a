"""Equilibria of one spin and their kind, from its field b(w) alone.

w is an equilibrium of w' = w x b(w) where w x b(w) = 0. On the tangent plane the linearised
field is a 2 x 2 matrix of trace zero; its determinant is positive at a centre (stable) and
negative at a saddle (unstable); where it vanishes the linear part does not decide.
"""
from __future__ import annotations

import numpy as np


def tangents(w) -> np.ndarray:
    """(2, 3): two unit vectors orthogonal to the unit vector w and to each other."""
    e = np.eye(3)[int(np.argmin(np.abs(w)))]
    a = np.cross(w, e)
    a /= np.linalg.norm(a)
    return np.array([a, np.cross(w, a)])


def linearised(field, w, step: float = 1e-5):
    """The tangent components of X = w x b(w) (2,) and their central differences (2, 2)."""
    basis = tangents(w)
    at = lambda u: w_x_b(field, unit(w + u @ basis)) @ basis.T
    columns = [(at(step * e) - at(-step * e)) / (2 * step) for e in np.eye(2)]
    return at(np.zeros(2)), np.array(columns).T


def unit(w):
    return w / np.linalg.norm(w)


def w_x_b(field, w):
    return np.cross(w, np.asarray(field(w), float))


def refine(field, w, tries: int = 40):
    """Newton's method on the sphere from w; None where it does not come to rest."""
    for _ in range(tries):
        x, jacobian = linearised(field, w)
        if np.linalg.norm(x) < 1e-12:
            return w
        move, *_ = np.linalg.lstsq(jacobian, -x, rcond=1e-10)
        w = unit(w + np.clip(move, -0.3, 0.3) @ tangents(w))
    return w if np.linalg.norm(linearised(field, w)[0]) < 1e-9 else None


def kind_of(jacobian) -> str:
    """'stable', 'unstable' or, where the determinant vanishes to rounding, 'degenerate'."""
    determinant, size = np.linalg.det(jacobian), np.abs(jacobian).max()
    if abs(determinant) < 1e-4 * size * size:
        return "degenerate"
    return "unstable" if determinant < 0 else "stable"


def equilibria(field, seeds: int = 60):
    """[(w (3,), 'stable' | 'unstable' | 'degenerate')] found from `seeds` starts spread over the unit sphere.

    field: w (3,) -> b (3,).
    """
    i = np.arange(seeds) + 0.5
    polar, around = np.arccos(1 - 2 * i / seeds), np.pi * (1 + 5**0.5) * i
    starts = np.stack([np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar),
                       np.cos(polar)], axis=1)
    found = []
    for w in (refine(field, s) for s in [*starts, *np.eye(3), *-np.eye(3)]):
        if w is not None and all(np.linalg.norm(w - v) > 1e-5 for v, _ in found):
            found.append((w, kind_of(linearised(field, w)[1])))
    return sorted(found, key=lambda m: tuple(np.round(m[0], 6)))
