"""`smidgen run --distributed`: every rank of MPI stores its own part of a lattice alone, and writes it to the result itself.

`result.h5.distributed/` holds the run until it is complete:

    result.h5           all arrays at their places (files/places.py); metadata come last
    run.json            the metadata of the run, all that is needed to repeat it
    state-<count>.bin   with checkpoints, the saved state after `count` steps, and
    newest.json         which of them counts, and what else a run that goes on must know
"""
from __future__ import annotations

import json
import os
import shutil
import time as clock
from pathlib import Path

import numpy as np

from .. import ranks
from ..errors import OutputError, UsageError
from ..extremes import largest
from ..language.places import on_lattice, placed_on
from ..language.spec import Lattice
from ..system import sync_folder
from .files.checkpoint import CheckpointError
from .files.output import RESERVED, known_format, result_of
from .files.places import finish, lay_out, standing, write_at
from .files.recorded import recorded
from .record.conserved import driven, energy_of, with_tracers
from .record.record import columns_of
from .run import Interrupted, describe, on_interrupt
from .settings import Settings, settle
from .step.divided import divided
from .step.pace import Pace

# What newest.json says: steps of the state, outputs, seconds so far, the energy of the first output (or null) and its largest deviation, steps between checkpoints.
NEWEST = {"count": int, "rows": int, "seconds": float, "first": (float, type(None)), "largest": float, "checkpoint": int}
OF_OUTPUTS = ("states", "energy", "momentum")     # and observables


def run_distributed(spec, run, out, progress=None, **given):
    """Run a spec and return a Result without states, which are in the file `out`. The other arguments are those of `smidgen.run`."""
    settings = settle(spec, run, **given)
    refuse(spec, settings, out)
    return complete(begun(spec, settings), settings, Store(out), None, progress)


