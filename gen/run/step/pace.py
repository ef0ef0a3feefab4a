"""How many steps one call into C takes: few enough that Ctrl-C and the progress are prompt."""
from __future__ import annotations

import time

from ... import ranks

PATIENCE = 0.05         # seconds in C at most


class Pace:
    """How many steps fit in PATIENCE seconds, from those before; the same on all ranks."""

    def __init__(self, first: int = 1):
        self.size, self.seconds = first, 0.0
        self.patience = PATIENCE * (ranks.PATIENCE if ranks.count() > 1 else 1)

    def timed(self, advance, asked: int) -> int:
        """Call advance(asked); returns its value and learns from its time."""
        begin = time.perf_counter()
        done = advance(asked)
        taken = ranks.same(time.perf_counter() - begin)
        self.seconds += taken
        if taken > self.patience:
            self.size = max(1, self.size // 2)
        elif 2 * asked > self.size and taken < self.patience / 4:
            self.size *= 2
        return done
