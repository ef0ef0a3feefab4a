"""Results and their files: .csv, .npz and .h5, written as the run goes.

All three hold the same columns under the spec's own names: `step`, `t`, each family (shape
(count, 3)), `energy`, `energy.<effect>`, `momentum.<family>` (3), `casimirs` (one a site),
observables; and `meta`, JSON with all that is needed to repeat the run. A file appears
under its name when it is complete: until then an earlier one stays as it was.
"""
from __future__ import annotations

import io
import json
import os
import shutil
import tempfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from ...errors import ColumnError, OutputError, UsageError
from ...language import limits
from ...packages import needed
from ...public import ReadOnly, few, guess, public
from ...system import sync_folder
from .conversion import dataframe, dataset
from .durable import check_place
from .labels import flat_names, label
from .received import read

FORMATS = (".csv", ".npz", ".h5")
RESERVED = ("step", "t", "meta", "final", "substeps", "positions", "energy", "casimirs")


@dataclass(repr=False)
class Result(ReadOnly):
    """The result of a run with k outputs, in the units of the spec.

    :ivar t: the times of the outputs, shape (k,). `step`: the numbers of their steps.
    :ivar w: the states of each family, a dictionary of arrays of shape (k, count, 3); None if they were not requested.
    :ivar values: energies, momenta, Casimirs and observables by name, shape (k,) or (k, m).
    :ivar final: the last state, shape (sites, 3), after meta["done"] steps.
    :ivar positions: the positions of the sites, shape (sites, 3); None if the spec does not give any, or if the file is a .csv.
    :ivar substeps: rows step, t, k of the steps that were replaced by 2^k smaller ones; None if that was not requested.
    :ivar summary: the last time; the largest changes, over the outputs, of conserved quantities (`errors`) and of others (`changes`); the
        seconds spent on stepping and writing.
    :ivar meta: everything else about the run: the text of the spec, parameters, method, versions.

    `result["energy"]` returns an output by its name in files. A notebook shows a picture.
    """
    INSTEAD = {"": "compute another result with smidgen.run(spec, ...)"}
    _shows: ClassVar[object | None] = None       # the stage that draws puts in what notebooks show of a result
    meta: dict
    step: np.ndarray
    t: np.ndarray
    w: dict | None
    values: dict
    final: np.ndarray | None = None
    substeps: np.ndarray | None = None
    positions: np.ndarray | None = None
    summary: dict = field(default_factory=dict)

    def __repr__(self) -> str:
        said = " ".join(str(self.meta.get(word) or "") for word in ("spec", "run")).strip()
        over = f" over t = {self.t[0]:.6g} .. {self.t[-1]:.6g}" if len(self.t) else ""
        return (f"<Result {said}: {self.meta.get('method')}, {self.meta.get('status')}, {len(self.t)} outputs{over}: "
                f"{few([*(self.w or {}), *self.values]) or 'no outputs'}>")

    def keys(self) -> list[str]:
        """The names that `result[name]` accepts."""
        return ["step", "t", *(self.w or {}), *self.values]

    def __iter__(self):
        return iter(self.keys())

    def __getitem__(self, name: str) -> np.ndarray:
        """A column by its name in files: `result["energy"]` (k,), `result["momentum.w"]` (k, 3), `result["w"]` (k, count, 3), `result["t"]` (k,).

        Raises ColumnError, a KeyError.
        """
        columns = {"step": self.step, "t": self.t, **(self.w or {}), **self.values}
        if not isinstance(name, str) or name not in columns:
            raise ColumnError(f"a result of {self.meta.get('spec')} has no column '{name}'{guess(str(name), list(columns), {})}")
        return columns[name]

    def to_xarray(self):
        """The outputs as an xarray.Dataset over `t`, `site` and `component`, with `final` over the last two; metadata are attributes.

        With several families each has its own axis, `site_NAME`, and `site` runs over the sites of all families. `.to_netcdf(path)` writes
        the data set.

        :raises MissingTool: if xarray is not installed.
        """
        return dataset(self)

    def to_dataframe(self):
        """The outputs as a pandas.DataFrame indexed by t, with the columns of a .csv file (`energy`, `momentum.w.x`, `w[3].x`).

        :raises MissingTool: if pandas is not installed.
        """
        return dataframe(self)

    def plot(self, kind: str = "auto"):
        """A picture for a notebook; no file is written.

        :param kind: one of `smidgen.show.plot.kinds()`; "auto" chooses a suitable one.
        :raises UsageError: if the result does not contain what this kind shows.
        :raises MissingTool: if matplotlib is not installed.
        """
        return self._shows.plot(self, kind)

    def play(self):
        """The player for a notebook; no file is written. The errors are those of `plot`."""
        return self._shows.play(self)

    def _repr_html_(self) -> str:
        """For notebooks: what ran, and a picture."""
        return self._shows.html(self)


