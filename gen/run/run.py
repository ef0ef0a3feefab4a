"""A run: settings from the spec and the caller, steps in C, outputs on the way.

    result = smidgen.run(spec, "demo", h=0.05, out="demo.h5")
"""
from __future__ import annotations

import contextlib
import os
import signal
import threading
import time as clock
from collections.abc import Callable, Iterable, Mapping

import numpy as np

from .. import ranks
from ..errors import UsageError
from ..language.places import all_positions
from ..language.spec import Spec
from ..public import public
from ..read.shipped import SpecLike, spec_or_name
from ..version import __version__
from .files.checkpoint import refuse_unfinished
from .files.elsewhere import Elsewhere, ElsewhereSafe
from .estimate import SHORT, end_error
from .step.integrator import Integrator
from .files.options import OPTIONS
from .files.output import MemorySink, Result, load_result, open_sink, result_of
from .step.noise import refuse_with_noise
from .step.pace import Pace
from .record.means import Means
from .record.units import units_of
from .record.record import Recorder, columns_of, entry_size
from .files.safe import SafeSink
from .settings import Settings, model_of, settle
from .step.start import find_start
from .step.status import RESCUED
from .step.substeps import substep

MEMORY = 2 ** 31        # bytes of outputs that a run keeps in memory


class Interrupted(KeyboardInterrupt):
    """Ctrl-C: the step was finished; `result` holds what was computed."""

    def __init__(self, result):
        super().__init__("interrupted")
        self.result = result


@public
@spec_or_name
def run(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, method: str | None = None, solver: str | None = None,
        h: float | str | None = None, steps: int | None = None, time: float | str | None = None, every: int | None = None,
        period: float | str | None = None, what: Iterable[str] | None = None, effects: Iterable[str] | None = None,
        parameters: Mapping[str, object] | None = None, seed: int | None = None, real: str = "double", native: bool | None = None,
        substeps: bool | None = None, checkpoint: int | None = None, estimate: bool | None = False, tolerance: float | None = None,
        fast: bool = False, threads: int | None = None, averages: Mapping[str, object] | None = None, out: str | os.PathLike | None = None, keep: bool | None = None,
        progress: Callable[[int], object] | None = None) -> Result:
    """Run a spec, which may be given by its path or name as for `load`, and return a Result.

    run: of the spec, by default its first. In place of what that run says:
    start: the name of a start, or an array of shape (sites, 3); method, solver: their names;
    h: the step, and steps (their number) or time (a multiple of h), how long; every: steps
    between outputs, or period: the time between them; h, time and period in the unit of
    time of the spec, numbers or formulas of its parameters such as "2*pi/n"; what: names of
    outputs (states, energy, momentum, casimirs, magnetisation, charge, observables); effects: names of those to keep;
    parameters: name -> number, or a sequence for an array; seed: of random starts, and of thermal noise;
    checkpoint: steps between two checkpoints (needs `out`); substeps: take a step that fails
    as up to 2^10 smaller ones.
    out: a file .csv, .npz or .h5; keep: hold the outputs in memory, by default when there is no
    `out`; progress: a function of the steps done; real: "double" or "long double"; native:
    compile for this processor (None: as `build` does); estimate: repeat the run with larger and smaller steps, and estimate from the
    differences the error of the final state, `meta["end_error"]`, in units of the largest |w|, or None and in `meta["end_error_withheld"]` why;
    None: where the run took less than 2 s, as `meta["estimate"]` then says;
    tolerance: of a step, as for `Integrator.start`; fast: native, and products and sums in one operation; threads: as for `build`;
    averages: {"what": names, "after": time, "bins": how many}, each optional: `meta["means"]` then has the averages over the outputs from that time on, and `what=()` keeps no
    rows but the first and the last.
    Raises UsageError (KeywordError) for what does not fit, RunError for a step that fails and
    Interrupted for Ctrl-C (their `result` holds what was computed), OutputError for a file that
    cannot be written, MissingTool and BuildError as `build` does.
    """
    if out is None and checkpoint:
        raise UsageError("checkpoints need a file: give out=\"result.h5\" (on the command line: --out result.h5)")
    settings = settle(spec, run, start=start, method=method, solver=solver, h=h, steps=steps, time=time,
                      every=every, period=period, what=what, effects=effects, parameters=parameters, seed=seed,
                      real=real, native=native, substeps=substeps, checkpoint=checkpoint, estimate=estimate, tolerance=tolerance, fast=fast,
                      threads=threads, averages=averages)
    return execute(begun(spec, settings), settings, out, out is None if keep is None else keep, progress)


