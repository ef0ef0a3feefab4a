"""What a run writes: energies of all effects, momentum, Casimirs and observables, against plain sums.

At states over the whole space, for at a start many of them vanish. In extended precision, where
round-off of the formulas cannot hide a wrong digit.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ...extremes import largest
from ..validate import expected_casimirs, expected_values
from .case import Case
from .leaves import LONG
from .row import Row, at_most, not_applicable
from .whole_space import spread

DIGITS = 1e-14          # of the largest value and of what a change of w by its own size would make of it
NUDGE = 1e-6            # such a change, made smaller
STATES = 12


def outputs(case: Case, subject) -> list[Row]:
    """One row: the worst column."""
    if subject.outputs(case.w.astype(LONG), 0.0) is None:
        return [not_applicable("outputs", "this integrator does not provide values")]
    gaps, sizes, seen = {}, {}, 0
    for w, t in places(case):
        try:
            expected, near = expectation(case, w, t), expectation(case, moved(case, w), t)
        except RunError:
            continue
        given, seen = subject.outputs(w.astype(LONG), t), seen + 1
        for name in {*expected, *given}:
            a, b, c = (np.atleast_1d(np.asarray(x.get(name, np.nan), LONG)) for x in (expected, given, near))
            gaps.setdefault(name, []).append(np.abs(b - a).max() if a.shape == b.shape else np.inf)
            sizes.setdefault(name, []).append(np.abs(a).max() + np.abs(c - a).max() / NUDGE)
    return [row(gaps, sizes, seen)]


def row(gaps, sizes, seen) -> Row:
    """The largest difference of any column, relative to the column's own size."""
    if not seen:
        return not_applicable("outputs", "not finite at any of the states")
    apart = {name: float(np.nan_to_num(largest(*gaps[name]) / largest(*sizes[name], np.finfo(float).tiny), nan=np.inf)) for name in gaps}
    name = max(apart, key=apart.get)
    return at_most("outputs", apart[name], DIGITS, f"{len(apart)} columns at {seen} states; worst: {name}")


def places(case: Case):
    """(w, t): the start, and states over the whole space at the busiest times."""
    times = case.times()
    return [(case.w, 0.0), *((w, times[k % len(times)]) for k, w in enumerate(spread(case, STATES)))]


def expectation(case: Case, w, t) -> dict:
    """By the interpreter and plain sums."""
    return {**expected_values(case.witness, w, t), "casimirs": expected_casimirs(case.witness, w)}


def moved(case: Case, w):
    return w * (1 + NUDGE * case.dice.uniform(-1, 1, w.shape))
