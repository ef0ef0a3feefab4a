"""A look at the energy itself: how many rotations leave it unchanged in floating point?

Exact algebra proves what it finds and may miss what only a relation between functions gives.
So the derivative of H along every rotation of every family is also taken numerically, at random
states; when fewer of them are independent than the algebra says, something was missed, and the
report says so. Nothing is ever claimed from here.
"""
from __future__ import annotations

import numpy as np

from ...chance import generator
from ...language.expr import walk
from ...run.step.evaluated import casimir_matrices, parameter_values, radii, sizes
from . import bounds
from .energy import Energy
from .orbits import terms

TURN = 2e-3             # angle of the differences; their error is of order TURN^4
SMALL = 1e-8            # a singular value below this part of the largest counts as none


def unchanged(spec, values: dict):
    """The dimension of the space of (family, axis) that leave H unchanged; None: not looked."""
    size = 3 * len(spec.families)
    if _cost(spec, values) * 4 * size * 4 * (size + 4) > bounds.EVALUATIONS:
        return None
    energy = Energy(spec, values)
    rows = _rows(spec, values, energy, size)
    return None if rows is None else size - _rank(rows)


def _cost(spec, values) -> int:
    """Numbers that one energy touches, at least one a site."""
    env, places = parameter_values(spec, values), sizes(spec, values)
    sums = (terms(e.over, env, places) * sum(1 for _ in walk(e.value)) for e in spec.energies)
    return sum(count for _, count in places.values()) + sum(sums)


def _rows(spec, values, energy, size):
    """Derivatives along the rotations (columns) at random states (rows)."""
    random, rows = generator("symmetries"), []
    turns = list(_turns(spec, values, energy.places))
    for _ in range(4 * (size + 4)):
        w, t = _state(random, spec, values, energy.places), random.uniform(0, 3)
        row = [_slope(energy, turn, w, t) for turn in turns]
        if np.all(np.isfinite(row)):
            rows.append(np.append(row, energy(w, t)))
        if len(rows) == size + 4:
            return np.array(rows)
    return None


def _rank(rows) -> int:
    slopes, scale = rows[:, :-1], np.max(np.abs(rows))
    return int(np.sum(np.linalg.svd(slopes, compute_uv=False) > SMALL * scale)) if scale else 0


def _state(random, spec, values, places):
    """Uniform directions, of the radius of each sphere."""
    w = random.standard_normal((sum(n for _, n in places.values()), 3))
    r = radii(spec, values)
    return w * (np.where(np.isnan(r), 1.2, r) / np.linalg.norm(w, axis=1))[:, None]


def _turns(spec, values, places):
    """Maps w -> w turned by an angle about an axis, for each family and axis: w' = grad C x a."""
    casimir = casimir_matrices(spec, values)
    for first, count in places.values():
        for a in np.eye(3):
            cross = np.array([[0, a[2], -a[1]], [-a[2], 0, a[0]], [a[1], -a[0], 0]])    # v -> v x a
            yield slice(first, first + count), np.einsum("ij,sjk->sik", cross, casimir[first:first + count])


def _turned(turn, w, angle):
    """exp(angle K) w for the sites of one family."""
    sites, generators = turn
    out, term = w.copy(), w[sites]
    for n in range(1, 9):
        term = angle / n * np.einsum("sij,sj->si", generators, term)
        out[sites] += term
    return out


def _slope(energy, turn, w, t):
    """dH/d(angle) by differences of order 4."""
    def at(k):
        return energy(_turned(turn, w, k * TURN), t)
    return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * TURN)
