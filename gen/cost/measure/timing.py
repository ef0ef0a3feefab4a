"""Times of runs, of the processor: all of them in turn, again and again; the median and the spread of each."""
from __future__ import annotations

import time as clock

import numpy as np

from .case import Case
from .sweep import BRIEF, Row

ROUNDS = 2, 101         # at least and at most
FEWEST = 5              # runs of a measurement, where each takes less than BRIEF: one that is interrupted counts for little
SHORT = 5e-4            # seconds that a measurement takes at least: short runs are repeated within it; less than a slice of the scheduler


def take_times(case: Case, rows: list[Row], seconds: float, tick=lambda done: None) -> None:
    """Fills in seconds, spread and ns_step of the rows that got to their end, within about `seconds`."""
    good = [row for row in rows if not row.status]
    if not good:
        return
    whole = sum(max(row.seconds, SHORT) for row in good)
    rounds = int(np.clip(seconds / whole, *ROUNDS))
    taken = {id(row): [] for row in good}
    for lap in range(rounds):
        for row in good:
            taken[id(row)].append(once(case, row))
        tick((lap + 1) / rounds)
    for row in good:
        low, row.seconds, high = (float(x) for x in np.percentile(taken[id(row)], (25, 50, 75)))
        row.spread, row.ns_step = (high - low) / 2, 1e9 * row.seconds / max(1, row.steps)


def asked(row: Row) -> float | None:
    """The tolerance of a row; None for round-off."""
    return row.tolerance if row.tolerance == row.tolerance else None


def once(case: Case, row: Row) -> float:
    """Seconds of one run, without its start and the call; the median of several of short ones."""
    times = int(np.clip(SHORT / max(row.seconds, 1e-7), FEWEST if row.seconds < BRIEF else 1, 50))
    if row.method in case.peers:
        return max(case.peers[row.method].seconds(row.tolerance, times), 1e-9)
    model = case.model(row.method)
    taken, begun = np.empty((times, 2)), model.start(case.w.copy(), h=row.h, tolerance=asked(row)).save()
    for k in range(times):
        model.restore(begun).advance(0)         # the first call is a cold one
        idle = clock.thread_time()
        model.advance(0)
        began = clock.thread_time()
        model.advance(row.steps)
        taken[k] = began - idle, clock.thread_time() - began
    call, run = np.median(taken, axis=0)
    return float(run - call if run > call else run)
