"""A result from elsewhere: read within limits, and checked before anything is made of it.

Neither its bytes nor its metadata are trusted. A file is a regular one, and no array is taken for
more than the bytes that the file has: what is compressed, linked or filled in by the reader is
refused, for no result of smidgen holds any. `META` says what the metadata must be.
"""
from __future__ import annotations

import io
import json
import math
import os
import stat
import warnings
import zipfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from ...errors import MissingTool, UsageError
from ...language import limits
from ...packages import needed
from ...renamed import up_to_date
from ...system import BYTES, NO_WAIT
from .kinds import VALUE, count, either, flag, listed, finite_or_not, none, number, source, table, text
from .options import ALWAYS, OPTIONS

AXES = "xyz"
VECTORS = ("momentum.", "magnetisation.")      # columns of three numbers
COUNTED, LETTER = np.dtype(np.int32), np.dtype("S1")      # what the axes of an HDF5 file count with; no column is of these types


class Wrong(Exception):
    """What is wrong with a file; the message says it."""


def read(path) -> tuple[dict, dict]:
    """(metadata, columns: name -> array) of a .csv, .npz or .h5 that a run wrote. Raises UsageError."""
    with refusing(path), opened(path) as file:
        meta, columns = READERS[Path(path).suffix](file, os.fstat(file.fileno()).st_size)
        meta = checked(meta)
        fit(meta, columns)
        return meta, columns


@contextmanager
def refusing(path, kind=UsageError):
    """Whatever goes wrong with a file becomes one error: what HDF5, zip and numpy raise has no list."""
    try:
        yield
    except (kind, MissingTool):
        raise
    except Wrong as problem:
        raise kind(f"{path} is not a file of a smidgen run: {problem}") from None
    except MemoryError:
        raise kind(f"{path}: there is not enough memory to read it") from None
    except Exception:
        raise kind(f"{path} is not a file of a smidgen run, or it is damaged") from None


@contextmanager
def opened(path, kind=UsageError):
    """The regular file `path`: a pipe is not waited for, a device not read."""
    try:
        handle = os.open(path, os.O_RDONLY | NO_WAIT | BYTES)
    except (OSError, ValueError) as problem:
        raise kind(f"cannot read {path}: {getattr(problem, 'strerror', None) or problem}") from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise kind(f"cannot read {path}: it is not a regular file")
    with open(handle, "rb") as file:
        yield file


# -- the three formats --------------------------------------------------------------------------

def from_csv(file, size):
    comments, header = head_of(file)
    names = header.strip().split(",")
    if len(names) > limits.CSV_COLUMNS:
        raise Wrong(f"more than {limits.CSV_COLUMNS} columns")
    real = np.longdouble if real_of(comments) == "long double" else float
    table = rows_of(file, real) if file.tell() < size else np.empty((0, len(names)), real)
    if table.shape[1] != len(names):
        raise Wrong("its rows do not match its header")
    columns = gathered(table, names)
    columns["step"] = integers(columns.get("step"))
    if "t" in columns:
        columns["t"] = columns["t"].astype(float)
    for name in comments.keys() - {"meta"}:
        given = parsed(comments[name], listed(finite_or_not))
        columns[name] = np.array(given if real is float else comments[name].strip("[] ").split(",") * bool(given), real).reshape(-1, 3)
    return comments.get("meta", ""), columns


def head_of(file):
    """The comments that the reader needs, and the header."""
    found, line = {}, file.readline()
    while line.startswith(b"# "):
        key, _, value = line[2:].partition(b": ")
        if key in (b"meta", b"final", b"substeps"):
            found[key.decode()] = value.decode().rstrip("\n")
        line = file.readline()
    return found, line.decode()


def real_of(comments):
    """What the metadata say of the precision of the numbers."""
    found = parsed(comments.get("meta", ""), lambda value: True)
    return found.get("real") if isinstance(found, dict) else None


