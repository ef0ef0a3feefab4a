"""The symmetries and the integrals of a system, from two sides.

In numbers, from the interpreter's field. The linear function sum kappa a.w generates the group action
w' = n x a, n = grad C(w): a rotation about a on spheres. H is unchanged by it, and the function kept,
when a.r(w) = 0 at every w, r = sum kappa n x b: the axes are the null space of some random r. Single
sites: a.w_i is kept when a.X_i = 0 at every w, and w_i.(S w_i)/2 when (S w_i).X_i = 0, linear in the
entries of S: null spaces again. The Casimirs are left out.

In symbols, from `smidgen.symmetry.explain`, which finds families that turn apart from the others. What
either claims, the step must keep.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import RunError
from .case import Case
from .leaves import LONG, lengths

NULL = 1e-10            # singular values below this, relative to the largest, are zero
LARGEST = 16            # sites whose own integrals are sought in numbers
PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
TAYLOR, HALVINGS = 20, 4    # terms and halvings of a matrix exponential, exact to the last bit


@dataclass(frozen=True)
class Action:
    """The turn of the sites in `mask` that sum kappa axis.w over them generates."""
    mask: np.ndarray
    axis: np.ndarray

    def __call__(self, case: Case, w, angle):
        """w turned, in the precision of w; absent sites stay where they are kept."""
        turn = exponentials(case.leaves.casimir.astype(LONG), self.axis.astype(LONG), LONG(angle))
        return np.where((self.mask & case.numbers.present)[:, None], np.einsum("sij,sj->si", turn, w.astype(LONG)), w).astype(w.dtype)


def exponentials(casimir, axis, angle) -> np.ndarray:
    """exp(angle K_i) of every site, K_i w = axis x (A_i w)/|A|, |A| the largest entry of all: a rotation about the axis where A = 1."""
    a = axis / np.sqrt(axis @ axis)
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    k = np.einsum("ij,sjk->sik", cross, casimir / np.abs(casimir).max()) * (angle / 2**HALVINGS)
    found = term = np.broadcast_to(np.eye(3, dtype=casimir.dtype), k.shape)
    for n in range(1, TAYLOR):
        term = np.einsum("sij,sjk->sik", term, k) / n
        found = found + term
    for _ in range(HALVINGS):
        found = np.einsum("sij,sjk->sik", found, found)
    return found


def explained(case: Case):
    """The report of the symbolic analysis, None where there is none."""
    try:
        from ...analyse.symmetry import explain
    except ImportError:
        return None
    s = case.settings
    return explain(case.spec, s.run or None, method=s.method, effects=s.effects, parameters=s.parameters)


def actions(case: Case, report) -> list[Action]:
    """Every action that leaves H unchanged, and the torques if there are any; those found in numbers first."""
    found = [Action(np.ones(case.sites, bool), axis) for axis in axes_in_numbers(case)]
    for names, axes in report.rotations if report else ():
        mask = members(case, names)
        if not (mask.all() and len(axes) == len(found)):
            found += [Action(mask, np.array(axis, float)) for axis in axes]
    return [action for action in found if not case.scene.pushed or commutes(case, action)]


def members(case: Case, names) -> np.ndarray:
    """Mask of the sites of these families."""
    mask = np.zeros(case.sites, bool)
    for name in names:
        first, count = case.witness.families[name]
        mask[first:first + count] = True
    return mask


def axes_in_numbers(case: Case) -> np.ndarray:
    """Orthonormal axes, (k, 3), of the actions on all sites that commute with the motion."""
    acting = ~case.tracers if not case.tracers.all() else case.tracers
    rows = [np.sum((case.witness.kappa[:, None] * np.cross(case.leaves.normal(w), case.witness.field(w, t)))[acting],
                   axis=0).astype(float) / scale for w, t, scale in samples(case, 12)]
    found = null_space(np.array(rows).reshape(-1, 3))
    return np.array([a for a in found if commutes(case, Action(np.ones(case.sites, bool), a))]).reshape(-1, 3)


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
    if not len(rows):
        return rows
    _, values, vectors = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.sum(values > NULL * max(1.0, values.max(initial=0.0))))
    found = vectors[rank:]
    return np.where(np.abs(found) < 1e-9, 0.0, found)


def commutes(case: Case, turn: Action) -> bool:
    """X(R w) = R X(w) at random states, tracers included."""
    for w, t, _ in samples(case, 3):
        try:
            at, there = (case.witness.vector_field(x, t) for x in (w, turn(case, w, 0.3)))
        except RunError:
            continue
        if np.abs(there - turn(case, at, 0.3)).max() > 1e-10 * max(np.abs(at).max(), 1e-300):
            return False
    return True


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
