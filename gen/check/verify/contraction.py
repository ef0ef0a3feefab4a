"""Where a lattice goes by rows: only where sweeps are a contraction whatever the state, since no branch is checked there.

Which way a state went is seen in what it has kept: by rows fewer increments than otherwise.
"""
from __future__ import annotations

import numpy as np

from ...compile.plan.layout import HISTORY as KEPT
from ...extremes import largest, smallest, with_largest
from ...run.step.saved import HISTORY
from ..witness import EQUATIONS
from .case import Case
from .leaves import lengths
from .past import another
from .row import Row, at_most, not_applicable

SITES = 6               # whose couplings are summed, beside two
TIMES = 8               # at most, of an H that depends on time
BEYOND = (1.0001, 1.05) # times the h where the factor is 1
NEARLY = 0.999          # of the h where no bound is left


def contraction(case: Case, subject) -> list[Row]:
    """One row: the largest factor by which sweeps may enlarge a distance, of all h that go by rows; where it is below 1 there is one solution.

    With x = |h/2 kappa|, B the sum of the norms of the Hessian's blocks in a row and F the field of no spins, a sweep changes
    distances by x B r/sqrt(1 - x^2 (B r + F)^2) at most. B and F are from differences of the field of the interpreter, which is linear.
    """
    one = getattr(subject, "double", None)
    if one is None or not one.notes.get("threads"):
        return [not_applicable("by rows", "no sweeps by rows")]
    if case.settings.method not in EQUATIONS:
        case.unseen.append("by rows: whether the sweeps of every stage contract")
        return [not_applicable("by rows", "the interpreter has no equation for a stage of this method")]
    sites = looked_at(case)
    t, rate, own = steepest(case, sites)
    if not rate > 0:
        return [not_applicable("by rows", "no site feels another")]
    one, most, seen, edge = another(one), 0.0, 0, 1 / np.hypot(rate, rate + own)       # where the factor is 1
    for x in (*(edge * part for part in BEYOND), NEARLY / (rate + own), abs(case.h) / 2):
        h = float(np.copysign(2 * x, case.h))
        went = by_rows(one, case, t, h)
        seen += went is not None
        most = largest(most, of_steps(case, t, h, sites)) if went else most
    if not seen:
        return [not_applicable("by rows", "no step near the largest of rows is taken")]
    note = f"of {seen} steps near |h| = {2 * edge:.3g}, where the factor is 1"
    return [at_most("by rows", most, 1, note)]


def factor(x, rate, own) -> float:
    left = 1 - (x * (rate + own)) ** 2
    return x * rate / left ** 0.5 if left > 0 else np.inf


def by_rows(one, case: Case, t, h) -> bool | None:
    """Did the steps of h from the start, at the time t, go by rows? None where too few are taken to tell."""
    one.start(case.w.copy(), t0=t, h=h)
    return bool(one.save()[HISTORY] < KEPT) if one.advance(KEPT + 1) > KEPT else None


def of_steps(case: Case, t, h, sites) -> float:
    """The smaller factor of the first and of the last of these steps: couplings that grow may have ended the way by rows in between."""
    return smallest(*(factor(abs(h) / 2, *slopes_at(case, t + k * h, sites)) for k in (0.5, KEPT + 0.5)))


def steepest(case: Case, sites) -> tuple[float, float, float]:
    """(t, B r, F) over kappa at the time where B is largest."""
    return with_largest([(t, *slopes_at(case, t, sites)) for t in case.times()[:TIMES]], lambda found: found[1])


def slopes(case: Case) -> tuple[float, float]:
    """The largest B r and F over kappa."""
    sites = looked_at(case)
    found = [slopes_at(case, t, sites) for t in case.times()[:TIMES]]
    return largest(*(rate for rate, _ in found)), largest(*(own for _, own in found))


def looked_at(case: Case) -> set:
    """Some sites, the first among them."""
    return {0, case.sites // 2, *case.dice.integers(0, case.sites, SITES).tolist()}


def slopes_at(case: Case, t: float, sites) -> tuple[float, float]:
    none = np.zeros_like(case.w)
    still = case.witness.field(none, t)
    radius = float(lengths(case.w).max())
    rows = []
    for k in sites:
        columns = []
        for axis in range(3):
            moved = none.copy()
            moved[k, axis] = 1.0
            columns.append(case.witness.field(moved, t) - still)
        rows.append(float(np.linalg.norm(np.stack(columns, axis=-1), 2, axis=(1, 2)).sum()))
    return largest(*rows) * radius, float(lengths(still).max())
