"""The end that errors are measured against, with an error of its own.

Two methods that share neither equation nor code path, in extended precision, each with smaller steps until nothing more is
gained. Their error is what they differ by, among themselves and from their own next to last.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import UsageError
from ...extremes import largest
from ...methods import METHODS
from .case import Case

REAL = "long double"
TURN = 1.0          # angle of the first steps
PROBE = 4           # so many smaller ones show how fast round-off grows: the flow's growth, not that of steps of a radian
GOOD = 1e-15        # an error that no run in double resolves
HALVINGS = 14
WORK = 4_000_000    # sites times steps that a halving may take
CHAOS = 1e-5        # a reference no better than this: no end errors are given
FINER = float(np.finfo(float).eps / np.finfo(np.longdouble).eps)       # units in the last place of extended precision to one of double


@dataclass(frozen=True)
class Reference:
    """end: (sites, 3) in extended precision; error: of it, in units of |w|; methods: that agree on it; chaotic: it is
    too uncertain to measure end errors by."""
    end: np.ndarray
    error: float
    methods: tuple[str, ...]

    @property
    def chaotic(self) -> bool:
        return not self.error <= CHAOS


def no_reference(case: Case) -> Reference:
    """For runs that are judged by what they keep."""
    return Reference(case.w, float("inf"), ())


def reference(case: Case, good: float = GOOD) -> Reference:
    """The reference end of a case, to `good` where that can be had. Raises UsageError where no two methods serve."""
    if lost_to_round_off(case):
        return no_reference(case)
    ends = []
    for name in by_kind():
        found = (None, np.inf) if case.model(name, REAL) is None else refined(case, name, good)
        ends += [(name, *found)] if found[0] is not None else []
        if len(ends) == 2:
            break
    else:
        raise UsageError("there is no reference solution, because fewer than two independent methods complete this run")
    (first, end, error), (second, other, more) = ends
    return Reference(end if error <= more else other, largest(error, more, case.distance(end, other)), (first, second))


def lost_to_round_off(case: Case) -> bool:
    """Does round-off of extended precision grow beyond CHAOS? As that of double does, by the first method, in the same steps: no
    smaller step helps."""
    fixed = (name for name in by_kind() if not METHODS[name].controlled and case.model(name, REAL) is not None)
    name, steps = next(fixed, None), PROBE * case.fewest(TURN)
    if name is None:
        return False
    coarse, fine = (case.end(name, steps, real) for real in ("double", REAL))
    return coarse is not None and fine is not None and case.distance(coarse, fine) > CHAOS * FINER


def by_kind() -> list[str]:
    """The method of the highest order of every header, those of midpoints last."""
    found = {}
    for name, method in METHODS.items():
        if method.header not in found or METHODS[found[method.header]].order < method.order:
            found[method.header] = name
    return sorted(found.values(), key=lambda name: (METHODS[name].of_midpoints, -METHODS[name].order))


def refined(case: Case, name: str, good: float):
    """(end, error) of a method with ever smaller steps; (None, inf) where no two of them get to the end."""
    steps, before, best = case.fewest(TURN), None, (None, np.inf)
    for _ in range(HALVINGS):
        end = case.end(name, steps, REAL)
        if end is not None and before is not None:
            error = case.distance(end, before)
            if error > best[1] / 2 and best[1] < 1e-9:
                break       # round-off
            if error < best[1]:
                best = end, error
            if error < good:
                break
        before, steps = end if end is not None else before, 2 * steps
        if steps * len(case.w) > WORK:
            break
    return best
