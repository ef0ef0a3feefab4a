"""What accuracy costs at a temperature: the error of a mean over time and members, against a reference with smaller steps.

Every method, with steps from large to small, has the same time of the processor. An error that is larger than its standard error is one of the step
(the weak error); the other kind falls as one over the root of that time. So the time for an error in all is known of every row.
"""
from __future__ import annotations

import dataclasses
import math
import time as clock
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ..errors import RunError, UsageError
from ..language.spec import Spec
from ..methods import DEFAULT, METHODS
from ..run.many.average import Job
from ..run.record.means import BINS
from ..run.settings import Settings
from ..run.step.prepared import choose as one_of, scene_of
from ..run.step.start import given_or_at
from ..tables import text_of
from .measure.case import asked_time
from .report import CostTable, duration, label, shown, table_of

USUAL = (DEFAULT, *(m.name for m in METHODS.values() if m.noise_within))
RUNGS = 4           # steps of a method, each half of the one before; the reference has half of the last
SAMPLES = 32        # of a member, in the second half of its time
FEWEST, MOST = 32, 10 ** 9      # members: what a standard error takes
REFERENCE = 4       # times the time of a row
TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001, 0.0003, 0.0001)


@dataclass
class WeakRow:
    """A method with one step. h, steps of a member; status: "" or why it failed; members; mean and its standard error; error: the mean less that of the
    reference, and its standard error; seconds of the processor for all members, and nanoseconds for one step."""
    method: str
    h: float
    steps: int
    status: str = ""
    members: int = 0
    mean: float = math.nan
    mean_error: float = math.nan
    error: float = math.nan
    error_error: float = math.nan
    seconds: float = math.nan
    ns_step: float = math.nan

    def takes(self, target: float) -> float:
        """Seconds until the root mean square error is so small, by its step and by chance; infinite where the step alone has a larger one."""
        step = max(abs(self.error), self.error_error)
        return math.inf if self.status or not target > step else self.seconds * self.mean_error ** 2 / (target ** 2 - step ** 2)


COLUMNS = tuple(f.name for f in dataclasses.fields(WeakRow))


@dataclass(frozen=True)
class WeakCost(CostTable):
    """What accuracy costs at a temperature: rows (`WeakRow`) of every method and step; reference: that of the smallest step; facts: what was measured, and where."""
    rows: list
    reference: WeakRow
    facts: dict

    header = ("kind", *COLUMNS)

    def lines(self):
        for row in (self.reference, *self.rows):
            yield "reference" if row is self.reference else "weak", *(shown(getattr(row, name)) for name in COLUMNS)

    def __str__(self) -> str:
        return words(self)


def weak_cost(spec: Spec, settings: Settings, time, methods: Iterable[str] | None, what: str | None, seconds: float, facts: Callable,
              progress: Callable[[str, float], object]) -> WeakCost:
    """Rows of the methods, and the reference. Raises UsageError for what does not fit, and where the reference has too few members for a standard error."""
    names = [one_of("method", name, USUAL if methods is None else tuple(methods)) for name in (USUAL if methods is None else methods)]
    whole = abs(asked_time(spec, settings, time) or settings.h * settings.steps)
    coarse = 2 * SAMPLES * max(1, round(whole / settings.h / (2 * SAMPLES * 4)))
    plan = [(name, coarse << k) for name in names for k in range(RUNGS)]
    share, settings = seconds / (len(plan) + REFERENCE), one_start(spec, settings)
    progress("reference", 0.0)
    reference = row_of(spec, settings, whole, DEFAULT, coarse << RUNGS, what, share * REFERENCE, 0)
    if reference.status or reference.members < FEWEST:
        raise UsageError(f"the reference, {DEFAULT} with h = {reference.h:.3g}, {reference.status or 'has too few members'}: use more --seconds or a shorter time")
    rows = []
    for k, (name, steps) in enumerate(plan):
        progress(f"{name} with {steps} steps", (k + REFERENCE) / (len(plan) + REFERENCE))
        rows.append(beside(row_of(spec, settings, whole, name, steps, what, share, k + 1), reference))
    number = what or "energy"
    return WeakCost(rows, reference, {"spec": spec.name, "run": settings.run, "number": number, "time": f"{whole:.10g}", "after": f"{whole / 2:.10g}", **facts()})


def one_start(spec: Spec, settings: Settings) -> Settings:
    """The same from the vectors of the start: those of a random one would differ with the seeds of the rows."""
    numbers = settings.numbers.of(scene_of(spec, settings.effects, settings.parameters))
    return dataclasses.replace(settings, start=given_or_at(numbers, settings.start, settings.seed))


def row_of(spec: Spec, settings: Settings, whole: float, method: str, steps: int, what, seconds: float, k: int) -> WeakRow:
    """As many members as the time allows, FEWEST at least; each row has noise of its own."""
    row = WeakRow(method, whole / steps, steps)
    try:
        mine = dataclasses.replace(settings, method=method, solver="auto", h=row.h, steps=steps, every=steps // (2 * SAMPLES), seed=1000 * (settings.seed or 0) + k)
        job = Job(spec, mine, [what] if what else ["energy"], whole / 2, MOST, BINS, None)
        began = clock.thread_time()
        while job.done < FEWEST or clock.thread_time() - began < seconds:
            job.member()
    except RunError as error:
        return dataclasses.replace(row, status=str(error).split(";")[0])
    row.seconds, row.members = clock.thread_time() - began, job.done
    row.mean, row.mean_error = float(job.statistics.levels[0].mean[0]), float(job.statistics.errors()[0])
    row.ns_step = 1e9 * row.seconds / (steps * job.done)
    return row


def beside(row: WeakRow, reference: WeakRow) -> WeakRow:
    if not row.status:
        row.error, row.error_error = row.mean - reference.mean, math.hypot(row.mean_error, reference.mean_error)
    return row


# Words

def words(cost: WeakCost) -> str:
    """The table, and which method takes the least time for an error in all."""
    f, r = cost.facts, cost.reference
    head = f"{f['spec']} {f['run']}: mean of `{f['number']}` from t = {f['after']} to {f['time']}; {f['machine']}, {f['date']}"
    known = f"errors relative to {label(r.method)} with h = {r.h:.4g}: {r.mean:.6g} ± {r.mean_error:.1g}, {r.members} members"
    return "\n".join([head, known, text_of(table(cost)).rstrip(), *fastest(cost)])


def table(cost: WeakCost):
    found = table_of("method", "h", "ns a step", "error of the mean", "standard error", "members")
    for row in cost.rows:
        told = (row.status,) if row.status else (f"{row.ns_step:.4g}", f"{row.error:.2e}" + " " * (abs(row.error) < 2 * row.error_error) + "*" * (abs(row.error) >= 2 * row.error_error),
                                                 f"{row.error_error:.1e}", str(row.members))
        found.add_row(label(row.method), f"{row.h:.4g}", *told)
    return found


def fastest(cost: WeakCost) -> list[str]:
    """Of each method the step with which it is there first."""
    said = ["* the error due to the step is significant; the others are within statistical errors"]
    for target in TARGETS:
        best = {name: min((r for r in cost.rows if r.method == name), key=lambda r: r.takes(target)) for name in dict.fromkeys(r.method for r in cost.rows)}
        there = [f"{label(name)} {duration(row.takes(target))} (h = {row.h:.3g})" for name, row in best.items() if row.takes(target) < math.inf]
        if there and target > 2 * cost.reference.mean_error:
            said.append(f"time to an error of {target:g}, from steps and statistics: " + "; ".join(there))
    return said
