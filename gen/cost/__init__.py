"""What accuracy costs in time, measured: every method that serves a spec, with steps from large to small.

    table = smidgen.cost(spec, "demo", time=100)
    print(table)
    table.save("demo_cost.csv")
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from datetime import datetime, timezone

import numpy as np

from ..build.binary import compiler_version, find_compiler, lanes_of, native_of
from ..errors import RunError, UsageError
from ..language.spec import Spec
from ..methods import METHODS
from ..public import public
from ..read.shipped import SpecLike, spec_or_name
from ..run.step.prepared import choose as one_of, scene_of
from ..run.settings import settle
from .measure.case import Case, asked_time, candidates
from .choice import Choice, choose, known_methods, no_mean
from .report import Cost, load_cost, machine
from .measure.reference import no_reference, reference
from .measure.sweep import Row, ladder, sample
from .measure.timing import asked, take_times
from .weak import WeakCost, weak_cost
from .weak_choice import WeakChoice

__all__ = ["Choice", "Cost", "WeakChoice", "WeakCost", "choose", "cost", "load_cost"]

SECONDS = 60.0      # what the timed runs may take together
LONG = 100          # times the time: the long runs
POINTS = 120        # of a long run
AIM = 1e-6          # end error of the runs that are made long


@public
@spec_or_name
def cost(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, time: float | str | None = None,
         effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None, seed: int | None = None,
         native: bool | None = None, methods: Iterable[str] | None = None, seconds: float = SECONDS, long: bool = True, ends: bool = True,
         peers: bool | Iterable[str] = False, mean: str | None = None, progress: Callable[[str, float], object] = lambda what, done: None) -> Cost | WeakCost:
    """Measure accuracy and time of methods over a range of steps. Arguments not listed here are as for `run`.

    :param time: the duration; by default that of the run.
    :param methods: names of methods; by default all that apply.
    :param seconds: a limit on the total time of the timed runs.
    :param long: whether to measure the energy error along runs that are a hundred times as long.
    :param ends: whether to measure the error of the final state, and not only those of conserved quantities.
    :param peers: whether to include general-purpose integrators (or their names); `cost.peers`.
    :param mean: for a scene at a temperature, the quantity whose mean is judged; by default the energy.
    :param progress: a function that is called with a description of the current task and the fraction of it that is done.
    :raises UsageError: for an argument that does not fit, or if no reference solution can be computed.
    """
    settings = settle(spec, run, start=start, effects=effects, parameters=parameters, seed=seed, native=native, time=None)
    methods = known_methods(methods)
    if scene_of(spec, settings.effects, settings.parameters).heated:
        if peers or not ends:
            raise UsageError("at a temperature the error of a mean is measured: `peers` and `ends=False` are not available")
        return weak_cost(spec, settings, time, methods, mean, seconds, lambda: {"machine": machine(), **measured(settings.native)}, progress)
    no_mean(mean)
    case = Case(spec, settings, asked_time(spec, settings, time))
    progress("reference", 0.0)
    known = reference(case) if ends else no_reference(case)
    names = candidates(case, methods)
    if not names:
        raise UsageError("none of these methods applies to this spec")
    rows = []
    for k, method in enumerate(names):
        progress(f"sweep of {method}", k / len(names))
        rows += ladder(case, method, known, seconds / (4 * len(names)))
    missing = beside(case, rows, known, peers, seconds, progress) if peers else {}
    take_times(case, rows, seconds / 2, lambda done: progress("times", done))
    return Cost(rows, long_runs(case, rows, seconds / 4, progress) if long else [], {**facts(case, known), **missing})


def beside(case: Case, rows: list[Row], known, asked, seconds: float, progress) -> dict:
    """Adds the rows of general integrators; returns what is missing, as facts."""
    from .peers import PEERS, of_case
    from .peers.rows import rows_of
    case.peers, missing = of_case(case, tuple(PEERS) if asked is True else [one_of("general integrator", name, tuple(PEERS)) for name in asked])
    for k, name in enumerate(case.peers):
        progress(f"sweep of {PEERS[name].label}", k / len(case.peers))
        rows += rows_of(case, name, known, seconds / (4 * len(PEERS)))
    return {f"missing {name}": needs for name, needs in missing.items()}


def facts(case: Case, known) -> dict:
    """What heads the file."""
    sampled = case.model(case.settings.method).start(case.w.copy(), h=case.settings.h)
    agree = " and ".join(known.methods)
    said = f"{agree} in extended precision, which agree to {known.error:.1e}" + " (chaotic, or not resolved)" * known.chaotic
    said = said if known.methods else "none: judged by conserved quantities"
    return {"spec": case.spec.name, "run": case.settings.run, "time": f"{case.time:.10g}", "sites": len(case.w),
            "energy": f"{abs(float(sample(sampled)[1])):.6g}", "machine": machine(),
            **measured(case.settings.native), "reference": said,
            **{f"refused {name}": " ".join(why.split()) for (name, real), why in case.refused.items() if real == "double"}}


def measured(native: bool | None) -> dict:
    """When, by which compiler, and how many numbers the vectors of models with lanes held."""
    compiler = find_compiler()
    wide = native_of(compiler) if native is not False else ()
    return {"date": datetime.now(timezone.utc).date().isoformat(), "compiler": compiler_version(compiler), "lanes": lanes_of(compiler, wide)}


def long_runs(case: Case, rows: list[Row], seconds: float, progress) -> list[tuple]:
    """(method, h, t, energy error) of a hundred times the time, of each method with the step that comes next to AIM."""
    found, picked = [], [row for row in map(lambda name: nearest(rows, name), dict.fromkeys(r.method for r in rows if r.method in METHODS)) if row]
    for k, row in enumerate(picked):
        progress("long runs", k / len(picked))
        share = min(1.0, seconds / len(picked) / (LONG * row.seconds))
        found += along(case, row, LONG * share)
    return found


def nearest(rows: list[Row], name: str) -> Row | None:
    """The row of a method whose end error comes next to AIM; without end errors, the one in the middle."""
    own = [r for r in rows if r.method == name and not r.status and (METHODS[name].controlled or r.tolerance != r.tolerance)]
    judged = [r for r in own if r.end_error > 0]
    if judged:
        return min(judged, key=lambda r: abs(np.log(r.end_error / AIM)))
    return own[len(own) // 2] if own else None


def along(case: Case, row: Row, times: float) -> list[tuple]:
    """Energy errors at times spaced evenly in their logarithm."""
    if case.energy_changes:
        return []
    model = case.model(row.method).start(case.w.copy(), h=row.h, tolerance=asked(row))
    first, found = sample(model)[1], []
    for count in np.unique(np.geomspace(1, max(2, row.steps * times), POINTS).astype(int)):
        try:
            model.steps(int(count) - model.count)
        except RunError:
            break
        found.append((row.method, row.h, model.t, abs(float(sample(model)[1] - first))))
    return found
