"""Refusals: a step that has a solution on the branch of W = w at h = 0 must be taken.

A bound that is too strict, or an iteration that gives up too early, leaves every result right and ends runs for no reason.
Steps that turn the fastest site by up to 0.8 are asked for from states over the whole space. For each that is refused the
interpreter follows F(d, p h) = 0 from p = 0, where d = 0, to p = 1 with its own F and F'. Beyond LARGEST sites, where
its matrix is too large, only steps are asked for whose sweeps are a contraction, so that a solution exists.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ...extremes import smallest
from ..witness import EQUATIONS
from .branch import LARGEST, newton, step
from .case import Case
from .contraction import slopes
from .leaves import lengths
from .row import Row, at_most, not_applicable
from .whole_space import spread

ANGLES = (0.2, 0.4, 0.8)      # discrete Moser-Veselov has no step where h |b| = 1 at its midpoint
STATES = (4, 64)            # the fewest and the most
WORK = {"quick": 256, "normal": 1024}      # states times sites
SURE = 0.8                  # of the step up to which sweeps are a contraction
CURVED = 1e-9               # of the field: more than round-off, so that the field is not linear and no bound is known
PACES = 64
SHORTEST = 1e-3


def refusals(case: Case, subject) -> list[Row]:
    """One row: how many steps were refused although they have a solution on the right branch."""
    if case.settings.method not in EQUATIONS:
        return [not_applicable("refusals", "the interpreter cannot compute residuals of this method")]
    why = unknown(case) if case.sites > LARGEST else ""
    if why:
        case.unseen.append(f"whether steps are refused needlessly: more than {LARGEST} sites, and {why}")
        return [not_applicable("refusals", f"no bound is known for more than {LARGEST} sites: {why}")]
    asked = list(trials(case))
    if not asked:
        return [not_applicable("refusals", "nothing moves at any of the states")]
    refused = [trial for trial in asked if step(subject, *trial) is None]
    wrong = sum(case.sites > LARGEST or solvable(case, *trial) for trial in refused)
    return [at_most("refusals", wrong, 0, f"{len(asked)} steps, {len(refused)} refused")]


def unknown(case: Case) -> str:
    """Why no bound is known up to which sweeps are a contraction; "" where one is."""
    if any(f.kind == "nambu" for f in case.spec.families):
        return "there are Nambu factors"
    if case.scene.pushed:
        return "torques act"
    return "" if linear(case) else "the field is not linear"


def linear(case: Case) -> bool:
    """Is the field linear in w, as far as two states show?"""
    at = case.witness.field
    try:
        gap = at(case.w, 0.0) - 2 * at(case.w / 2, 0.0) + at(0 * case.w, 0.0)
        return not case.timed and bool(np.abs(gap).max() <= CURVED * np.abs(at(case.w, 0.0)).max())
    except RunError:
        return False


def trials(case: Case):
    """(w, t, h) of the steps to ask for."""
    times, (few, most) = case.times()[:4], STATES
    known = slopes(case) if case.sites > LARGEST else None
    for k, w in enumerate(spread(case, max(few, min(most, case.of_tier(WORK) // case.sites)))):
        t = times[k % len(times)]
        try:
            fastest = case.fastest(w, t)
        except RunError:
            continue
        if fastest > 0:
            h = smallest(ANGLES[k % len(ANGLES)] / fastest, np.inf if known is None else longest(case, w, *known))
            yield w, t, float(np.copysign(h, case.h))


def longest(case: Case, w, rate, own) -> float:
    """A step from w up to which sweeps are a contraction: (h/2) sqrt(L^2 + M^2) < 1, see contraction.

    M is the largest |R| of w' = w x R, and L/r bounds its derivative: B r + F and B r, and with damping, where R = b + (a/r) w x b,
    sqrt(1 + a^2) (B r + F) and B r + a (2 B r + F). Gilbert's form divides R by 1 + a^2.
    """
    rate = rate * lengths(w).max() / lengths(case.w).max()
    damping, share = case.witness.damping(w)
    bound = float((share * np.hypot(rate + damping * (2 * rate + own), np.hypot(1, damping) * (rate + own))).max())
    return SURE * 2 / bound if bound > 0 else np.inf


def solvable(case: Case, w, t: float, h: float) -> bool:
    """Does the curve of solutions from W = w reach h without a fold?"""
    def equation(d, p):         # the field stays that of t + h/2
        return case.witness.equation(w, d, t + (1 - p) * h / 2, p * h, case.settings.method)
    reach = np.maximum(lengths(w), np.finfo(float).tiny)[:, None]
    d, part, pace = np.zeros_like(w), 0.0, 1 / 4
    for _ in range(PACES):
        target = min(1.0, part + pace)
        point = near(equation, d * (target / part if part else 0), target, reach)
        if point is None:
            pace /= 2
            if pace < SHORTEST:
                return False
            continue
        d, part, pace = point[0], target, 1.5 * pace
        if part == 1:
            return True
    return False


def near(equation, d, part, reach):
    """The solution near d with det F' > 0, or None."""
    try:
        point = newton(equation, d, part, reach)
    except (RunError, np.linalg.LinAlgError):
        return None
    return point if point is not None and np.linalg.det(point[1]) > 0 else None
