"""Checkpoints: a run that is killed at any instant goes on from its last one, with the same bits.

`result.h5.checkpoint/` holds parts, HDF5 files that are written once and never changed:

    run-<digest>.h5             the metadata of the run, all that is needed to repeat it, and how often there is a checkpoint
    rows-<first>-<digest>.h5    rows of the columns from number `first` on
    state-<count>-<digest>.h5   the saved state after `count` steps, the rows that belong to it
    lock                        held by the run that writes

A part gets its name when it is on the disk (`durable.py`), and the name holds the sha256 of the
bytes. The rows come before the state that counts on them; older states but one are removed.
HDF5 itself is no help against a kill: a file that was open for writing may be lost as a whole.
"""
from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import OutputError
from ...packages import needed
from ...system import locked, sync_folder
from .durable import write_new
from .output import put_text
from .kinds import count, either, finite_or_not, listed, none, number, table, triple
from .received import Wrong, checked, opened, parsed, refusing, sets_of

FORMAT = 1          # of the parts; another one is refused
STATES = 2          # kept: when the last one is damaged, the one before serves
DIGEST = 32         # hexadecimal digits of a digest in a name
FACTS = {           # kind of a part -> is this what it says of itself?
    "run": lambda facts: "format" in facts and either(none, count)(facts.get("checkpoint")),
    "rows": lambda facts: True,
    "state": lambda facts: (count(facts.get("count")) and count(facts.get("rows")) and number(facts.get("seconds"))
                            and count(facts.get("outputs")) and table(table(finite_or_not))(facts.get("largest"))
                            and listed(triple)(facts.get("substeps")) and either(none, triple)(facts.get("nearest"))),
}
NEEDED = {"run": set(), "rows": {"t"}, "state": {"state"}}


class CheckpointError(OutputError):
    """A run cannot be continued: there is no checkpoint, it is damaged or comes from another version of smidgen, or the run is still being
    written. The checkpoints are not changed.
    """


def folder_of(out) -> Path:
    """Where the checkpoints of the result `out` lie."""
    return Path(f"{out}.checkpoint")


@dataclass(frozen=True)
class Part:
    """A part by its name: kind run, rows or state; number: its first row or its step."""
    path: Path
    kind: str
    number: int
    digest: str

    @classmethod
    def of(cls, path: Path) -> "Part | None":
        """Read the name, None when it is no part's."""
        words = path.stem.split("-")
        if path.suffix != ".h5" or len(words) != 3 or words[0] not in FACTS or not re.fullmatch("[0-9]{18}", words[1]):
            return None
        return cls(path, words[0], int(words[1]), words[2])

    def read(self) -> tuple[dict, dict]:
        """(facts, arrays). Raises CheckpointError when a byte is not as it was written."""
        with refusing(self.path, CheckpointError), opened(self.path, CheckpointError) as file:
            data = file.read()
            if digest_of(data) != self.digest:
                raise CheckpointError(f"{self.path} is damaged: its contents have changed")
            facts, arrays = unpacked(data)
            if not FACTS[self.kind](facts) or not NEEDED[self.kind] <= set(arrays) or any(a.ndim == 0 for a in arrays.values()):
                raise Wrong("it is not a part of a checkpoint")
            return facts, arrays


def packed(facts: dict, arrays: dict) -> bytes:
    """An HDF5 file as bytes."""
    h5py = needed("h5py", "a checkpoint")
    image = io.BytesIO()
    with h5py.File(image, "w") as h5:
        put_text(h5, "facts", json.dumps(facts))
        for name, rows in arrays.items():
            h5.create_dataset(f"arrays/{name}", data=rows)
    return image.getvalue()


def unpacked(data: bytes) -> tuple[dict, dict]:
    """(facts, arrays) of what `packed` made. Raises received.Wrong, and what HDF5 raises."""
    h5py = needed("h5py", "a checkpoint")
    with h5py.File(io.BytesIO(data), "r") as h5:
        link = h5.get("arrays", getlink=True)
        group = h5["arrays"] if isinstance(link, h5py.HardLink) else {}
        facts, arrays = sets_of(h5, group, "facts", len(data))
        return parsed(facts, lambda value: isinstance(value, dict)), arrays


def digest_of(data: bytes) -> str:
    """Of the bytes of a part, as its name has it."""
    return hashlib.sha256(data).hexdigest()[:DIGEST]


def writing(folder: Path, out: Path) -> int:
    """The handle of the lock in `folder` that the run has which writes `out`: one at a time; the kernel frees the lock of one that dies.

    Raises CheckpointError where another run has it.
    """
    place = folder / "lock"
    try:
        handle = locked(place, 0o666, wait=False)
    except OSError as problem:
        raise CheckpointError(f"cannot use {place}: {problem.strerror}") from None
    if handle is None:
        raise CheckpointError(f"another run is writing {out}: wait until it has finished")
    return handle


