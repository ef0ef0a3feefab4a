"""Methods with steps from large to small: which error each has at the end, and what it keeps on the way."""
from __future__ import annotations

import dataclasses
import math
import time as clock
from dataclasses import dataclass

import numpy as np

from ...errors import RunError
from ...extremes import largest, smallest
from ...language.spec import LOOSEST
from ...methods import METHODS
from ...run.record.conserved import energy_of, with_tracers
from .case import Case
from .reference import Reference

TURN = 4.0          # angle of the fastest site in the largest steps
LARGE = 4           # while steps are no smaller than a part of that, smaller ones may be so much cheaper that the run is shorter
RATIO = {2: 2.0, 4: 2 ** 0.5}       # order -> ratio of the steps of neighbours; others:
FINE = 2 ** 0.25
FLOOR = 4           # times the error of the reference: nothing smaller is resolved
WINDOW = 3          # neighbours whose best is compared with the median of as many before: one that is small by chance counts for little
RESOLVED = 1e-3     # larger errors may still stand for a while
TOLERANCES = tuple(10.0 ** (-2 - k / 2) for k in range(26))       # of methods that take steps of their own
WITHIN = 16         # steps in which they give samples
PART = 0.1          # of a row's error that all its steps together may leave to tolerances
HALF = 0.5          # of a row's energy error: then neither the steps nor the iterations are better than they need be
ROUND_OFF = 2.0 ** -52      # no tolerance below ends an iteration
QUICKEST = 1e-9     # seconds of a site and step, at least: of those that failed no time is known
BRIEF = 5e-3        # seconds: a run in pieces that takes less is timed again in one
SAMPLES = 48        # points of a run at which invariants are looked at


@dataclass
class Row:
    """One method with one step. h, steps; tolerance: of a step, nan for round-off; status: "" or why it failed; end_error: in units of |w|; energy, momentum,
    casimir: the largest errors on the way, of the energy absolute, of momenta relative to the largest |w|, of Casimirs to
    themselves; drift: of the energy in a unit of time, with its error; iterations: the mean of a step; seconds of a run, half
    the distance of their quartiles, and seconds of the generator and compiler, short where the build was in the cache."""
    method: str
    h: float
    steps: int
    tolerance: float = math.nan
    status: str = ""
    end_error: float = math.nan
    energy: float = math.nan
    momentum: float = math.nan
    casimir: float = math.nan
    drift: float = math.nan
    drift_error: float = math.nan
    iterations: float = math.nan
    seconds: float = math.nan
    spread: float = math.nan
    ns_step: float = math.nan
    compiled: float = math.nan


COLUMNS = tuple(f.name for f in dataclasses.fields(Row))


def ladder(case: Case, name: str, known: Reference, limit: float) -> list[Row]:
    """Rows of one method, from large steps to round-off, or until a run would take more than `limit` seconds."""
    if METHODS[name].controlled:
        return [one(case, name, min(WITHIN, case.fewest(TURN)), known, tolerance) for tolerance in TOLERANCES]
    rows, errors, steps = [], [], case.fewest(TURN)
    while True:
        row = one(case, name, steps, known)
        rows += [row, *with_tolerance(case, row, known)]
        errors += [row.energy if known.chaotic else row.end_error] if row.status == "" else []
        floor = 0.0 if known.chaotic else FLOOR * known.error
        too_long = steps > case.fewest(TURN / LARGE) and next_seconds(case, name, row) > limit
        if at_round_off(errors) or (errors and errors[-1] <= floor) or too_long:
            return rows
        steps = max(steps + 1, round(steps * ratio(name)))


def at_round_off(errors: list[float]) -> bool:
    """Do they fall no more?"""
    before, last = errors[-2 * WINDOW:-WINDOW], errors[-WINDOW:]
    return len(before) == WINDOW and largest(*before) < RESOLVED and smallest(*last) >= 0.7 * float(np.median(before))


def with_tolerance(case: Case, row: Row, known: Reference) -> list[Row]:
    """The same with iterations that end where what they leave is a tenth of the row's own error, where that spares some."""
    left = tolerable(row, known)
    return [] if row.status or not left > ROUND_OFF else loosened(case, row, known, left)


