"""A run repeated over values of parameters and over random starts: one cell each, in processes, into a folder.

The folder holds manifest.json, what is swept; cells.jsonl, one line for each cell that has ended, by whatever end; and cell-<number>.npz,
the result of each. The same call goes on with the cells that have no line.
"""
from __future__ import annotations

import contextlib
import itertools
import json
import os
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...build.binary import generator_name
from ...errors import OutputError, RunError, UsageError
from ...language import limits
from ...language.spec import Spec
from ...public import public
from ...read.shipped import SpecLike, spec_or_name
from ...system import locked
from . import cluster as workers
from .. import interrupts
from .cluster import check, executor, lost
from ..fields.field import Field
from ..files.checkpoint import Folder, folder_of
from ..files.durable import write_new
from ..files.plain import plain
from ..resume import resume
from ..run import Interrupted, run
from ..settings import model_of, settle, whole
from ..step.real import real_array
from ..step.start import state_at

MANIFEST, CELLS, FORMAT = "manifest.json", "cells.jsonl", 1


@dataclass(frozen=True)
class Cell:
    """One run of a sweep: its number, its values of the parameters that are swept, and the seed of its start (None: the run's)."""
    number: int
    parameters: dict
    seed: int | None

    def __str__(self) -> str:
        facts = [f"{name} = {value}" for name, value in self.parameters.items()] + ([] if self.seed is None else [f"seed {self.seed}"])
        return f"cell {self.number} ({', '.join(facts)})"

    @property
    def file(self) -> str:
        return f"cell-{self.number}.npz"


def cells_of(axes: Mapping[str, list], starts: int | None, seed: int | None) -> list[Cell]:
    """Every combination of the values; for each the seeds from `seed` on, or that one. Raises UsageError for none, or too many."""
    total = starts or 1
    for name, values in axes.items():
        if isinstance(values, (str, Mapping)) or not hasattr(values, "__getitem__") or getattr(values, "ndim", 1) == 0:
            raise UsageError(f"the axis '{name}' of a sweep must be a list of values, not {values!r}")
        total *= len(values)
    if not 1 <= total <= limits.CELLS:
        raise UsageError(f"a sweep must have from 1 to {limits.CELLS} cells, not {total}")
    seeds = [seed] if starts is None else range(seed, seed + starts)
    combined = itertools.product(*axes.values(), seeds)
    return [Cell(k, dict(zip(axes, parts)), parts[-1]) for k, parts in enumerate(combined)]


@public
@spec_or_name
def sweep(spec: SpecLike, run: str | None = None, *, out: str | os.PathLike, axes: Mapping[str, Sequence] | None = None, starts: int | None = None,
          start: str | np.ndarray | None = None, method: str | None = None, solver: str | None = None, h: float | str | None = None,
          steps: int | None = None, time: float | str | None = None, every: int | None = None, period: float | str | None = None,
          what: Iterable[str] | None = None, effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None,
          seed: int | None = None, real: str = "double", native: bool | None = None, substeps: bool | None = None,
          estimate: bool | None = False, tolerance: float | None = None, fast: bool = False, threads: int | None = None,
          processes: int | None = None, cluster: str | None = None, tell: Callable[[dict], object] = lambda outcome: None) -> list[dict]:
    """Repeat a run for all combinations of parameter values and random starts, the cells of the sweep.

    Arguments not listed here are as for `run`.

    :param out: the folder of the results. Cells that are already in it are not computed again.
    :param axes: the values of each parameter, by name.
    :param starts: the number of random starts for each combination, with seeds from `seed` on (None: 0).
    :param seed: the first of these seeds; without `starts`, the seed of all cells.
    :param processes: how many cells to compute at once.
    :param cluster: the address of a Dask scheduler, whose workers see `out` under the same path.
    :param tell: a function that is called with each outcome as it is completed.
    :returns: a dictionary for each cell: cell, parameters, seed, status, error, file. A cell that fails has an error; the others continue.
    :raises UsageError: for an argument that does not fit, or a folder that contains another sweep.
    :raises RunError: if a process was killed.
    :raises OutputError: if the folder cannot be written, or another sweep is writing to it.

    When interrupted, cells that are being computed are completed; a second interrupt ends their processes. Completed cells are kept in any
    case.
    """
    start = start if start is None or isinstance(start, (str, Field)) else real_array(start, float, "a state")
    given = dict(start=start, method=method, solver=solver, h=h, steps=steps, time=time, every=every, period=period, what=what, effects=effects,
                 parameters=dict(parameters or {}), real=real, native=native, substeps=substeps, estimate=estimate, tolerance=tolerance, fast=fast,
                 threads=threads)
    return swept(spec, run, dict(axes or {}), out, {word: value for word, value in given.items() if value is not None}, starts, seed, processes, cluster, tell)


