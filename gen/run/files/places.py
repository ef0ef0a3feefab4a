"""An HDF5 file whose arrays have their places from the beginning.

Several processes write their parts of them at once, without HDF5.
"""
from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...packages import needed
from .labels import label
from .output import put_text

BLOCK = 1 << 20         # entries that are copied at a time


@dataclass(frozen=True)
class Place:
    """offset: where an array begins in its file; shape, kind: of the whole."""
    offset: int
    shape: tuple
    kind: np.dtype

    def row(self, k: int) -> int:
        """Where its k-th entry begins."""
        return self.offset + k * self.kind.itemsize * int(np.prod(self.shape[1:], dtype=np.int64))


def lay_out(path: Path, arrays: dict) -> dict:
    """Create the file; name -> Place. arrays: name -> (shape, dtype), none of them empty."""
    h5py = needed("h5py", "HDF5")
    with h5py.File(path, "w") as h5:
        found = {name: Place(contiguous(h5, name, shape, kind), shape, kind) for name, (shape, kind) in arrays.items()}
    end = max(place.row(place.shape[0]) for place in found.values())
    os.truncate(path, max(end, path.stat().st_size))
    return found


def standing(path: Path, arrays: dict) -> dict:
    """name -> Place in a file of `lay_out`. Raises OSError or ValueError where it is not that of these arrays."""
    h5py = needed("h5py", "HDF5")
    with h5py.File(path, "r") as h5:
        found = {name: h5[name] if name in h5 else None for name in arrays}
        if not all(isinstance(one, h5py.Dataset) and (one.shape, one.dtype) == arrays[name] and one.id.get_offset() is not None for name, one in found.items()):
            raise ValueError("other arrays")
        return {name: Place(one.id.get_offset(), *arrays[name]) for name, one in found.items()}


def contiguous(h5, name: str, shape, kind) -> int:
    """A data set in one piece, not filled; where it begins."""
    h5py = needed("h5py", "HDF5")
    how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    how.set_layout(h5py.h5d.CONTIGUOUS)
    how.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    how.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    how.set_obj_track_times(False)
    one = h5py.h5d.create(h5.id, name.encode(), h5py.h5t.py_create(kind), h5py.h5s.create_simple(shape), how)
    return one.get_offset()


def write_at(handle: int, rows: np.ndarray, offset: int) -> None:
    """All bytes of an array, from a place of an open file on."""
    left = memoryview(np.ascontiguousarray(rows)).cast("B") if rows.size else memoryview(b"")
    while len(left):
        done = os.pwrite(handle, left, offset)
        left, offset = left[done:], offset + done


def lay_out_again(path: Path, fresh: Path, arrays: dict, offsets: dict) -> None:
    """All bytes of a file outside its arrays as `lay_out` made them, whatever became of them since; fresh: a file to make and remove;
    offsets: name -> where an array began then.

    Raises ValueError where this HDF5 lays arrays out in another way, or the file is too short for them.
    """
    places = lay_out(fresh, arrays)
    size = fresh.stat().st_size
    if path.stat().st_size < size or {name: place.offset for name, place in places.items()} != offsets:
        raise ValueError("another file")
    with open(fresh, "rb") as laid, open(path, "r+b") as file:
        for begin, end in between(places.values(), size):
            file.seek(laid.seek(begin))
            file.write(laid.read(end - begin))
        file.truncate(size)
    fresh.unlink()


def between(places, size: int):
    """(begin, end) of each piece of a file that belongs to no array."""
    begin = 0
    for place in sorted(places, key=lambda place: place.offset):
        yield begin, place.offset
        begin = place.row(place.shape[0])
    yield begin, size


def finish(path: Path, meta: dict, rows: int, columns) -> None:
    """With metadata and axes, as other files of runs have them; of columns the first `rows` entries.

    Nothing is written where the arrays were before the file is complete: a run that is killed here finds them there.
    """
    h5py = needed("h5py", "HDF5")
    with h5py.File(path, "r+") as h5:
        longer = [shorten(h5, name, rows) for name in columns if len(h5[name]) > rows]
        label(h5, meta["families"])
        for name, unit in (meta.get("units") or {}).get("columns", {}).items():
            h5[name].attrs["units"] = unit
        put_text(h5, "meta", json.dumps(meta))
    with h5py.File(path, "r+") as h5:
        for name in longer:
            del h5[name]


def shorten(h5, name: str, rows: int) -> str:
    """Of a run that ended early: the entries that there are; the name of the array that has all."""
    longer = f"{name}, longer"
    h5.move(name, longer)
    old = h5[longer]
    new = h5.create_dataset(name, (rows, *old.shape[1:]), old.dtype)
    for k in range(rows):
        if old.ndim == 1:
            new[k] = old[k]
        else:
            for first in range(0, old.shape[1], BLOCK):
                new[k, first:first + BLOCK] = old[k, first:first + BLOCK]
    return longer