@public
def load_result(path: str | os.PathLike) -> Result:
    """Read a file that a run wrote.

    :raises UsageError: if the file is not a result or is damaged.
    """
    known_format(path)
    return result_of(*read(path))


def result_of(meta: dict, columns: dict, summary: dict | None = None) -> Result:
    """Sort `columns` (name -> array) into a Result."""
    columns = dict(columns)
    step, t, final = columns.pop("step"), columns.pop("t"), columns.pop("final", None)
    substeps = columns.pop("substeps", None)
    states = {f: columns.pop(f) for f in meta["families"] if f in columns}
    positions = columns.pop("positions", None)
    return Result(meta, step, t, states or None, columns, final, substeps, positions, summary or {})


def known_format(path) -> str:
    """The suffix of `path`, if it names a format."""
    suffix = Path(path).suffix
    if suffix not in FORMATS:
        raise UsageError(f"{path}: the name of a result must end in {', '.join(FORMATS)}")
    return suffix


def open_sink(path, meta: dict, layout: dict, work=None):
    """A sink for the file `path`; layout: column -> (shape of one entry, dtype).

    work: the folder for what is not complete, by default that of `path`.
    """
    return _SINKS[known_format(path)](Path(path), meta, layout, work)


def check_layout(path, layout: dict) -> None:
    """Raise OutputError when no file can have the name `path`, or its format cannot hold these columns."""
    check_place(Path(path))
    count = sum(int(np.prod(shape, dtype=int)) for shape, _ in layout.values())
    if known_format(path) == ".csv" and count > limits.CSV_COLUMNS:
        raise OutputError(f"cannot write {path}: a .csv cannot have {count} columns; use .h5 or .npz")


class MemorySink:
    """Keeps everything; `columns` afterwards."""

    def __init__(self, layout: dict):
        self.layout, self.parts = layout, {name: [] for name in layout}

    def write(self, chunk: dict) -> None:
        """Append k entries to each column."""
        for name, rows in chunk.items():
            self.parts[name].append(rows.copy())

    @property
    def columns(self) -> dict:
        return {name: np.concatenate(self.parts[name] or [np.empty((0, *shape), kind)])
                for name, (shape, kind) in self.layout.items()}


class FileSink:
    """Writes beside `path` and renames at the end; every failure is an OutputError."""

    def __init__(self, path: Path, meta: dict, layout: dict, work=None):
        self.path, self.meta, self.layout = path, meta, layout
        check_layout(path, layout)
        with self._guard():
            self.work = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=work or path.parent))
            self.file = self.work / path.name
            self._begin()

    def write(self, chunk: dict) -> None:
        """Append k entries to each column. Raises OutputError."""
        with self._guard():
            self._append(chunk)

    def close(self, meta: dict, extras: dict) -> None:
        """Finish with the final metadata and the arrays `extras` that are no columns (final,
        substeps); the file gets its name here, when all of it is on the disk."""
        with self._guard():
            self._finish(meta, extras)
            with open(self.file, "rb") as done:
                os.fsync(done.fileno())
            os.replace(self.file, self.path)
            sync_folder(self.path.parent)
        shutil.rmtree(self.work, ignore_errors=True)

    def abandon(self) -> None:
        """Leave no trace; a file of that name from before stays."""
        try:
            self._release()
        except (OSError, RuntimeError, ValueError):
            pass                                # its content is thrown away anyway
        shutil.rmtree(getattr(self, "work", ""), ignore_errors=True)

    def _release(self):
        pass

    def _guard(self):
        return _Guard(self)