def loosened(case: Case, row: Row, known: Reference, tolerance: float) -> list[Row]:
    """A run with iterations to round-off once more, to a tolerance; none where there is nothing that a tolerance would end: in explicit steps, in
    those of midpoints on a single sphere, and where no iteration is spared."""
    method = METHODS[row.method]
    if method.how[:1] == ("explicit",) or method.of_midpoints and len(case.w) == 1:
        return []
    found = one(case, row.method, row.steps, known, min(LOOSEST, tolerance))
    return [] if found.iterations >= row.iterations else [found]


def tolerable(row: Row, known: Reference) -> float:
    """What a step may leave: of the end error a share; where no end is known, of the energy error, as if the steps walked at random. Where
    they drift, the energy error of the run to the tolerance tells."""
    return HALF * row.energy / math.sqrt(row.steps) if known.chaotic else PART * row.end_error / row.steps


def ratio(name: str) -> float:
    """Between the numbers of steps of neighbours."""
    return RATIO.get(METHODS[name].order, FINE)


def next_seconds(case: Case, name: str, row: Row) -> float:
    """How long the next row would take, by this one; if this one failed, at least."""
    return (row.seconds if row.seconds == row.seconds else QUICKEST * row.steps * len(case.w)) * ratio(name)


def one(case: Case, name: str, steps: int, known: Reference | None, tolerance: float | None = None) -> Row:
    """A run with samples of what it keeps; its time is taken once, for an estimate."""
    row = Row(name, case.time / steps, steps, math.nan if tolerance is None else tolerance, compiled=case.compiled[name, "double"])
    model = case.model(name)
    try:
        model.start(case.w.copy(), h=row.h, tolerance=tolerance)
        samples = [sample(model)]
        spent, iterations = 0.0, []
        for count in parts(steps):
            began = clock.thread_time()
            model.steps(count)
            spent += clock.thread_time() - began
            samples.append(sample(model))
            iterations.append(model.report()["iterations"])
    except RunError as error:
        return dataclasses.replace(row, status=str(error).split(";")[0])
    end = np.array(model.w)
    row.seconds, row.iterations = spent if spent > BRIEF else whole(model, row, case.w), float(np.mean(iterations))
    row.ns_step = 1e9 * row.seconds / steps
    if known is not None and not known.chaotic:
        row.end_error = case.distance(end, known.end)
    kept(case, row, samples)
    return row


def whole(model, row: Row, w) -> float:
    """Seconds of the run in one piece: the pieces of a short one are mostly calls."""
    model.start(w.copy(), h=row.h, tolerance=row.tolerance if row.tolerance == row.tolerance else None).advance(0)
    began = clock.thread_time()
    model.advance(row.steps)
    return clock.thread_time() - began


def parts(steps: int) -> list[int]:
    """The numbers of steps between samples."""
    edges = np.unique(np.round(np.linspace(0, steps, min(SAMPLES, steps) + 1)).astype(int))
    return list(np.diff(edges))


def sample(model) -> tuple:
    """(t, energy, momenta, Casimirs); the energy is that of the effects that no tracer feels, nan where there are none."""
    named = dict(zip(model.columns, model.values()))
    energy = energy_of(named, with_tracers(model.scene))
    momenta = [v for name, v in named.items() if name.startswith("momentum.")]
    return model.t, math.nan if energy is None else energy, np.array(momenta), model.casimirs()


def kept(case: Case, row: Row, samples) -> None:
    """What the samples say of the energy, the momenta and the Casimirs."""
    t, energy = np.array([s[0] for s in samples], float), np.array([s[1] for s in samples], float)
    momenta, casimirs = np.array([s[2] for s in samples], float), np.array([s[3] for s in samples], float)
    row.momentum = float(np.abs(momenta - momenta[0]).max()) / case.size
    row.casimir = float((np.abs(casimirs - casimirs[0]) / np.maximum(np.abs(casimirs[0]), 1e-300)).max())
    if case.energy_changes:
        return
    row.energy = float(np.abs(energy - energy[0]).max())
    if len(t) > 3:
        row.drift, row.drift_error = slope(t, energy - energy[0])


def slope(t, y) -> tuple[float, float]:
    """Of the line through the points, with its standard error."""
    x = t - t.mean()
    a = float(x @ y / (x @ x))
    left = y - y.mean() - a * x
    return a, float(np.sqrt(left @ left / (len(t) - 2) / (x @ x)))
