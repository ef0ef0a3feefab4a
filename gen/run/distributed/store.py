"""The folder of a distributed run, `result.h5.distributed/`, which holds the run until it is complete:

    result.h5           all arrays at their places (files/places.py); metadata come last
    run.json            the metadata of the run, all that is needed to repeat it
    places.json         where the arrays of result.h5 begin
    state-<count>.bin   with checkpoints, the saved state after `count` steps, and
    newest.json         which of them counts, and what else a run that goes on must know; it goes last
    lock                held by rank 0 of the run that writes

A run may be killed at any instant. A folder beside a result, but without result.h5, is what is left of a complete run.
"""
from __future__ import annotations

import contextlib
import json
import os
import shutil
from pathlib import Path

from ... import ranks
from ...errors import OutputError
from ...system import sync_folder
from ..files.checkpoint import CheckpointError, writing
from ..files.durable import check_place
from ..files.received import checked, refusing
from ..files.places import finish, lay_out, lay_out_again, standing, write_at

# What newest.json says: steps of the state, outputs, seconds so far, the energy of the first output (or null) and its largest deviation, steps between checkpoints.
NEWEST = {"count": int, "rows": int, "seconds": float, "first": (float, type(None)), "largest": float, "checkpoint": int}


class Store:
    """The folder of a run that is not complete, and the files in it. Every rank holds one; rank 0 makes them."""

    def __init__(self, out):
        self.out, self.folder, self.handle, self.lock = Path(out), Path(f"{out}.distributed"), None, None
        self.file = self.folder / "result.h5"

    def read(self):
        """(metadata, newest checkpoint) of the run to go on with, which no other run goes on with until `release`. Raises CheckpointError."""
        self.lock = writing(self.folder, self.out)
        try:
            meta, newest = (json.loads((self.folder / name).read_text()) for name in ("run.json", "newest.json"))
        except (OSError, ValueError):
            raise CheckpointError(f"there is no checkpoint of {self.out} in {self.folder}") from None
        with refusing(self.folder / "run.json", CheckpointError):
            meta = checked(meta)
        if not (isinstance(newest, dict) and newest.keys() == NEWEST.keys()
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
        check_place(self.out)
        self.folder.mkdir(exist_ok=True)
        self.lock = writing(self.folder, self.out)
        if (self.folder / "newest.json").exists() and self.file.exists():
            raise CheckpointError(f"{self.out} has checkpoints of a run that was not finished: "
                                  f"continue with `smidgen run --resume {self.out}`, or remove {self.folder}")
        (self.folder / "newest.json").unlink(missing_ok=True)
        self.empty()
        sync_folder(self.folder.resolve().parent)
        self.put("run.json", meta)
        places = lay_out(self.file, arrays)
        self.sync()
        self.put("places.json", {name: place.offset for name, place in places.items()})
        return places

    def places(self, arrays: dict) -> dict:
        """Those of a run that goes on, whose file may have been about to become the result. Raises CheckpointError."""
        self.found(lambda: lay_out_again(self.file, self.folder / "fresh.h5", arrays, json.loads((self.folder / "places.json").read_text())))
        return self.found(lambda: standing(self.file, arrays))

    def sync(self) -> None:
        """All that has been written to the file is on the disk."""
        with open(self.file, "rb") as file:
            os.fsync(file.fileno())

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
        """Close the file, and give the lock back."""
        for handle in (self.handle, self.lock):
            if handle is not None:
                os.close(handle)
        self.handle = self.lock = None

    def abandon(self) -> None:
        """Leave no trace, unless there is a checkpoint."""
        if self.lock is not None and not (self.folder / "newest.json").exists():
            shutil.rmtree(self.folder, ignore_errors=True)

    def state(self, count: int) -> Path:
        """The saved state after `count` steps."""
        return self.folder / f"state-{count}.bin"

    def write_state(self, model) -> None:
        """This rank's part of a saved state, on the disk."""
        parts = model.save_parts()
        handle = os.open(self.state(model.count), os.O_WRONLY | os.O_CREAT, 0o666)
        try:
            for begin, numbers in parts:
                write_at(handle, numbers, begin * model.real.itemsize)
            os.fsync(handle)
        finally:
            os.close(handle)

    def finish(self, meta: dict, rows: int, columns, keep: bool) -> None:
        """Give the result its name; keep: a run with checkpoints may go on."""
        if keep:
            return
        finish(self.file, meta, rows, columns)
        self.sync()
        os.replace(self.file, self.out)
        sync_folder(self.out.resolve().parent)
        self.remove()

    def unfinished(self) -> bool:
        """Is there a run to go on with? What is left of a complete one is removed. Raises CheckpointError while another run writes there."""
        if self.is_left():
            self.lock = writing(self.folder, self.out)
            try:
                if self.is_left():
                    self.remove()
            finally:
                self.release()
        return self.folder.is_dir()

    def is_left(self) -> bool:
        """Does the folder hold nothing to go on with, beside a result?"""
        return self.folder.is_dir() and self.out.exists() and not self.file.exists()

    def remove(self) -> None:
        """The folder of a run whose result has its name."""
        self.empty()
        (self.folder / "lock").unlink(missing_ok=True)
        (self.folder / "newest.json").unlink(missing_ok=True)
        with contextlib.suppress(OSError):      # a network file system keeps the lock until it is closed
            self.folder.rmdir()

    def empty(self) -> None:
        """Remove all but the lock and what counts."""
        for path in self.folder.iterdir():
            if path.name not in ("lock", "newest.json"):
                path.unlink()


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
