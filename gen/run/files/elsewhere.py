"""Sinks of the ranks that write nothing: the run goes the same way on all of them."""
from __future__ import annotations

from .safe import SafeSink


class Elsewhere:
    """Stands in for a file."""

    def nothing(self, *_, **__):
        return ()

    write = close = abandon = nothing


class ElsewhereSafe(SafeSink):
    """The same of a run with checkpoints."""

    def __init__(self):
        self.saved, self.rows = None, 0

    write = save = chunks = close = abandon = go_on = Elsewhere.nothing