@public
def repeat(path: str | os.PathLike, out: str | os.PathLike | None = None, *, keep: bool | None = None,
           progress: Callable[[int], object] | None = None) -> Result:
    """Do again what wrote the file `path`; the same program gives the same numbers.

    out, keep, progress: as for `run`, which also says what is raised.
    """
    from .files.recorded import recorded
    spec, name, settings = recorded(load_result(path).meta)
    return run(spec, name, out=out, keep=keep, progress=progress, **settings)


def begun(spec: Spec, settings: Settings) -> Integrator:
    """The model of a run, at its start."""
    s = settings
    model = model_of(spec, s)
    if s.substeps:
        refuse_with_noise(model.scene, "no substeps", "a step that fails is taken as two of h/2 with the same noise anyway")
    return model.start(s.own_start, h=s.h, seed=s.seed, tolerance=s.tolerance)


def execute(model: Integrator, settings: Settings, out, keep: bool, progress=None, place=None):
    """Step a started model through the run and write the outputs.

    place: (folder, newest state) of a run to go on with, as `resume` finds them.
    """
    layout = columns_of(model, settings.what)
    _affordable(layout, settings, keep)
    sinks = [MemorySink(layout)] if keep else []
    if out is not None:
        sinks.append(ranks.on_first(lambda: _file_sink(out, model, settings, layout, place), send=False)
                     or (ElsewhereSafe() if place or settings.checkpoint else Elsewhere()))
    recorder = Recorder(model, layout, sinks, settings.steps * settings.h, averaging(model, settings), settings)
    began = clock.perf_counter()
    try:
        began -= _go_on(model, recorder, sinks, place)
        status, error = advance(model, settings, recorder, progress or (lambda done: None),
                                lambda: _save(model, recorder, began))
        return _finish(model, settings, recorder, status, error, began)
    except BaseException:
        for sink in sinks:
            getattr(sink, "abandon", lambda: None)()
        raise


def averaging(model: Integrator, settings: Settings) -> Means | None:
    """What takes the averages of a run that has some."""
    return None if settings.averages is None else Means(model, **settings.averages, interval=settings.every * abs(settings.h))


def _file_sink(out, model, settings, layout, place):
    """The sink of a file: with checkpoints, or one that writes as the run goes."""
    meta = describe(model, settings)
    if place:
        return SafeSink(out, meta, layout, place[0])
    if settings.checkpoint:
        return SafeSink(out, meta, layout)
    refuse_unfinished(out)
    return open_sink(out, meta, layout)


def _go_on(model, recorder, sinks, place) -> float:
    """Be where a run was stopped; returns the seconds it had taken. The recorder has seen the start."""
    if not place:
        return 0.0
    safe = sinks[-1]
    facts, arrays = place[1] or ({"count": None, "rows": 0, "seconds": 0.0}, None)
    safe.go_on(facts)
    if arrays is None:
        return 0.0
    for sink in sinks[:-1]:
        for chunk in safe.chunks():
            sink.write(chunk)
    model.restore(arrays["state"])
    recorder.go_on(facts)
    return facts["seconds"]


def advance(model, settings, recorder, progress, save):
    """(status, error) after stepping to the end, to a failure or to Ctrl-C; save() makes a checkpoint."""
    pace = Pace()
    with on_interrupt() as interrupted:
        if not recorder.begun:
            recorder.take(0, 0, 1)
            save()
        while model.count < settings.steps:
            if interrupted():
                return "interrupted", None
            if not _some_steps(model, settings, recorder, pace):
                error = model.failure()
                if not (settings.substeps and _rescued(model, recorder, error)):
                    return f"failed: {error}", error
                if model.count % settings.every == 0:
                    recorder.take(0, 0, 1)
            if settings.checkpoint and model.count % settings.checkpoint == 0:
                save()
            progress(model.count)
    return "complete", None


