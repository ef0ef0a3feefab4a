"""Which rotations and which integrals a system has, found in numbers from the interpreter's field.

Rotations. The total momentum changes like r(w) = sum kappa w x b; an axis a with a.r(w) = 0 at
every w leaves H unchanged. The axes are the null space of some random r.

Integrals of single sites. a.w_i is kept when a.X_i = 0 at every w, and w_i.(S w_i)/2 when
(S w_i).X_i = 0, linear in the entries of S: null spaces again. The Casimirs are left out.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import RunError
from .case import Case
from .leaves import lengths

NULL = 1e-10            # singular values below this, relative to the largest, are zero
LARGEST = 16            # sites whose own integrals are sought
PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def round_sites(case: Case) -> np.ndarray:
    """Mask of the sites whose leaf every rotation keeps: spheres and R^3, and C = c |w|^2."""
    a = case.leaves.casimir
    return np.all(np.abs(a - a[:, :1, :1] * np.eye(3)) == 0, axis=(1, 2)) & (a[:, 0, 0] != 0)


def rotation_axes(case: Case) -> np.ndarray:
    """Orthonormal axes, (k, 3), of the rotations of all round sites that commute with the motion."""
    acting = round_sites(case) & ~case.tracers
    if not acting.any():
        acting = round_sites(case)
    if not acting.any():
        return np.zeros((0, 3))
    rows = [np.sum(case.witness.kappa[acting, None] * np.cross(w, case.witness.field(w, t))[acting], axis=0)
            / scale for w, t, scale in samples(case, 12)]
    return np.array([a for a in null_space(np.array(rows)) if commutes(case, a)]).reshape(-1, 3)


def samples(case: Case, count):
    """Random states and times where the field is finite, with the size of kappa w b summed."""
    times = case.times()
    for k in range(20 * count):
        w, t = case.nudged(0.5), times[k % min(len(times), 16)]
        try:
            b = case.witness.field(w, t)
        except RunError:
            continue
        count -= 1
        yield w, t, max(float(np.sum(np.abs(case.witness.kappa) * lengths(w) * lengths(b))), 1e-300)
        if count == 0:
            return


def null_space(rows) -> np.ndarray:
    """Orthonormal rows spanning the null space; entries that are round-off are 0."""
    _, values, vectors = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.sum(values > NULL * max(1.0, values.max(initial=0.0))))
    found = vectors[rank:]
    return np.where(np.abs(found) < 1e-9, 0.0, found)


def commutes(case: Case, axis) -> bool:
    """X(R w) = R X(w) for a rotation about the axis, at random states: tracers included."""
    turn = rotation(axis, 0.7)
    for w, t, _ in samples(case, 3):
        at, there = (case.witness.vector_field(x, t) for x in (w, turned(case, w, turn)))
        if np.abs(there - turned(case, at, turn)).max() > 1e-10 * max(np.abs(at).max(), 1e-300):
            return False
    return True


def turned(case: Case, w, turn):
    """R w at the round sites."""
    return np.where(round_sites(case)[:, None], w @ turn.T.astype(w.dtype), w)


def rotation(axis, angle, real=float) -> np.ndarray:
    """R = 1 + sin a [n]_x + (1 - cos a) [n]_x^2."""
    n = np.asarray(axis, real) / np.sqrt(np.sum(np.asarray(axis, real)**2))
    k = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]], real)
    return np.eye(3, dtype=real) + np.sin(real(angle)) * k + (1 - np.cos(real(angle))) * (k @ k)


@dataclass(frozen=True)
class SiteIntegrals:
    """Integrals of one site: rows a of a.w, and symmetric S of w.(S w)/2, Casimirs left out."""
    site: int
    linear: np.ndarray
    quadratic: np.ndarray


def site_integrals(case: Case) -> list[SiteIntegrals]:
    """Of the first LARGEST sites, those that have any."""
    states = [(w, case.witness.vector_field(w, t)) for w, t, _ in samples(case, 24)]
    found = [integrals_of(case, states, site) for site in range(min(case.sites, LARGEST))]
    return [one for one in found if len(one.linear) or len(one.quadratic)]


def integrals_of(case: Case, states, site) -> SiteIntegrals:
    """a.X = 0 and (S w).X = 0 at all states, for a and S."""
    at, speed = (np.array([x[k][site] for x in states]) for k in (0, 1))
    entries = np.stack([at[:, a] * speed[:, b] + (at[:, b] * speed[:, a] if a != b else 0)
                        for a, b in PAIRS], axis=1)
    casimir = np.array([float(case.leaves.casimir[site, a, b]) for a, b in PAIRS])
    found = without(null_space(entries / max(np.abs(entries).max(initial=0), 1e-300)), casimir)
    return SiteIntegrals(site, null_space(speed / max(np.abs(speed).max(initial=0), 1e-300)),
                         np.array([unpacked(v) for v in found]).reshape(-1, 3, 3))


def without(rows, one) -> np.ndarray:
    """Orthonormal rows that span what is left of `rows` beside the direction `one`."""
    unit = one / np.linalg.norm(one)
    values, vectors = np.linalg.svd(rows - np.outer(rows @ unit, unit), full_matrices=False)[1:]
    return vectors[values > 1e-6]


def unpacked(entries) -> np.ndarray:
    """The symmetric matrix of six entries in the order of PAIRS."""
    out = np.zeros((3, 3))
    for k, (a, b) in enumerate(PAIRS):
        out[a, b] = out[b, a] = entries[k]
    return out
