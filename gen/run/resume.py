"""Going on with a run that was stopped: `smidgen.resume("result.h5")`."""
from __future__ import annotations

import dataclasses
import json
import os
import warnings
from collections.abc import Callable
from pathlib import Path

from .. import ranks
from ..build.binary import generator_name
from ..errors import UsageError
from ..public import public
from .files.checkpoint import CheckpointError, Folder, folder_of
from .files.output import Result, load_result
from .files.recorded import recorded
from .run import begun, describe, execute
from .settings import settle


@public
def resume(path: str | os.PathLike, *, keep: bool = False, progress: Callable[[int], object] | None = None,
           tell: Callable[[str], object] = warnings.warn) -> Result:
    """Continue the run that was writing `path` with checkpoints, and return its Result.

    The result is the same, bit for bit, as that of an uninterrupted run. If the run is complete its result is returned.

    :param keep: whether to keep the outputs in memory as well.
    :param progress: a function that is called with the number of steps done.
    :param tell: a function that is called with a message if the last checkpoint is damaged and the one before it is used.
    :raises CheckpointError: if there is no checkpoint, if it is damaged or was written by another version of smidgen or of the compiler,
        or if the run is still being written. The checkpoints are not changed.
    """
    if ranks.on_first(lambda: not folder_of(path).is_dir()):
        return ranks.on_first(lambda: _complete(path))
    folder = ranks.on_first(lambda: Folder.open(path), send=False)     # None on other ranks
    try:
        saved = ranks.on_first(lambda: folder.run() if folder.parts("run") else None)
        if saved is None:
            return ranks.on_first(lambda: _put_together(path, folder))
        model, settings = begun_again(*saved, path)
        return execute(model, settings, path, keep, progress, (folder, ranks.on_first(lambda: folder.newest(tell))))
    except OSError as problem:
        raise CheckpointError(f"cannot use {folder_of(path)}: {problem.strerror or problem}") from None
    finally:
        if folder:
            folder.release()


def _put_together(path, folder):
    """The result that was complete when its run was killed."""
    result = _complete(path)
    folder.finish()
    return result


def saved_run(path) -> dict:
    """The metadata of the run to go on with, or of the complete result. Raises CheckpointError."""
    folder = Folder(path)
    if folder.path.is_dir() and folder.parts("run"):
        return folder.run()[0]
    return _complete(path).meta


def begun_again(meta: dict, checkpoint: int | None, path):
    """(model at its start, settings) of a saved run, when this program is the one that began it."""
    if meta["generator"] != generator_name():
        raise CheckpointError(f"{path} was started by {meta['generator']}, but this is {generator_name()}: the bits would differ. Continue with that version, or remove {folder_of(path)} and start again")
    spec, name, given = recorded(meta)
    settings = settle(spec, name, **given, checkpoint=checkpoint)
    model = begun(spec, settings)
    now = json.loads(json.dumps(describe(model, settings)))
    differing = [key for key in meta if key not in ("status", "done") and now.get(key) != meta[key]]
    if differing:
        raise CheckpointError(f"{path} was started with different settings ({', '.join(differing)}): the bits would differ. "
                              f"Remove {folder_of(path)} to start again")
    return model, settings


def _complete(path):
    """The result `path`, if it is complete."""
    try:
        result = load_result(path)
    except UsageError:
        result = None
    if result is None or result.meta["status"] != "complete":
        raise CheckpointError(f"there is no checkpoint of {Path(path)}: to write checkpoints, use "
                              "`smidgen run SPEC --checkpoint 10000 --out result.h5`")
    return dataclasses.replace(result, summary={
        "t": result.meta["h"] * result.meta["done"], "errors": {}, "changes": {}, "seconds": 0.0,
        "in_parts": 0 if result.substeps is None else len(result.substeps)})
