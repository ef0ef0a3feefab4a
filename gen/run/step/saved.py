"""The head of a saved state: the numbers that `m_save` of runtime/core/smg_saved.h writes first."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SIZE, PAST, T0, H, COUNT_HIGH, COUNT_LOW, HISTORY, DEGREE, NEWTON_STEPS, SCALE, TOLERANCE, HEAD = range(12)
HALF = 2 ** 32      # a count is split: a double holds no integer beyond 2^53


@dataclass(frozen=True)
class Saved:
    """Time is t0 + count*h."""
    t0: float
    h: float
    count: int

    @classmethod
    def of(cls, numbers: np.ndarray) -> "Saved":
        """Read the head of a saved state."""
        count = int(numbers[COUNT_HIGH]) * HALF + int(numbers[COUNT_LOW])
        return cls(float(numbers[T0]), float(numbers[H]), count)


def retimed(numbers: np.ndarray, h: float, count: int) -> np.ndarray:
    """The same place with another step: w and what it has lost to rounding stay; the increments
    of the steps before, which were those of another h, are forgotten."""
    found = numbers.copy()
    found[H], found[HISTORY] = h, min(0, numbers[HISTORY])      # below 0: parameters were changed since the last step
    found[COUNT_HIGH], found[COUNT_LOW] = divmod(count, HALF)
    found[int(numbers[PAST]):] = 0
    return found
