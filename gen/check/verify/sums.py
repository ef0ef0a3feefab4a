"""Compensation: the sum w + u + u' + .. loses nothing to the rounding of W = w + u.

The residuals of a run's steps, r = W - w - h X(m), are what rounding did to them. With a carry they cancel: their sum
over n steps is one rounding of w at either end, and n roundings of u, which a small h makes small. Without, it
is n roundings of w: each is uniform over a unit in the last place of W, so that their sum has the variance
sum ulp(W)^2/12. The sum of the residuals in units of that is 1 without compensation, and some hundredths with it.

The formula of X is rounded too, near a vortex by far more than an ulp of X, and from step to step by much the same amount. That
error is h times a number, so h is chosen so small that n of them of one sign stay below what is looked for.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ...extremes import largest
from ..witness import EQUATIONS
from .case import EPS, Case
from .leaves import lengths
from .residual import cancelled
from .row import Row, at_most, not_applicable

PART = 0.4              # of what plain sums leave: on all shipped specs 0.67 to 1.1 without a carry, 0.03 to 0.07 with it
STEPS = 256             # the ends then leave sqrt(2/256) = 0.09 of it
ANGLE = 1 / 128         # by which a step turns the fastest site: n roundings of u are that much smaller
OF_FIELD = PART / 4     # of what plain sums leave: the most that the round-off of X may make in n steps
SAMPLES = 48            # starts times sites


def sums(case: Case, subject) -> list[Row]:
    """One row: the rms over starts and sites of the summed residuals, in units of what plain sums leave."""
    if "plain-sums" in case.features:
        return [not_applicable("sums", "plain sums were requested")]
    if case.settings.method not in EQUATIONS:
        return [not_applicable("sums", "the interpreter cannot compute residuals of this method")]
    starts = np.array([case.nudged(0.1) for _ in range(max(4, -(-SAMPLES // case.sites)))])
    h = small(case, starts)
    try:
        ends = subject.run(starts, 0.0, h, range(1, STEPS + 1))
    except RunError as error:
        return [not_applicable("sums", f"orbits near the start cannot be followed for {STEPS} steps: {error}")]
    parts = np.concatenate([left(case, states, h) for states in np.concatenate([starts[None], ends]).swapaxes(0, 1)])
    if not parts.size:
        return [not_applicable("sums", "nothing moves")]
    return [at_most("sums", float(np.sqrt(np.mean(parts))), PART, f"over {STEPS} steps of h = {h:.3g} from {len(starts)} states")]


def small(case: Case, starts) -> float:
    """The run's h, or a smaller one: the products |n||b| of u = h n x b are ANGLE |w| at most, the round-off of X stays below
    OF_FIELD, and the run is not longer."""
    h = abs(case.h) * min(1, max(case.settings.steps, 1) / STEPS)
    fastest = largest(*(np.max(speed(case, w)) for w in starts))
    loss = largest(*(np.max(of_field(case, w)) for w in starts))
    h = min([h, *(most / x for most, x in ((ANGLE, fastest), (OF_FIELD, loss)) if x > 0)])
    return float(np.copysign(h, case.h))


def speed(case: Case, w) -> np.ndarray:
    """|n||R|/|w| of every site, w' = n x R."""
    return lengths(case.leaves.normal(w)) * lengths(case.witness.turning(w, 0.0)) / np.maximum(lengths(w), np.finfo(float).tiny)


def of_field(case: Case, w) -> np.ndarray:
    """What the round-off of X may make in STEPS steps, over h and over what plain sums leave, of every site; 0 where w = 0."""
    made, leave = STEPS * EPS * cancelled(case, w, 0.0), np.sqrt(STEPS * plain(w))
    return np.divide(made, leave, out=np.zeros(len(w)), where=leave > 0)


def plain(w) -> np.ndarray:
    """The variance of one rounding of every site of w; leading axes are kept."""
    return np.sum(np.spacing(np.abs(w)) ** 2, axis=-1) / 12


def left(case: Case, states, h) -> np.ndarray:
    """|sum of residuals|^2 over its variance with plain sums, of every site that moves."""
    total = case.witness.residuals(states, 0.0, h, case.settings.method).sum(axis=0)
    moves = np.any(states[1:] != states[:-1], axis=(0, 2))
    return np.sum(total**2, axis=1)[moves] / plain(states[1:]).sum(axis=0)[moves]