class _Guard:
    """Turns what goes wrong while writing into an OutputError, and cleans up."""

    def __init__(self, sink):
        self.sink = sink

    def __enter__(self):
        return self

    def __exit__(self, kind, problem, trace):
        if kind is None or not issubclass(kind, (OSError, RuntimeError, ValueError)):
            return False
        self.sink.abandon()
        said = getattr(problem, "strerror", None) or problem
        raise OutputError(f"cannot write {self.sink.path}: {said}") from None


class CsvSink(FileSink):
    """Text: comment lines with the metadata, a header, one line an output."""
    body = None

    def _begin(self):
        names = [n for name in self.layout for n in flat_names(name, self.layout[name][0])]
        self.names, self.body = names, open(self.work / "body", "w", encoding="ascii")
        self.long = any(extended(kind) for _, kind in self.layout.values())
        self.formats = ["%d"] + ["%s" if self.long else "%.17g"] * (len(names) - 1)

    def _append(self, chunk):
        rows = [np.asarray(chunk[n]).reshape(len(chunk["t"]), int(np.prod(shape))) for n, (shape, _) in self.layout.items()]
        table = np.concatenate(rows, axis=1)
        np.savetxt(self.body, written(table) if self.long else table, self.formats, delimiter=",")

    def _finish(self, meta, extras):
        self.body.close()
        with open(self.file, "wb") as out, open(self.work / "body", "rb") as body:
            out.write(csv_head(meta, extras, self.names).encode())
            shutil.copyfileobj(body, out)

    def _release(self):
        if self.body:
            self.body.close()


class NpzSink(FileSink):
    """numpy's format; columns grow in raw files until their length is known."""
    raw = {}

    def _begin(self):
        self.rows, self.raw = 0, {}
        for number, name in enumerate(self.layout):
            self.raw[name] = open(self.work / f"column{number}", "wb")

    def _append(self, chunk):
        self.rows += len(chunk["t"])
        for name, rows in chunk.items():
            self.raw[name].write(np.ascontiguousarray(rows).data)

    def _finish(self, meta, extras):
        self._release()
        with zipfile.ZipFile(self.file, "w") as archive:
            for name, (shape, kind) in self.layout.items():
                with _member(archive, name) as out, open(self.raw[name].name, "rb") as body:
                    _npy_header(out, (self.rows, *shape), kind)
                    shutil.copyfileobj(body, out)
            for name, value in (*extras.items(), ("meta", np.array(json.dumps(meta)))):
                with _member(archive, name) as out:
                    np.lib.format.write_array(out, value, allow_pickle=False)

    def _release(self):
        for raw in self.raw.values():
            raw.close()