def swept(spec: Spec, run: str | None, axes: dict, folder, given: dict, starts, seed, processes, cluster, tell) -> list[dict]:
    """The same; given: the choices of the run that are made."""
    if cluster is not None and processes is not None:
        raise UsageError("give either processes or cluster, not both")
    seed = whole(seed or 0, "a seed") if starts is not None or seed is not None else None
    cells, folder = cells_of(axes, None if starts is None else whole(starts, "starts"), seed), Path(folder).absolute()
    for values in ({name: values[k] for name, values in axes.items()} for k in (0, -1)):
        settled = settle(spec, run, **{**given, "parameters": {**given.get("parameters", {}), **values}})
    if isinstance(given.get("start"), Field):
        given = {**given, "start": settled.start}       # the vectors of a file, as the manifest has them
    if seed is not None:
        check_seed(settled.numbers, settled.start, seed)
    if cluster is not None:
        check(cluster)
    wanted = manifest(spec, run, axes, starts, seed, given)
    opened(folder, wanted)
    with alone(folder):
        ended = opened(folder, wanted)
        model_of(spec, settled)
        left = [cell for cell in cells if cell.number not in ended]
        if left:
            with interrupts.counted() as seen, executor(_processes(processes, len(left)), cluster) as found:
                computed(found, seen, spec, run, left, folder, given, ended, tell)
        tidy(folder)
    return [ended[cell.number] for cell in cells]


@contextlib.contextmanager
def alone(folder: Path):
    """Within, no other sweep writes to the folder: it would compute the same cells, and remove what this one has begun. Raises OutputError."""
    try:
        handle = locked(folder / MANIFEST, 0o666, wait=False)
    except OSError as problem:
        raise OutputError(f"cannot write the sweep {folder}: {problem.strerror}") from None
    if handle is None:
        raise OutputError(f"another sweep is writing to {folder}: wait until it has finished")
    try:
        yield
    finally:
        os.close(handle)


def check_seed(numbers, start, seed: int) -> None:
    """Raises UsageError where nothing is random."""
    if not isinstance(start, np.ndarray):
        state_at(numbers, start, seed)
    elif not numbers.spec.heated:
        raise UsageError("a seed was given, but the start is an array and no effect has kT")


def manifest(spec, name, axes, starts, seed, given) -> dict:
    """What decides the cells, as JSON has it."""
    facts = {"format": FORMAT, "generator": generator_name(), "spec": spec.name, "digest": spec.digest, "run": name, "axes": dict(axes), "starts": starts,
             "seed": seed, "choices": given}
    return json.loads(json.dumps(facts, default=plain))


