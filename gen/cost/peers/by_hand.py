"""Dormand-Prince of order 8 written by hand in C, over a field written by hand: what a person would write for one system.

Nothing of it is generated, so it stands beside the methods as C does that owes them nothing. There is such a field for a few
specs (the files of fields/), and it must be the field of the case.
"""
from __future__ import annotations

import ctypes

import numpy as np

from ...chance import generator
from ..measure.case import Case
from .compiled import FIELDS, NEEDS, Compiled, Missing

POINTS = 8              # states at which both fields are compared
SAME = 1e-12            # what they differ by at most, as part of the largest component


class ByHand(Compiled):
    """It, on one case. Raises Missing where there is no field for the case."""

    def __init__(self, case: Case, source: str, kind: int):
        if not (FIELDS / f"{case.spec.name}.h").exists():
            raise Missing(NEEDS[source])
        super().__init__(case, source, kind)
        if not self.same_field():
            raise Missing(NEEDS[source])

    def options(self) -> list[str]:
        return [f'-DFIELD="fields/{self.model.name}.h"', f"-DSITES={len(self.case.w)}"]

    def same_field(self) -> bool:
        """Is it the field of the case? A spec may have the name of another one."""
        self.prepare(1.0)
        self.functions.peer_field.argtypes = [ctypes.c_void_p] * 3
        draw = generator("a field by hand")
        for w in (self.case.w, *draw.normal(size=(POINTS, *self.case.w.shape))):
            w, mine, its = np.ascontiguousarray(w), np.empty_like(w), np.empty_like(w)
            self.functions.peer_field(self.handles[1.0], w.ctypes.data, mine.ctypes.data)
            self.functions.peer_rate(self.model._state, 0.0, w.ctypes.data, its.ctypes.data)
            if not np.abs(mine - its).max() <= SAME * np.abs(its).max():
                return False
        return True
