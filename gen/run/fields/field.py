"""Vectors on the cells of a lattice, as the files of other programs hold them: .ovf and .vtk, out and in."""
from __future__ import annotations

import os
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import OutputError, UsageError, printable
from ...language import limits
from ...language.spec import Spec
from ...public import public
from . import ovf, vtk, vtk_xml
from ..files.durable import write_new
from .grid import Grid, grids_of, said
from ..files.received import Wrong, opened
from ..step.evaluated import Evaluated

FORMATS = {".ovf": ovf, ".vtk": vtk}
MADE = {".vtu": vtk_xml.points, ".vtr": vtk_xml.rectilinear, ".vti": vtk_xml.image}     # for other programs alone
SINGLE = 1e-5       # relative: single precision, and the six digits that programs print by default, are within it


@dataclass(frozen=True)
class Field:
    """vectors: (count, 3), the first direction fastest; size: cells in three directions, None for a list of points."""
    vectors: np.ndarray
    size: tuple[int, int, int] | None

    def rows(self, spec: Spec, parameters: dict | None = None) -> np.ndarray:
        """The state (sites, 3) of a spec with these parameters: as `placed`, for who asks once."""
        return self.placed(Evaluated(spec, parameters))

    def placed(self, numbers: Evaluated) -> np.ndarray:
        """The state (sites, 3) of the spec of these numbers. A vector that is off its sphere by the rounding of the file is put on it.

        Raises UsageError for other numbers of sites, and for cells that lie otherwise than those of the spec.
        """
        spec = numbers.spec
        count = sum(n for _, n in numbers.places.values())
        if len(self.vectors) != count:
            raise UsageError(f"the start has {len(self.vectors)} vectors, but {spec.name} has {count} sites")
        grids = [grid for name in numbers.places for grid in grids_of(numbers, name)]
        if self.size and grids and not any(grid.sites == 1 and padded(grid) == self.size for grid in grids):
            raise UsageError(f"the start has {said(self.size)} cells, but {spec.name} has {' and '.join(said(g.size) for g in grids)}"
                             + " with several sites each" * all(g.sites > 1 for g in grids))
        return on_spheres(self.vectors, numbers.radii)


def padded(grid: Grid) -> tuple:
    """The cells in three directions. Raises UsageError for four."""
    if len(grid.size) > 3:
        raise UsageError("a file of spins has at most three directions")
    return (*grid.size, 1, 1)[:3]


def on_spheres(w, radius) -> np.ndarray:
    """w, the vectors scaled to their radius that are off by more than a start may be, and by no more than SINGLE."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        length = np.linalg.norm(w, axis=1)
        off = np.abs(length - radius) / radius
        scaled = w * (radius / length)[:, None]
    return np.where(((off > limits.SPHERE) & (off <= SINGLE))[:, None], scaled, w)


@public
def load_field(path: str | os.PathLike) -> Field:
    """Read the vectors of an OVF 2.0 (.ovf) or legacy VTK (.vtk) file, to start from them: `smidgen.run(spec, start=...)`.

    :raises UsageError: if the file has another format, is damaged, or contains fewer numbers than its header says.
    """
    reader = known_format(path)
    with refusing(path), opened(path) as file:
        vectors, size = reader.read(file, os.fstat(file.fileno()).st_size)
    return Field(vectors, size)


def save_field(path, w, grid: Grid, label: str, title: str, text: bool, bonds=(), unit: str = "1") -> Path:
    """Write the vectors (count, 3) of a family `label`; a file of that name stays until the new one is whole. bonds: pairs of sites, for .vtu; unit: of the vectors, for .ovf."""
    path, w = Path(path), np.asarray(w, float)
    if path.suffix in MADE:
        return save(path, MADE[path.suffix](w, grid, label, text, *([bonds] if path.suffix == ".vtu" else [])))
    if path.suffix not in FORMATS:
        raise UsageError(f"{path}: the name of a file of spins must end in {', '.join([*FORMATS, *MADE])}, or in .pvd for a time series")
    return save(path, known_format(path).written(w, grid, padded(grid), label, " ".join(title.split()), text, unit))


def save(path: Path, data: bytes) -> Path:
    """Write a file whole. Raises OutputError."""
    try:
        write_new(path, data)
    except OSError as problem:
        raise OutputError(f"cannot write {path}: {problem.strerror or problem}") from None
    return path


def known_format(path):
    """The module that knows the ending of `path`."""
    suffix = Path(path).suffix
    if suffix not in FORMATS:
        raise UsageError(f"{path}: the name of a file of spins must end in {' or '.join(FORMATS)}")
    return FORMATS[suffix]


@contextmanager
def refusing(path):
    """Whatever is wrong with a file becomes one error."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")      # numpy's of text that ends early
            yield
    except UsageError:
        raise
    except Wrong as problem:
        raise UsageError(f"cannot read {path}: {printable(str(problem))}") from None
    except MemoryError:
        raise UsageError(f"{path}: there is not enough memory to read it") from None
    except Exception:
        raise UsageError(f"cannot read {path}: it is damaged") from None