def _some_steps(model, settings, recorder, pace) -> bool:
    """As many steps as fit in PATIENCE, to the next checkpoint at most, with the outputs on the way; False where one failed."""
    stops = [settings.steps] + [(model.count // k + 1) * k for k in [settings.checkpoint] if k]
    left, first = min(stops) - model.count, settings.every - model.count % settings.every
    if first > min(left, pace.size):
        asked = min(left, pace.size)
        return pace.timed(model.advance, asked) == asked
    rows = min(recorder.room, 1 + (min(left, pace.size) - first) // settings.every)
    asked = first + (rows - 1) * settings.every
    return pace.timed(lambda _: recorder.take(first, settings.every, rows), asked) == asked


def _rescued(model, recorder, error) -> bool:
    """Was the step that failed taken as smaller ones?"""
    k = substep(model) if error.status in RESCUED else None
    if k is not None:
        recorder.split(k)
    return k is not None


def _save(model, recorder, began) -> None:
    """A checkpoint, for a sink that makes them: all rows, then the state that goes with them."""
    for sink in recorder.sinks:
        if isinstance(sink, SafeSink):
            recorder.flush()
            sink.save(model.count, model.save(), {**recorder.facts(), "seconds": clock.perf_counter() - began})


def _affordable(layout, settings, keep):
    total = entry_size(layout) * (settings.steps // settings.every + 1 if settings.what else 2)
    if keep and total > MEMORY:
        raise UsageError(f"the outputs take {total / 2 ** 30:.1f} GiB of memory: write them to "
                         "a file (out=\"result.h5\"), or give a larger every")


def describe(model: Integrator, settings: Settings, status: str = "running") -> dict:
    """The metadata of a run: all that is needed to repeat it."""
    spec, built = model.spec, model.built
    facts = {option.key: getattr(settings, option.name) for option in OPTIONS if option.kind}
    start, scene = settings.start, model.scene
    if not isinstance(start, str):
        start = find_start(spec, None).name if start is None else np.asarray(start).tolist()
    return {
        "program": "smidgen", "version": __version__, "generator": built.generator,
        "spec": spec.name, "title": spec.title, "digest": spec.digest,
        "sources": [list(pair) for pair in spec.sources], "orientation": spec.orientation,
        "run": settings.run, **facts, "what": list(settings.what), "start": start, "set": _plain(settings.parameters),
        "parameters": _plain(model.parameters), "effects": list(scene.effect_names),
        "chosen": _plain(model.notes), "families": {f: n for f, (_, n) in model.families.items()},
        "compiler": built.compiler, "flags": list(built.flags),
        "units": units_of(model, settings.what), "status": status, "done": model.count, "end_error": None, "end_error_withheld": None, "means": None,
    }


def _plain(values: dict) -> dict:
    """Values as JSON has them; floats keep all their digits."""
    return {k: v.tolist() if isinstance(v, (np.ndarray, np.generic)) else v
            for k, v in values.items()}


def _finish(model, settings, recorder, status, error, began):
    recorder.flush()
    meta, extras, t = describe(model, settings, status), {"final": model.state()}, model.t
    if status == "complete":
        meta["estimate"] = settings.estimate if settings.estimate is not None else bool(model.scene.heated) or ranks.on_first(lambda: clock.perf_counter() - began < SHORT)
        if meta["estimate"]:
            meta["end_error"], meta["end_error_withheld"] = estimated(model, settings, extras["final"])
    numbers = model.prepared.numbers
    if (there := all_positions(numbers.spec, {name: count for name, (_, count) in numbers.places.items()}, numbers.values)) is not None:
        extras["positions"] = there
    if settings.substeps:
        extras["substeps"] = np.array(recorder.substeps, float).reshape(-1, 3)
    memory = [s.columns for s in recorder.sinks if isinstance(s, MemorySink)]
    meta["means"] = None if recorder.means is None else recorder.means.found()
    _close(model, recorder, meta, extras, began)
    empty = {"step": np.empty(0, np.int64), "t": np.empty(0)}
    summary = {"t": t, **recorder.deviations.summary(), "in_parts": len(recorder.substeps), "halved": model.halved,
               "estimate_left_out": settings.estimate is None and meta["estimate"] is False, "nearest": recorder.block.near_centre(model), "seconds": clock.perf_counter() - began}
    return _outcome(result_of(meta, {**(memory[0] if memory else empty), **extras}, summary), status, error)


def estimated(model, settings, final) -> tuple[float | None, str | None]:
    """The error of the final state, or why there is no estimate; the trajectory of the run is kept."""
    with on_interrupt() as interrupted:
        return end_error(Integrator(model.prepared, model.built), settings, final, interrupted)


def _close(model, recorder, meta, extras, began):
    """Give the files their names. A run with checkpoints is safe before; interrupted, it may go on."""
    for sink in recorder.sinks:
        if isinstance(sink, SafeSink):
            _save(model, recorder, began)
            sink.close(meta, extras, recorder.capacity, keep=meta["status"] == "interrupted")
        elif not isinstance(sink, MemorySink):
            sink.close(meta, extras)


def _outcome(result, status, error):
    if error is not None:
        error.result = result
        raise error
    if status == "interrupted":
        raise Interrupted(result)
    return result


@contextlib.contextmanager
def on_interrupt():
    """Yields a function that says whether Ctrl-C came, to any rank; a second one stops at once."""
    seen = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield ranks.anywhere(seen.is_set)
        return

    def first(number_, frame):
        seen.set()
        signal.signal(signal.SIGINT, before)

    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, first)
    try:
        yield ranks.anywhere(seen.is_set)
    finally:
        signal.signal(signal.SIGINT, before)