class Folder:
    """The parts of one result. Holds the lock from `begin` or `open` to `release`."""

    def __init__(self, out):
        self.out, self.path, self.handle = Path(out), folder_of(out), None

    @classmethod
    def begin(cls, out, meta: dict, checkpoint: int) -> "Folder":
        """A folder for a new run, with a checkpoint every so many steps. Raises CheckpointError when one that was not finished is there."""
        folder = cls(out)
        folder.path.mkdir(exist_ok=True)
        sync_folder(folder.path.parent)
        folder.lock()
        try:
            folder.refuse_unfinished()
            folder.clear()
            folder.put("run", 0, {"format": FORMAT, "meta": meta, "checkpoint": checkpoint}, {})
        except BaseException:
            folder.give_up()
            raise
        return folder

    @classmethod
    def open(cls, out) -> "Folder":
        """The folder of a run to go on with. Raises CheckpointError."""
        folder = cls(out)
        if not folder.path.is_dir():
            raise CheckpointError(f"there is no checkpoint of {out}: {folder.path} does not exist")
        folder.lock()
        return folder

    def lock(self) -> None:
        self.handle = writing(self.path, self.out)

    def release(self) -> None:
        """Give the lock back."""
        if self.handle is not None:
            os.close(self.handle)
        self.handle = None

    def give_up(self) -> None:
        """Leave no trace of a run that could not begin."""
        with contextlib.suppress(OSError):
            if not self.parts("run"):
                return self.finish()
        self.release()

    def refuse_unfinished(self) -> None:
        """Saved work is never thrown away for a new run."""
        if self.parts("run"):
            done = max((part.number for part in self.parts("state")), default=0)
            raise CheckpointError(
                f"{self.path} contains an unfinished run ({done} steps are saved): continue it with `smidgen run --resume {self.out}`, or remove the folder")

    def parts(self, kind: str) -> list[Part]:
        """Those of one kind, by number."""
        found = (Part.of(path) for path in self.path.iterdir())
        return sorted((p for p in found if p and p.kind == kind), key=lambda p: p.number)

    def put(self, kind: str, number: int, facts: dict, arrays: dict) -> None:
        """Write a part. Raises OSError. The names of rows reach the disk with that of the next state."""
        data = packed(facts, arrays)
        write_new(self.path / f"{kind}-{number:018d}-{digest_of(data)}.h5", data, name_too=kind != "rows")

    def run(self) -> tuple[dict, int | None]:
        """The metadata of the run, and its steps between checkpoints. Raises CheckpointError."""
        parts = self.parts("run")
        if not parts:
            raise CheckpointError(f"there is no checkpoint of {self.out}: {self.path} does not contain a run")
        facts, _ = parts[0].read()
        if facts["format"] != FORMAT:
            raise CheckpointError(f"{self.path} was written by another version of smidgen")
        with refusing(parts[0].path, CheckpointError):
            return checked(facts.get("meta")), facts.get("checkpoint")

    def good_rows(self) -> tuple[int, CheckpointError | None]:
        """(how many rows are there from the first on, what is wrong with the next part)."""
        total = 0
        for part in self.parts("rows"):
            if part.number != total:
                return total, CheckpointError(f"{self.path}: the part with row {total} is missing")
            try:
                total += len(part.read()[1]["t"])
            except CheckpointError as damage:
                return total, damage
        return total, None

    def newest(self, tell):
        """(facts, arrays) of the last state that is whole with all its rows; None before any was
        saved. tell: is told what is damaged. Raises CheckpointError when no state is left."""
        rows, damage = self.good_rows()
        states = self.parts("state")
        for part in reversed(states):
            try:
                facts, arrays = part.read()
                if facts["rows"] <= rows:
                    return facts, arrays
            except CheckpointError as problem:
                damage = problem
            tell(f"{damage}; going back from step {part.number}")
        if states:
            raise CheckpointError(f"{damage}; there is no earlier state. To start again, remove {self.path}")
        return None

    def forget_after(self, rows: int) -> None:
        """Remove what was not finished: rows that no state counts on, parts without their name."""
        for part in self.parts("rows"):
            if part.number >= rows:
                part.path.unlink()
        for path in self.path.iterdir():
            if path.name != "lock" and not Part.of(path):
                _remove(path)

    def keep_states(self, count: int) -> None:
        """Remove states that newer ones replace: those after `count`, and all but the last."""
        states = self.parts("state")
        good = [part for part in states if part.number <= count]
        for part in [p for p in states if p.number > count] + good[:-STATES]:
            part.path.unlink()

    def clear(self) -> None:
        """Remove all but the lock; the run first, for without it nothing counts as saved."""
        for part in self.parts("run"):
            part.path.unlink()
        sync_folder(self.path)
        for path in self.path.iterdir():
            if path.name != "lock":
                _remove(path)

    def finish(self) -> None:
        """The result is complete: the folder goes."""
        self.clear()
        (self.path / "lock").unlink()
        with contextlib.suppress(OSError):      # the next run is there already
            self.path.rmdir()
        self.release()


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink()


def refuse_unfinished(out) -> None:
    """Raise CheckpointError when checkpoints of an unfinished run lie beside `out`."""
    folder = Folder(out)
    if folder.path.is_dir():
        folder.refuse_unfinished()


def batches(chunks, size: int):
    """The rows of `chunks` in pieces of `size`; the last is shorter, and may be empty."""
    held = None
    for chunk in chunks:
        held = chunk if held is None else {n: np.concatenate([held[n], chunk[n]]) for n in held}
        while len(held["t"]) >= size:
            yield {n: rows[:size] for n, rows in held.items()}
            held = {n: rows[size:] for n, rows in held.items()}
    if held is not None:
        yield held
