"""Rows of general integrators: a sweep over tolerances, what each run keeps, in the columns of every other row."""
from __future__ import annotations

import math
import time as clock

import numpy as np

from ..measure.case import Case
from ..measure.clock import processor_seconds
from ..measure.reference import Reference
from ..measure.sweep import FLOOR, SAMPLES, Row, kept

PART = 100          # a run is tried out over so small a part of its time
DEARER = 1.8        # a run to the next tolerance: 10^(1.25/5), of a method of order 5
TOLERANCES = tuple(10.0 ** (-2 - 1.25 * k) for k in range(11))      # a run each, from loose to what double holds


def rows_of(case: Case, name: str, known: Reference | None, limit: float) -> list[Row]:
    """Rows of one integrator, until its error is that of the reference, or a run would take more than `limit` seconds."""
    rows = []
    for tolerance in TOLERANCES:
        row = one(case, name, known, tolerance, limit)
        rows.append(row)
        if DEARER * row.seconds > limit or row.status and any(not r.status for r in rows) or row.end_error <= FLOOR * (known.error if known else 0):
            break
    return rows


def one(case: Case, name: str, known: Reference | None, tolerance: float, limit: float) -> Row:
    """A run to a tolerance; h is the mean of its steps."""
    peer, row, began = case.peers[name], Row(name, math.nan, 0, tolerance), processor_seconds()
    try:
        peer.prepare(tolerance)
    except MemoryError as problem:
        row.status = str(problem)
        return row
    row.compiled = processor_seconds() - began
    if expected(peer, tolerance, case.time) > limit:
        row.status = f"a run would take more than {limit:.3g} s"
        return row
    times = case.time * np.arange(1, SAMPLES) / (SAMPLES - 1)
    states, _ = peer.states(tolerance, times)
    end, steps = peer.states(tolerance, times[-1:])
    if states is None or end is None or not np.isfinite(end).all():
        row.status = "the integrator gave up: too many steps, or steps that are too small"
        return row
    row.steps, row.h = steps, case.time / max(1, steps)
    row.seconds = peer.seconds(tolerance, 1)
    row.ns_step = 1e9 * row.seconds / max(1, steps)
    if known is not None and not known.chaotic:
        row.end_error = case.distance(end[-1], known.end)
    kept(case, row, [sample(case, w, t) for t, w in zip((0.0, *times), (case.w, *states))])
    return row


def expected(peer, tolerance: float, time: float) -> float:
    """Seconds of a run, by the beginning of it: the second of two trials, since the first is a cold one."""
    spent = []
    for _ in range(2):
        began = clock.thread_time()
        peer.states(tolerance, np.array([time / PART]))
        spent.append(clock.thread_time() - began)
    return PART * min(spent)


def sample(case: Case, w: np.ndarray, t: float) -> tuple:
    """(t, energy, momentum, Casimirs) of a state, which may have left its leaf."""
    model = case.model(case.settings.method)
    kappa, leaf = model.prepared.numbers.kappas, model.prepared.numbers.casimir_matrices
    meter = case.meter()
    return t, math.nan if meter is None else float(meter.energy(w, t)), kappa @ w, np.einsum("ia,iab,ib->i", w, leaf, w)
