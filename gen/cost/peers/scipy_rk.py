"""SciPy's Dormand-Prince method of order 8, with the compiled right-hand side called from Python."""
from __future__ import annotations

import time as clock

import numpy as np

from ..measure.case import Case
from .compiled import Compiled, Missing


class SciPy:
    """solve_ivp on one case."""

    def __init__(self, case: Case, source: str, kind: int):
        try:
            from scipy.integrate import solve_ivp
        except ImportError:
            raise Missing("SciPy (pip install scipy)") from None
        over = Compiled(case, source, kind)
        self.case, self.solve, self.model, rate = case, solve_ivp, over.model, over.functions.peer_rate

        def right_side(t, y):
            out = np.empty(len(y))
            rate(over.model._state, t, y.ctypes.data, out.ctypes.data)
            return out
        self.right_side = right_side

    def prepare(self, tolerance: float) -> None:
        """Nothing to do."""

    def states(self, tolerance: float, times) -> tuple[np.ndarray | None, int]:
        """(states at the times, steps taken); (None, -1) where it fails. Each time is the end of a step: it has no cheap way in between."""
        y, before, out, steps = self.case.w.ravel().copy(), 0.0, [], 0
        for t in times:
            found = self.solved(y, before, float(t), tolerance)
            if not found.success:
                return None, -1
            y, before, steps = found.y[:, -1].copy(), float(t), steps + len(found.t) - 1
            out.append(y.reshape(-1, 3))
        return np.array(out), steps

    def solved(self, y, before: float, t: float, tolerance: float):
        """What solve_ivp says."""
        return self.solve(self.right_side, (before, t), y, method="DOP853", rtol=max(tolerance, 2.3e-14), atol=tolerance)

    def seconds(self, tolerance: float, repeats: int) -> float:
        """Of one run, the mean of several."""
        y, began = self.case.w.ravel().copy(), clock.thread_time()
        for _ in range(repeats):
            self.solved(y, 0.0, self.case.time, tolerance)
        return (clock.thread_time() - began) / repeats