def rows_of(file, real=float):
    """The numbers of the lines that are left."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")          # numpy's "no data"
        return np.loadtxt(file, real, delimiter=",", ndmin=2, encoding="ascii")


def integers(column):
    """A column of whole numbers."""
    if column is None or column.ndim != 1 or not np.all(np.abs(column) < 2.0 ** 63) or np.any(column != np.rint(column)):
        raise Wrong("the steps are not integers")
    return column.astype(np.int64)


def gathered(table, names) -> dict:
    """Columns w[0].x, w[0].y, ... as arrays again."""
    places = {}
    for place, name in enumerate(names):
        stem = name.partition("[")[0]
        places.setdefault(stem[:-2] if name.startswith(VECTORS) else stem, []).append(place)
    columns = {}
    for name, at in places.items():
        block = table[:, at] if len(at) > 1 or "[" in names[at[0]] else table[:, at[0]]
        columns[name] = block.reshape(len(table), -1, 3) if "]." in names[at[0]] else block
    return columns


def from_npz(file, size):
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        if any(m.compress_type != zipfile.ZIP_STORED or m.flag_bits & 1 for m in members):
            raise Wrong("its arrays are compressed or encrypted")
        within([m.file_size for m in members], size)
        columns = {m.filename.removesuffix(".npy"): from_npy(archive.read(m)) for m in members}
    meta = columns.pop("meta", None)
    if meta is None or meta.dtype.kind != "U" or meta.shape != ():
        raise Wrong("it has no metadata")
    return str(meta), columns


def from_npy(data: bytes):
    """The array of a .npy image; its head must promise what follows, no less and no more."""
    head = io.BytesIO(data)
    version = np.lib.format.read_magic(head)
    read_head = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran, kind = read_head(head)
    at = head.tell()
    if fortran or kind.hasobject or math.prod(shape) * kind.itemsize != len(data) - at:
        raise Wrong("an array does not match its header")
    return np.frombuffer(bytearray(data[at:]), kind).reshape(shape)


def from_h5(file, size):
    h5py = needed("h5py", "HDF5")
    with h5py.File(file, "r") as h5:
        return sets_of(h5, h5, "meta", size)


def sets_of(h5, group, key, size):
    """(the text `key` of an open file, the arrays of one of its groups)."""
    head = plain_set(h5, key, size) if key in h5 else None
    if head is None or head.shape != () or head.dtype.kind != "S":      # of fixed length: see output.put_text
        raise Wrong("it has no metadata, or was written by an earlier version")
    found = {name: plain_set(group, name, size) for name in group if name != key}
    found = {name: s for name, s in found.items() if s.dtype not in (COUNTED, LETTER)}
    within([s.size * s.dtype.itemsize for s in (head, *found.values())], size)
    if any(s.dtype.kind not in "fiu" for s in found.values()):
        raise Wrong("it contains something other than numbers")
    return head[()].decode(), {name: s[...] for name, s in found.items()}


def plain_set(group, name, size):
    """A data set that lies in the file itself: no link, no filter, no other file, not compiled from others."""
    h5py = needed("h5py", "HDF5")
    link = group.get(name, getlink=True)
    found = group[name] if isinstance(link, h5py.HardLink) else None
    if not isinstance(found, h5py.Dataset) or found.is_virtual or found.external or found.shape is None:
        raise Wrong("it contains something other than data sets")
    if found.id.get_create_plist().get_nfilters():
        raise Wrong("its data sets are compressed")
    if found.chunks and found.size:
        within([math.prod(found.chunks) * found.dtype.itemsize], size)
    return found


def within(sizes, size):
    """No more bytes are promised than the file has."""
    if sum(sizes) > size:
        raise Wrong(f"its header implies {sum(sizes)} bytes, but it has {size}")


READERS = {".csv": from_csv, ".npz": from_npz, ".h5": from_h5}


# -- the metadata -------------------------------------------------------------------------------

META = {    # what `run.describe` writes
    "program": text, "version": text, "generator": text, "spec": text, "title": text, "digest": text,
    "sources": listed(source), "orientation": lambda value: flag(value) or value == -1, "run": text,
    **{option.key: option.kind for option in OPTIONS if option.kind}, "end_error": either(none, number), "end_error_withheld": either(none, text),
    "means": either(none, table(table(lambda value: True))), "parameters": table(VALUE), "chosen": table(either(none, VALUE)), "families": table(count),
    "units": either(none, table(either(text, table(text)))), "compiler": text, "flags": listed(text), "status": text, "done": count,
}
# keys that files of earlier versions lack, and what they meant
ADDED = {**{option.key: option.older for option in OPTIONS if option.older is not ALWAYS}, "end_error": None, "end_error_withheld": None, "means": None, "units": None}


def parsed(given: str, kind):
    """JSON of the right kind. Raises Wrong."""
    if len(given) > limits.META:
        raise Wrong(f"its metadata has {len(given)} characters; at most {limits.META} are read")
    try:
        value = json.loads(given)
    except (ValueError, RecursionError):
        raise Wrong("its metadata is not JSON, or nested too deeply") from None
    if not kind(value):
        raise Wrong("its metadata or its state is invalid")
    return value


def checked(given) -> dict:
    """The metadata: text of JSON, or what it says, with every key of META and no other."""
    meta = parsed(given, lambda value: True) if isinstance(given, str) else given
    if not isinstance(meta, dict):
        raise Wrong("its metadata is not a table")
    meta = {**ADDED, **up_to_date(meta)}
    wrong = [key for key, kind in META.items() if key not in meta or not kind(meta[key])]
    if wrong:
        raise Wrong(f"'{wrong[0]}' is missing from its metadata, or invalid")
    return {key: meta[key] for key in meta if key in META}


# -- what belongs to what -----------------------------------------------------------------------

def fit(meta: dict, columns: dict) -> None:
    """Columns of k numbers or rows of numbers, states of k x count x 3. Raises Wrong."""
    rows = columns["t"].shape if "t" in columns else ()
    if len(rows) != 1 or "step" not in columns or "final" not in columns:
        raise Wrong("the columns step and t or the last state are missing")
    for name, column in columns.items():
        if column.dtype.kind not in "fiu" or not shaped(name, column.shape, rows, meta["families"]):
            raise Wrong("the length of a column differs from that of the others")


def shaped(name, shape, rows, families) -> bool:
    """Has the column `name` the shape that it must have, where there are `rows` outputs?"""
    if name in ("final", "positions"):
        return shape == (sum(families.values()), 3)
    if name == "substeps":
        return len(shape) == 2 and shape[1] == 3
    if name in ("step", "t"):
        return shape == rows
    if name in families:
        return shape == (*rows, families[name], 3)
    return shape[:1] == rows and len(shape) <= 2
