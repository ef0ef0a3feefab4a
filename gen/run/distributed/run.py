"""A distributed run: what it refuses, its steps, and how it goes on from a checkpoint."""
from __future__ import annotations

import json
import time as clock

from ... import ranks
from ...errors import UsageError
from ..files.checkpoint import CheckpointError
from ..files.output import known_format
from ..files.recorded import recorded
from ..run import Interrupted, describe, on_interrupt
from ..settings import Settings, settle
from ..step.divided import divided
from ..step.pace import Pace
from .rows import Rows
from .store import Store

OF_OUTPUTS = ("states", "energy", "momentum")     # and observables


def run_distributed(spec, run, out, progress=None, **given):
    """Run a spec and return a Result without states, which are in the file `out`. The other arguments are those of `smidgen.run`."""
    settings = settle(spec, run, **given)
    refuse(spec, settings, out)
    return complete(begun(spec, settings), settings, Store(out), None, progress)


def resume_distributed(path, progress=None):
    """Go on with the run that was writing `path`, on any number of ranks."""
    store = Store(path)
    try:
        meta, newest = ranks.on_first(store.read)
        return go_on(store, meta, newest, progress)
    finally:
        store.release()


def go_on(store, meta, newest, progress):
    """The rest of a run that began with this metadata."""
    spec, name, given = recorded(meta)
    settings = settle(spec, name, **given, checkpoint=newest["checkpoint"])
    model = begun(spec, settings)
    now = json.loads(json.dumps(describe(model, settings)))
    if differing := [key for key in meta if key not in ("status", "done") and now.get(key) != meta[key]]:
        raise CheckpointError(f"{store.out} was started with different settings ({', '.join(differing)}): the bits would differ. "
                              f"Remove {store.folder} to start again")
    return complete(model, settings, store, newest, progress)


def refuse(spec, s: Settings, out) -> None:
    """Raises UsageError for what needs the whole state in one place."""
    if out is None or known_format(out) != ".h5":
        raise UsageError("--distributed writes HDF5 in parts: give --out result.h5")
    other = [name for name in s.what if name not in OF_OUTPUTS and name not in {o.name for o in spec.observables}]
    if other:
        raise UsageError(f"with --distributed there is no output '{other[0]}', which needs the whole state: "
                         f"choose from {', '.join(OF_OUTPUTS)} and observables")
    if not (s.start is None or isinstance(s.start, str)):
        raise UsageError("with --distributed, the start must be one of those in the spec, which each rank evaluates at its own sites: "
                         "a file given as --start cannot be read in parts")
    for asked, what in ((s.substeps, "--substeps"), (s.averages, "averages"), (s.estimate, "--estimate")):
        if asked:
            raise UsageError(f"--distributed does not support {what}, which needs the whole state")


def begun(spec, s: Settings):
    """The model of a run, at its start."""
    model = divided(s.prepared(spec), s.real, s.native, s.fast, s.threads)
    return model.start(s.start, h=s.h, seed=s.seed, tolerance=s.tolerance)


def complete(model, settings, store, newest, progress):
    """Step a started model through the rest of its run."""
    record = Rows(model, settings, store)
    began = clock.perf_counter()
    try:
        record.begin(newest)
        began -= record.seconds
        status, error = advance(model, settings, record, progress or (lambda done: None), began)
        result = record.close(status, began)
    except BaseException:
        store.abandon()
        raise
    finally:
        store.release()
    if error is not None:
        error.result = result
        raise error
    if status == "interrupted":
        raise Interrupted(result)
    return result


def advance(model, settings, record, progress, began):
    """(status, error) after stepping to the end, to a failure or to Ctrl-C."""
    pace = Pace()
    with on_interrupt() as interrupted:
        while True:
            if record.is_due(model.count):
                record.take()
            if settings.checkpoint and model.count % settings.checkpoint == 0:
                record.save(clock.perf_counter() - began)
            if model.count == settings.steps:
                return "complete", None
            if interrupted():
                return "interrupted", None
            stops = [settings.steps, *((model.count // k + 1) * k for k in (settings.every, settings.checkpoint) if k)]
            asked = min(min(stops) - model.count, pace.size)
            if pace.timed(model.advance, asked) < asked:
                error = model.failure()
                return f"failed: {error}", error
            progress(model.count)
