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
from . import interrupts
from .files.checkpoint import refuse_unfinished
from .files.elsewhere import Elsewhere, ElsewhereSafe
from .estimate import end_error
from .step.block import clean
from .step.integrator import Integrator
from .files.plain import plain
from .files.options import OPTIONS, SHORT
from .files.output import MemorySink, Result, load_result, open_sink, result_of
from .step.noise import refuse_with_noise
from .step.pace import Pace
from .step.saved import HISTORY
from .record.means import Means, numbers_of
from .record.units import units_of
from .record.record import Recorder, columns_of, entry_size
from .files.safe import SafeSink
from .settings import Settings, model_of, settle
from .step.start import find_start
from .step.status import RESCUED
from .step.substeps import substep

MEMORY = 2 ** 31        # bytes of outputs that a run keeps in memory


class Interrupted(KeyboardInterrupt):
    """Ctrl-C: the current step was completed; `result` contains the outputs so far."""

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
    """Run a spec and return a Result. Arguments that are not given are taken from the run in the spec.

    :param spec: a Spec, a Model, the path of a spec, or the name of one that comes with smidgen.
    :param run: the name of a run in the spec; by default the first.
    :param start: the name of a start, or an array of shape (sites, 3).
    :param method: the name of a method (`smidgen list --methods`).
    :param solver: "auto", "newton", "rotation" or "plain".
    :param h: the step size: a number, or a formula of the parameters such as "2*pi/n". Times are in the unit of time of the spec.
    :param steps: the number of steps.
    :param time: the duration, in place of `steps`; a multiple of h.
    :param every: the number of steps between outputs.
    :param period: the time between outputs, in place of `every`.
    :param what: the outputs: "states", "energy", "momentum", "casimirs", "magnetisation", "charge", and names of observables.
    :param effects: the names of the effects to keep; the others are removed.
    :param parameters: values of parameters by name: a number, or a sequence for an array.
    :param seed: the seed of random starts and of thermal noise.
    :param real: "double" or "long double".
    :param native: whether to compile for this processor; None chooses what is fastest without changing a bit of the result.
    :param substeps: whether to replace a failed step by up to 2^10 smaller ones.
    :param checkpoint: the number of steps between checkpoints; needs `out`.
    :param estimate: whether to repeat the run with larger and smaller steps, and estimate the error of the final state relative to the
        largest component, `meta["end_error"]` (None if there is no estimate; `meta["end_error_withheld"]` gives the reason). None: only if
        the run took less than 2 s.
    :param tolerance: the error allowed in a step, relative to the largest component of w; by default round-off.
    :param fast: like `native`, and with fused multiply-add instructions, which change the last bits.
    :param threads: the number of OpenMP threads that share a step; the result is the same, bit for bit.
    :param averages: a dictionary with the optional keys "what" (names), "after" (a time) and "bins". `meta["means"]` then contains
        averages over the outputs from that time on; with `what=()` only the first and the last row are kept.
    :param out: the file to write: .csv, .npz or .h5.
    :param keep: whether to keep the outputs in memory; by default only without `out`.
    :param progress: a function that is called with the number of steps done.
    :raises UsageError: for an argument that does not fit (KeywordError for an unknown one).
    :raises RunError: if a step fails; its `result` contains the outputs up to then. Interrupted, on Ctrl-C, has a `result` too.
    :raises OutputError: if the file cannot be written.
    :raises MissingTool: if there is no C compiler. BuildError if it fails.
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
    """Repeat the run that wrote the file `path`. The same version of smidgen gives the same numbers.

    The other arguments and the errors are those of `run`.
    """
    from .files.recorded import recorded
    spec, name, settings = recorded(load_result(path).meta)
    return run(spec, name, out=out, keep=keep, progress=progress, **settings)


def begun(spec: Spec, settings: Settings) -> Integrator:
    """The model of a run, at its start."""
    s = settings
    model = model_of(spec, s)
    if s.substeps:
        refuse_with_noise(model.scene, "`substeps`", "a failed step is always replaced by two of h/2 with the same noise")
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
    """The sink of a file: with checkpoints, or one that writes as the run goes. Raises UsageError for a start that files cannot tell."""
    if not (settings.start is None or isinstance(settings.start, str)) and np.any(np.asarray(settings.start, float) != settings.start):
        raise UsageError("the start has more digits than a double, and its file could not repeat the run: use start.astype(float), or no file")
    meta = describe(model, settings)
    if place or settings.checkpoint:
        return SafeSink(out, meta, layout, settings.checkpoint, place and place[0])
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
                error = model.failure().with_more(recorder.deviations.grown(model.values()))
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
                         "a file (out=\"result.h5\"), or use a larger every")


def describe(model: Integrator, settings: Settings, status: str = "running") -> dict:
    """The metadata of a run: all that is needed to repeat it."""
    spec, built = model.spec, model.built
    facts = {option.key: getattr(settings, option.name) for option in OPTIONS if option.kind}
    start, scene = settings.start, model.scene
    averaged = () if settings.averages is None else numbers_of(model, settings.averages["what"])
    if not isinstance(start, str):
        start = find_start(spec, None).name if start is None else plain(np.asarray(start))
    return {
        "program": "smidgen", "version": __version__, "generator": built.generator,
        "spec": spec.name, "title": spec.title, "digest": spec.digest,
        "sources": [list(pair) for pair in spec.sources], "orientation": spec.orientation,
        "run": settings.run, **facts, "what": list(settings.what), "start": start, "set": _plain(settings.parameters),
        "parameters": _plain(model.parameters), "effects": list(scene.effect_names),
        "chosen": _plain(model.notes), "families": {f: n for f, (_, n) in model.families.items()},
        "compiler": built.compiler, "flags": list(built.flags),
        "units": units_of(model, settings.what, averaged), "status": status, "done": model.count, "end_error": None, "end_error_withheld": None, "means": None,
    }


def _plain(values: dict) -> dict:
    """Values as JSON has them."""
    return {name: plain(value) for name, value in values.items()}


def went_by_rows(model) -> bool | None:
    """Was the last step of a lattice solved by rows? That is seen in what it keeps for the next: fewer increments. None where rows are no choice, or too few steps were taken."""
    from ..compile.plan.layout import HISTORY as KEPT, MIDPOINT_ROWS
    if MIDPOINT_ROWS not in model.notes.get("reason", "") or model.count <= KEPT:
        return None
    return bool(model.save()[HISTORY] < KEPT)


def _finish(model, settings, recorder, status, error, began):
    recorder.flush()
    recorder.look_at_end()
    meta, extras, t, by_rows = describe(model, settings, status), {"final": clean(model.state())}, model.t, went_by_rows(model)
    if status == "complete":
        meta["estimate"] = settings.estimate if settings.estimate is not None else bool(model.scene.heated) or ranks.on_first(lambda: clock.perf_counter() - began < SHORT)
        if meta["estimate"]:
            meta["end_error"], meta["end_error_withheld"] = estimated(model, settings, extras["final"])
    recorder.without_absent(extras["final"])
    numbers = model.prepared.numbers
    if (there := all_positions(numbers.spec, {name: count for name, (_, count) in numbers.places.items()}, numbers.values)) is not None:
        extras["positions"] = there
    if settings.substeps:
        extras["substeps"] = np.array(recorder.substeps, float).reshape(-1, 3)
    memory = [s.columns for s in recorder.sinks if isinstance(s, MemorySink)]
    meta["means"] = None if recorder.means is None else recorder.means.found()
    _close(model, recorder, meta, extras, began)
    empty = {"step": np.empty(0, np.int64), "t": np.empty(0)}
    summary = {"t": t, **recorder.deviations.summary(), "by_rows": by_rows, "in_parts": len(recorder.substeps), "halved": model.halved,
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
    if interrupts.noted():
        seen.set()
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
