"""heyoka: Taylor series of an order that fits the tolerance, compiled for the case."""
from __future__ import annotations

import time as clock

import numpy as np

from ..measure.case import Case
from .compiled import Missing
from .symbols import NoExpression, system

MANY = 20           # sites from which its loops stay loops (compact mode): the compiler takes too long otherwise
STEPS = 3_000_000   # of a run at most


class Taylor:
    """taylor_adaptive on one case, with its fastest options: fast_math, and no compact mode where the system is small."""

    def __init__(self, case: Case, source: str, kind: int):
        try:
            import heyoka
        except ImportError:
            raise Missing("heyoka (pip install heyoka)") from None
        self.case, self.hy, self.handles = case, heyoka, {}
        try:
            self.system = system(heyoka, case)
        except NoExpression as problem:
            raise Missing(f"an expression of this spec: {problem}") from None

    def prepare(self, tolerance: float) -> None:
        """Compile for this tolerance."""
        if tolerance not in self.handles:
            self.handles[tolerance] = self.hy.taylor_adaptive(self.system, self.case.w.ravel().copy(), tol=tolerance, fast_math=True,
                                                              compact_mode=len(self.case.w) > MANY)

    def begun(self, tolerance: float):
        """The integrator at the start."""
        self.prepare(tolerance)
        taylor = self.handles[tolerance]
        taylor.time = 0.0
        taylor.state[:] = self.case.w.ravel()
        return taylor

    def states(self, tolerance: float, times) -> tuple[np.ndarray | None, int]:
        """(states at the times, steps taken); (None, -1) where it fails."""
        taylor, out, steps = self.begun(tolerance), [], 0
        for t in times:
            said = taylor.propagate_until(float(t), max_steps=STEPS)
            if said[0] != self.hy.taylor_outcome.time_limit:
                return None, -1
            steps += said[3]
            out.append(taylor.state.reshape(-1, 3).copy())
        return np.array(out), steps

    def seconds(self, tolerance: float, repeats: int) -> float:
        """Of one run, the mean of several; what a call to no end takes is taken off."""
        return self.run_to(self.case.time, tolerance, repeats) - self.run_to(0.0, tolerance, repeats)

    def run_to(self, end: float, tolerance: float, repeats: int) -> float:
        taylor, start, began = self.begun(tolerance), self.case.w.ravel(), clock.thread_time()
        for _ in range(repeats):
            taylor.time = 0.0
            taylor.state[:] = start
            taylor.propagate_until(end, max_steps=STEPS)
        return (clock.thread_time() - began) / repeats