def resume_distributed(path, progress=None):
    """Go on with the run that was writing `path`, on any number of ranks."""
    store = Store(path)
    meta, newest = ranks.on_first(store.read)
    spec, name, given = recorded(meta)
    settings = settle(spec, name, **given, checkpoint=newest["checkpoint"])
    model = begun(spec, settings)
    now = json.loads(json.dumps(describe(model, settings)))
    if differing := [key for key in meta if key not in ("status", "done") and now.get(key) != meta[key]]:
        raise CheckpointError(f"{path} was started with different settings ({', '.join(differing)}): the bits would differ. "
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


class Store:
    """The folder of a run that is not complete, and the files in it. Every rank holds one; rank 0 makes them."""

    def __init__(self, out):
        self.out, self.folder, self.handle = Path(out), Path(f"{out}.distributed"), None
        self.file = self.folder / "result.h5"

    def read(self):
        """(metadata, newest checkpoint) of the run to go on with. Raises CheckpointError."""
        try:
            meta, newest = (json.loads((self.folder / name).read_text()) for name in ("run.json", "newest.json"))
        except (OSError, ValueError):
            raise CheckpointError(f"there is no checkpoint of {self.out} in {self.folder}") from None
        if not (isinstance(meta, dict) and isinstance(newest, dict) and newest.keys() == NEWEST.keys()
                and all(isinstance(newest[key], kind) for key, kind in NEWEST.items())):
            raise CheckpointError(f"{self.folder}/newest.json is not a checkpoint of a distributed run")
        return meta, newest

    def found(self, work):
        """work(), which reads a file of the checkpoint. Raises CheckpointError where it is not there, or another."""
        try:
            return work()
        except (OSError, ValueError):
            raise CheckpointError(f"the files in {self.folder} are not those of the checkpoint") from None

    def create(self, meta: dict, arrays: dict) -> dict:
        """Begin a run; name -> Place of its arrays."""
        if (self.folder / "newest.json").exists():
            raise CheckpointError(f"{self.out} has checkpoints of a run that was not finished: "
                                  f"continue with `smidgen run --resume {self.out}`, or remove {self.folder}")
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir()
        self.put("run.json", meta)
        places = lay_out(self.file, arrays)
        with open(self.file, "rb") as file:
            os.fsync(file.fileno())
        return places

    def put(self, name: str, facts: dict) -> None:
        """A small file, complete under its name or not there."""
        with open(self.folder / f"{name}.new", "w") as file:
            json.dump(facts, file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(self.folder / f"{name}.new", self.folder / name)
        sync_folder(self.folder)

    def open(self) -> None:
        self.handle = os.open(self.file, os.O_WRONLY)

    def release(self) -> None:
        if self.handle is not None:
            os.close(self.handle)
        self.handle = None

    def abandon(self) -> None:
        """Leave no trace, unless there is a checkpoint."""
        if ranks.first() and not (self.folder / "newest.json").exists():
            shutil.rmtree(self.folder, ignore_errors=True)

    def state(self, count: int) -> Path:
        """The saved state after `count` steps."""
        return self.folder / f"state-{count}.bin"

    def write_state(self, model) -> None:
        """This rank's part of a saved state, on the disk."""
        handle = os.open(self.state(model.count), os.O_WRONLY | os.O_CREAT, 0o666)
        try:
            for begin, numbers in model.save_parts():
                write_at(handle, numbers, begin * model.real.itemsize)
            os.fsync(handle)
        finally:
            os.close(handle)

    def finish(self, meta: dict, rows: int, columns, keep: bool) -> None:
        """Give the result its name; keep: a run with checkpoints may go on."""
        if keep:
            return
        finish(self.file, meta, rows, columns)
        os.replace(self.file, self.out)
        sync_folder(self.out.resolve().parent)
        shutil.rmtree(self.folder)


def told(store, work):
    """work(); what the system refuses becomes an OutputError."""
    try:
        return work()
    except OSError as problem:
        raise OutputError(f"cannot write {store.out}: {problem.strerror or problem}") from None


def on_all(store, work):
    """The same on all ranks: what one of them is refused is an error of all."""
    return ranks.on_all(lambda: told(store, work))


def on_first(store, work):
    """The same on rank 0 alone."""
    return ranks.on_first(lambda: told(store, work))


class Rows:
    """The outputs of a distributed run: each rank writes its vectors, rank 0 numbers. Keeps the largest deviation of the energy."""

    def __init__(self, model, settings, store):
        self.model, self.settings, self.store = model, settings, store
        self.layout, self.count, self.seconds, self.first, self.largest = columns_of(model, settings.what), 0, 0.0, None, 0.0
        if named := next((f for f in model.families if f in RESERVED), None):
            raise UsageError(f"'{named}' is already the name of another column of the results; rename the family")
        self.family = next(iter(model.families))
        over = placed_on(model.spec, self.family)
        self.over = over if isinstance(over, Lattice) else None

    def arrays(self) -> dict:
        """name -> (shape, dtype) of all that the file has."""
        rows = self.settings.steps // self.settings.every + 1 if self.settings.what else 2
        whole = ((self.model.sites, 3), self.model.real)
        extras = {"final": whole, **({"positions": ((self.model.sites, 3), np.dtype(float))} if self.over else {})}
        return {**{name: ((rows, *shape), kind) for name, (shape, kind) in self.layout.items()}, **extras}

    def begin(self, newest) -> None:
        """A new file, or the one that was being written."""
        model, store = self.model, self.store
        if newest is None:
            self.places = on_first(store, lambda: store.create(describe(model, self.settings), self.arrays()))
            on_all(store, store.open)
            return
        self.count, self.seconds, self.first, self.largest = newest["rows"], newest["seconds"], newest["first"], newest["largest"]
        self.places = ranks.on_first(lambda: store.found(lambda: standing(store.file, self.arrays())))
        state = ranks.on_all(lambda: store.found(lambda: np.memmap(store.state(newest["count"]), model.real, "r")))
        on_all(store, store.open)
        model.restore(state)

    def is_due(self, step: int) -> bool:
        """Is there an output of this step that has not been written?"""
        every = self.settings.every if self.settings.what else self.settings.steps or 1
        return step % every == 0 and step // every == self.count

    def take(self) -> None:
        """One output of the present state."""
        values = dict(zip(self.model.columns, self.model.values())) if set(self.layout) - {"step", "t", self.family} else {}
        energy = energy_of(values, with_tracers(self.model.scene)) if "energy" in self.layout else None
        if energy is not None:
            self.first = float(energy) if self.first is None else self.first
            self.largest = float(largest(self.largest, abs(energy - self.first)))
        on_all(self.store, lambda: self.write(values))
        self.count += 1

    def write(self, values: dict) -> None:
        """This rank's part of a row."""
        if self.family in self.layout:
            self.put(self.family, self.places[self.family].row(self.count), self.model.part)
        momentum = f"momentum.{self.family}"
        numbers = {**values, "step": self.model.count, "t": self.model.t, momentum: [values.get(f"{momentum}.{x}") for x in "xyz"]}
        for name, (_, kind) in self.layout.items() if ranks.first() else ():
            if name != self.family:
                write_at(self.store.handle, np.asarray(numbers[name], kind), self.places[name].row(self.count))

    def put(self, name: str, offset: int, vectors) -> None:
        """Vectors of this rank's sites in an array of all."""
        write_at(self.store.handle, vectors, offset + 3 * self.model.first * self.places[name].kind.itemsize)

    def save(self, seconds: float) -> None:
        """A checkpoint: the rows and the state of all ranks are on the disk before it counts."""
        store, count = self.store, self.model.count
        on_all(store, lambda: (store.write_state(self.model), os.fsync(store.handle)))
        facts = {"count": count, "rows": self.count, "seconds": seconds, "first": self.first, "largest": self.largest,
                 "checkpoint": self.settings.checkpoint}
        on_first(store, lambda: self.count_on(facts))

    def count_on(self, facts) -> None:
        self.store.put("newest.json", facts)
        for old in self.store.folder.glob("state-*.bin"):
            if old != self.store.state(facts["count"]):
                old.unlink()

    def close(self, status: str, began: float):
        """The last state and the metadata; the file gets its name."""
        model, keep = self.model, status == "interrupted" and bool(self.settings.checkpoint)
        if keep:
            self.save(clock.perf_counter() - began)
        else:
            on_all(self.store, self.write_last)
        meta = {**describe(model, self.settings, status), "estimate": False}
        t, halved = model.t, model.halved
        model.close()
        columns = list(self.layout)
        on_first(self.store, lambda: self.store.finish(meta, self.count, columns, keep))
        facts = {"t": t, "halved": halved, "seconds": clock.perf_counter() - began}
        return result_of(meta, {"step": np.empty(0, np.int64), "t": np.empty(0)}, {**self.summary(), **facts})

    def summary(self) -> dict:
        """As that of other runs; of deviations only that of the energy over the outputs is known."""
        kind = "changes" if driven(self.model.scene) else "errors"
        nothing = {"errors": {}, "changes": {}, "axes": [], "without": [], "at_end": [], "by_rows": None, "in_parts": 0, "nearest": None}
        return {**nothing, **({kind: {"energy": self.largest}} if self.count > 1 and self.first is not None else {})}

    def write_last(self) -> None:
        """What no row has: the last state, and where sites stand."""
        self.put("final", self.places["final"].offset, self.model.part)
        sites = self.over.sites if self.over else 1
        for first, count in self.model.windows() if self.over else ():
            found = on_lattice(self.over, self.model.prepared.numbers.values, first // sites, -(-(first + count) // sites))
            write_at(self.store.handle, found[first % sites:][:count], self.places["positions"].row(first))
        os.fsync(self.store.handle)
