"""The history in a saved state, taken apart and put together anew.

What a step begins with is a polynomial through the increments of the steps before, which a saved state holds, newest first, with the
degree. With another history and another degree there, the same step begins elsewhere: so its iterations can be counted from any beginning.
"""
from __future__ import annotations

import numpy as np

from ...run.step.integrator import Integrator
from ...run.step.saved import DEGREE, HEAD, HISTORY, NEWTON_STEPS, PAST, SCALE, TOLERANCE


def another(one: Integrator) -> Integrator:
    """A second trajectory of the same library."""
    return Integrator(one.prepared, one.built, one.threads)


class Past:
    """Where the increments stand in the saved states of a method that keeps its own; `saved` is one with a whole history.

    A single sphere keeps 1/|w + W| beside each increment, and no polynomial through all of its rows.
    """

    def __init__(self, saved: np.ndarray, sites: int):
        self.first, kept = int(saved[PAST]), int(saved[HISTORY])
        size = len(saved) - self.first
        self.width = 3 * sites if sites > 1 or size != 4 * kept else 4
        self.rows, self.sites = size // self.width, sites
        self.degrees = range(kept - (self.width == 4))

    def state(self, saved) -> np.ndarray:
        """w and what it has lost to rounding, of all sites."""
        return (saved[HEAD:self.first].reshape(2, -1)).sum(axis=0)

    def row(self, saved, j: int) -> np.ndarray:
        """The increments of the last step but j."""
        return saved[self.first + j * self.width: self.first + (j + 1) * self.width]

    @staticmethod
    def asked(saved, tolerance: float) -> np.ndarray:
        """`saved` with a tolerance of steps; that of the steps before no longer says which passes need no look."""
        found = saved.copy()
        found[TOLERANCE], found[NEWTON_STEPS] = tolerance, 0
        return found

    def forgotten(self, saved) -> np.ndarray:
        """`saved` without a history."""
        found = saved.copy()
        found[HISTORY], found[self.first:] = 0, 0
        return found

    def begun(self, saved, rows, degree: int) -> np.ndarray:
        """`saved` with another history, `rows` newest first, of which a polynomial of this degree is the beginning."""
        found = saved.copy()
        found[self.first:], found[DEGREE] = np.concatenate(rows), degree
        return found

    def begun_at(self, saved, increment) -> np.ndarray:
        """`saved` with steps that begin at this increment."""
        return self.begun(saved, [increment] * self.rows, 0)

    def along(self, saved, increment, degree: int) -> np.ndarray:
        """`saved` with a history on a polynomial of this degree, whose next value is `increment`: u_j = (1 - j/2n)^d u."""
        rows = [increment * (1 - (j + 1) / (2 * self.rows)) ** degree for j in range(self.rows)]
        return self.begun(saved, rows, degree)

    def moved(self, saved, after) -> float:
        """How far the newest increments of two states differ, in units of the largest component of w."""
        return float(np.abs(self.row(saved, 0) - self.row(after, 0))[:3 * self.sites].max() / saved[SCALE])
