"""How many steps one call into C takes: few enough that Ctrl-C and the progress are prompt."""
from __future__ import annotations

import time

PATIENCE = 0.05         # seconds in C at most


class Pace:
    """How many steps fit in PATIENCE seconds, from those before."""

    def __init__(self):
        self.size, self.seconds = 1, 0.0

    def timed(self, advance, asked: int) -> int:
        """Call advance(asked); returns its value and learns from its time."""
        begin = time.perf_counter()
        done = advance(asked)
        taken = time.perf_counter() - begin
        self.seconds += taken
        if taken > PATIENCE:
            self.size = max(1, self.size // 2)
        elif 2 * asked > self.size and taken < PATIENCE / 4:
            self.size *= 2
        return done
