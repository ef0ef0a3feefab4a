"""Equilibria: states at which the field of every site that moves is along its spin, given or found by relaxation."""
from __future__ import annotations

import numpy as np

from ..errors import UsageError
from ..packages import needed
from ..run.step.evaluated import Evaluated
from .hessian import Energy
from .linear import Linear, normals

STILL = 1e-6        # |n x g| of a site, over the largest |g|, of what is taken for an equilibrium
EXACT = 1e-12       # of what needs no relaxation
EVALUATIONS = 20_000
POLISHED = 6        # Newton's steps at most; they converge quadratically


def torque(numbers: Evaluated, energy: Energy, w) -> float:
    """The largest |n x g| of a site that moves, over the largest |g| if no terms cancelled: 0 at an equilibrium, at most 1."""
    moving = numbers.moving
    largest = energy.strength(w)[moving].max(initial=0.0)
    if not np.isfinite(largest):
        raise UsageError("the state is not an equilibrium: the field of some spin is not finite there")
    across = np.linalg.norm(np.cross(normals(numbers, w)[0][moving], energy.gradient(w)[moving]), axis=1)
    return float(across.max(initial=0.0) / largest) if largest > 0 else 0.0


def checked(numbers: Evaluated, energy: Energy, w) -> float:
    """The torque of an equilibrium. Raises UsageError with the number for a state that is none."""
    found = torque(numbers, energy, w)
    if not found <= STILL:
        raise UsageError(f"the state is not an equilibrium: |n x g| of some spin is {found:.3g} of the largest field |g|, above the limit of "
                         f"{STILL:g}; give an equilibrium, or have one computed (relax=True in Python, --theory without a start on the command line)")
    return found


def relaxed(numbers: Evaluated, energy: Energy, w) -> np.ndarray:
    """The minimum of the energy that steps downward lead to from w, or w where that is an equilibrium; of spheres alone.

    Raises UsageError, MissingTool."""
    if torque(numbers, energy, w) < EXACT:
        return np.array(w, float)
    minimize = needed("scipy.optimize", "relaxation to an equilibrium").minimize
    radii, free = numbers.radii, numbers.moving
    if np.isnan(radii[free]).any():
        raise UsageError("relaxation is implemented for spheres only: for other spaces, start from an equilibrium")
    radius, scale = radii[free][:, None], max(np.abs(energy.gradient(w)).max(), 1e-300)

    def placed(x):
        x = x.reshape(-1, 3)
        state = np.array(w, float)
        state[free] = radius * x / np.linalg.norm(x, axis=1)[:, None]
        return state

    def downhill(x):
        length = np.linalg.norm(x.reshape(-1, 3), axis=1)[:, None]
        state, n = placed(x), x.reshape(-1, 3) / length
        g = energy.gradient(state)[free]
        slope = radius / length * (g - n * np.sum(n * g, axis=1)[:, None])
        return energy.at(state) / scale, slope.ravel() / scale

    found = minimize(downhill, (np.asarray(w, float)[free] / radius).ravel(), jac=True, method="L-BFGS-B",
                     options={"maxiter": EVALUATIONS, "maxfun": EVALUATIONS, "ftol": 0, "gtol": 1e-9, "maxcor": 30})
    return polished(numbers, energy, placed(found.x))


def polished(numbers: Evaluated, energy: Energy, w) -> np.ndarray:
    """The equilibrium beside w by Newton's steps, as long as they come closer to it; along flat directions, such as common turns of all
    spins, they leave the state as it is."""
    best = torque(numbers, energy, w)
    for _ in range(POLISHED):
        moved = Linear(numbers, energy, w).newton()
        now = torque(numbers, energy, moved)
        if not now < best:
            break
        w, best = moved, now
    return w


def turned(before, after) -> float:
    """The largest angle between spins of two states."""
    cross = np.linalg.norm(np.cross(before, after), axis=1)
    return float(np.arctan2(cross, np.sum(before * after, axis=1)).max(initial=0.0))