class H5Sink(FileSink):
    """HDF5: one data set a column, grown chunk by chunk, with dimension scales, and the string `meta`."""
    h5 = None

    def __init__(self, path, *args):
        needed("h5py", f"{path}: HDF5")
        super().__init__(path, *args)

    def _begin(self):
        h5py = needed("h5py", "HDF5")
        self.disk = Disk(self.file)
        self.h5 = h5py.File(self.disk, "w")
        for name, (shape, kind) in self.layout.items():
            rows = max(1, min(4096, 2 ** 20 // (8 * int(np.prod(shape, dtype=int)) or 1)))
            self.h5.create_dataset(name, (0, *shape), kind, maxshape=(None, *shape),
                                   chunks=_h5_chunk(rows, shape))

    def _append(self, chunk):
        for name, rows in chunk.items():
            data = self.h5[name]
            data.resize(len(data) + len(rows), axis=0)
            data[len(data) - len(rows):] = rows
        self.h5.flush()
        self.disk.check()

    def _finish(self, meta, extras):
        for name, value in extras.items():
            self.h5.create_dataset(name, data=value)
        label(self.h5, meta["families"])
        for name, unit in (meta.get("units") or {}).get("columns", {}).items():
            self.h5[name].attrs["units"] = unit
        put_text(self.h5, "meta", json.dumps(meta))
        self._release()
        self.disk.check()

    def _release(self):
        if self.h5:
            self.h5.close()
            self.disk.close()


def put_text(h5, name: str, text: str) -> None:
    """A text of fixed length. HDF5 keeps others in a heap, and a damaged heap may keep its reader for ever."""
    h5py = needed("h5py", "HDF5")
    data = text.encode()
    h5.create_dataset(name, data=data, dtype=h5py.string_dtype("utf-8", len(data)))


class Disk(io.RawIOBase):
    """A file for HDF5 that never fails under it: HDF5 cannot take back a write that did and
    crashes later. The first failure is kept for `check`; what is written after it is lost."""

    def __init__(self, path):
        self.file, self.problem, self.position, self.end = open(path, "w+b", 0), None, 0, 0

    def check(self) -> None:
        """Raise the first failure."""
        if self.problem:
            raise self.problem

    def write(self, data):
        data = memoryview(data).cast("B")
        self._try(self._write_all, data)
        self.position += len(data)
        self.end = max(self.end, self.position)
        return len(data)

    def _write_all(self, data):
        self.file.seek(self.position)
        while len(data):
            data = data[self.file.write(data):]

    def readinto(self, buffer):
        self.file.seek(self.position)
        count = self.file.readinto(buffer)
        self.position += count
        return count

    def seek(self, offset, whence=0):
        self.position = offset + (0, self.position, self.end)[whence]
        return self.position

    def tell(self):
        return self.position

    def truncate(self, size=None):
        self.end = self.position if size is None else size
        self._try(self.file.truncate, self.end)
        return self.end

    def flush(self):
        pass

    def close(self):
        super().close()
        self.file.close()

    def _try(self, act, argument):
        try:
            if self.problem is None:
                act(argument)
        except OSError as problem:
            self.problem = problem


def extended(kind) -> bool:
    """Has this type more digits than a double?"""
    return kind == np.longdouble and kind != np.float64


def written(table) -> np.ndarray:
    """The numbers of extended precision as objects, which `%s` prints with all their digits: `%g` prints those of a double."""
    found = table.astype(object)
    found[:, 0] = table[:, 0].astype(np.int64)
    return found


def listed(rows) -> str:
    """Numbers in one row, as JSON has them, those of extended precision with all their digits."""
    if not extended(rows.dtype) or not np.all(np.isfinite(rows)):
        return json.dumps(rows.astype(float).ravel().tolist())
    return f"[{', '.join(map(str, rows.flat))}]"


def csv_head(meta: dict, extras: dict, names) -> str:
    """Comment lines that a person reads, then those that the reader needs, then the header."""
    shown = ("spec", "title", "run", "method", "h", "steps", "orientation", "status")
    lines = [f"# {key}: {_one_line(meta[key])}" for key in shown if meta.get(key)]
    if meta.get("units"):
        lines.append("# units: " + ", ".join(f"{name} {unit}" for name, unit in meta["units"]["columns"].items()) + f" (CODATA {meta['units']['codata']})")
    lines += [f"# {name}: {listed(rows)}" for name, rows in extras.items() if name != "positions"]
    lines += [f"# meta: {json.dumps(meta)}", ",".join(names)]
    return "\n".join(lines) + "\n"


def _one_line(value):
    return " ".join(str(value).split())


def _h5_chunk(rows, shape):
    """About a megabyte: whole entries, or parts of one when it is larger than that."""
    first = min(shape[0], 2 ** 15) if shape else 0
    return (rows, *((first,) if shape else ()), *shape[1:])


def _member(archive, name):
    """A member without a date: the same run gives the same bytes."""
    return archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True)


def _npy_header(out, shape, kind):
    np.lib.format.write_array_header_2_0(
        out, {"descr": np.lib.format.dtype_to_descr(np.dtype(kind)),
              "fortran_order": False, "shape": shape})


_SINKS = {".csv": CsvSink, ".npz": NpzSink, ".h5": H5Sink}
