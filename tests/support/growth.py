"""How far apart two nearby trajectories of a step come: the growth of its tangent map."""
import numpy as np

from .tangent import LongStep, polished

NUDGE = 1e-9        # second order in it is 1e-18: below the last bit of what is compared


def growth(case, method, count, radius, directions=2, seed=1):
    """Largest |D phi^count v| found over random unit tangents v (max norms), by differences.

    A lower bound of the norm, so that a tolerance times it is the tighter one.
    """
    step = LongStep(case, method)
    w, dice = polished(case.w.astype(np.longdouble), radius), np.random.default_rng(seed)
    base = step.model.start(w.copy(), h=step.h).steps(count).state()
    found = 0.0
    for _ in range(directions):
        near = polished(w + NUDGE * dice.uniform(-1, 1, w.shape), radius)
        apart = step.model.start(near.copy(), h=step.h).steps(count).state() - base
        found = max(found, float(np.abs(apart).max() / np.abs(near - w).max()))
    return found