def opened(folder: Path, wanted: dict) -> dict:
    """The outcomes that are in the folder, by number; a new folder gets its manifest."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / MANIFEST).exists():
            if any(folder.iterdir()):
                raise UsageError(f"{folder} is not empty and does not contain a sweep: use another folder")
            write_new(folder / MANIFEST, json.dumps(wanted, indent=1).encode())
        found, text = (folder / MANIFEST).read_text(errors="replace"), (folder / CELLS).read_text(errors="replace") if (folder / CELLS).exists() else ""
    except OSError as problem:
        raise OutputError(f"cannot write the sweep {folder}: {problem.strerror}") from None
    if parsed(found) != wanted:
        raise UsageError(f"{folder} contains a sweep with different settings or from another version: use another folder")
    lines = [parsed(line) for line in text.splitlines()]
    return {line["cell"]: line for line in lines if is_outcome(line) and (line["file"] is None or (folder / line["file"]).exists())}


def is_outcome(line) -> bool:
    """Is it what `computed` writes? Whatever else a line holds, its cell is computed again."""
    return (isinstance(line, dict) and type(line.get("cell")) is int and isinstance(line.get("status"), str)
            and line.get("file", 0) in (None, f"cell-{line['cell']}.npz"))


def parsed(text: str):
    """The JSON, or None: the last line of a sweep that was killed may be cut."""
    try:
        return json.loads(text)
    except ValueError:
        return None


def computed(found, seen, spec, name, cells, folder: Path, given, ended: dict, tell) -> None:
    """The outcomes of `cells` into `ended`, and a line each into the folder as they come."""
    waiting = []        # cells that are not taken

    def take(done) -> None:
        waiting.remove(done)
        if done.result() is None:       # of a cell that did not begin
            return
        outcome = there(done.result(), folder)
        lines.write(json.dumps(outcome).encode() + b"\n")
        lines.flush()
        os.fsync(lines.fileno())
        ended[outcome["cell"]] = outcome
        tell(outcome)

    try:
        with open(folder / CELLS, "a+b") as lines:
            if was_cut(lines):
                lines.write(b"\n")
            waiting += [found.pool.submit(one, spec, name, cell, folder, given, generator_name(), found.token) for cell in cells]
            try:
                for done in seen.completed(waiting):
                    take(done)
            except KeyboardInterrupt:
                ending(found, seen, [cell for cell in waiting if found.token or not cell.cancel()], take)
                raise
    except lost():
        raise RunError(f"a process of the sweep {folder}, or its cluster, was killed; the same command continues with the remaining cells (at most {len(cells)})", -1) from None
    except OSError as problem:
        raise OutputError(f"cannot write the sweep {folder}: {problem.strerror or problem}") from None
    finally:
        for cell in waiting:
            cell.cancel()


def was_cut(lines) -> bool:
    """Does a file of lines, open at its end, end within one?"""
    if not lines.tell():
        return False
    lines.seek(-1, os.SEEK_END)
    return lines.read(1) != b"\n"


def ending(found, seen, under_way: list, take) -> None:
    """No cell begins any more; those under way that come to their end are taken. A second interrupt ends their processes. What a cluster has
    taken can be cancelled while it is under way, and would be lost: its workers ask before they begin (`stopped`)."""
    found.stop()
    try:
        for done in seen.completed(under_way):
            if done.exception() is None:
                take(done)
    except KeyboardInterrupt:
        found.end()
        raise


def there(outcome: dict, folder: Path) -> dict:
    """The outcome, if its file is there. Raises OutputError: a worker of a cluster has another folder by the same name."""
    if outcome["file"] is not None and not (folder / outcome["file"]).exists():
        raise OutputError(f"{folder / outcome['file']} is not in this folder: all workers of the cluster must share one folder")
    return outcome


def tidy(folder: Path) -> None:
    """Remove what cells that were killed had begun to write; called when all of them have ended."""
    for work in folder.glob(".cell-*.npz-*"):
        shutil.rmtree(work, ignore_errors=True)


def one(spec, name, cell: Cell, folder: Path, given, generator: str, token: str = "") -> dict | None:
    """One cell, in a process of its own. What it cannot do is its outcome; what nobody could do is raised, and where smidgen is another one.
    None: the workers of a cluster have been told to begin no more."""
    if generator_name() != generator:
        raise UsageError(f"a worker of the cluster has another version of smidgen: {generator_name()} instead of {generator}")
    outcome = {"cell": cell.number, "parameters": {name: plain(value) for name, value in cell.parameters.items()}, "seed": cell.seed, "status": "complete", "error": None, "file": cell.file}
    with interrupts.raised():
        if workers.stopped(token):
            if token:
                return None
            raise KeyboardInterrupt
        try:
            to_its_end(spec, name, cell, folder / cell.file, given)
        except Interrupted:
            workers.stop()
            raise KeyboardInterrupt from None
        except (RunError, UsageError) as error:
            outcome |= {"status": "failed", "error": str(error), "file": cell.file if (folder / cell.file).exists() else None}
    return outcome


def to_its_end(spec, name, cell: Cell, out: Path, given) -> None:
    """The run of a cell; where its run makes checkpoints, and was killed, the rest of it."""
    if folder_of(out).is_dir() and Folder(out).parts("run"):
        resume(out)
    else:
        run(spec, name, out=out, keep=False, seed=cell.seed, **{**given, "parameters": {**given.get("parameters", {}), **cell.parameters}})


def _processes(processes, cells: int) -> int:
    if processes is None:
        processes = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if whole(processes, "processes") < 1:
        raise UsageError("processes must be at least 1")
    return min(int(processes), cells)
