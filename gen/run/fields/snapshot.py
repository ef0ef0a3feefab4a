"""One state of a result: which one, and into a file that other programs read."""
from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ...errors import OutputError, UsageError
from ...language.places import bond_vectors, bonds
from ...public import public
from .field import save, save_field
from .grid import family_of, of, with_parameters
from .vtk_xml import series
from ..files.output import load_result
from ..step.evaluated import Evaluated, sizes

NEAR = 1e-6         # of a step: a time as people write it


@public
def snapshot(result, out: str | os.PathLike, family: str | None = None, row: int | None = None, time: float | None = None,
             text: bool = False) -> Path:
    """Write the spins of one state in a format for other programs, and return the path.

    :param result: a Result, or the path of its file.
    :param out: the file. Its ending determines the format: .ovf (OVF 2.0), .vtk, .vtu (points and bonds), .vtr or .vti (meshes), or .pvd
        for a series of all outputs, whose files are written to a folder next to it.
    :param family: the family to write; needed if there are several.
    :param row: the number of an output, counted from 0, or from the end if negative. By default the last state is written.
    :param time: the time of an output, in place of `row`.
    :param text: whether to write numbers as text with 17 digits instead of binary doubles.
    :raises UsageError: if there is no such state or lattice, or for VTK if the sites have no positions.
    :raises OutputError: if the file cannot be written.

    Sites are at the positions given by the lattice of the spec. Without positions, cell (c0, c1, c2) is at these integers, and site s of
    the p sites of a cell at the fraction s/p of its diagonal.
    """
    result = result if hasattr(result, "meta") else load_result(result)
    spec, parameters = with_parameters(result, None)
    name = family_of(spec, family)
    grid = of(spec, name, parameters)
    lines = straight(spec, name, parameters, grid) if Path(out).suffix in (".vtu", ".pvd") else ()
    if Path(out).suffix == ".pvd":
        return saved_series(Path(out), result, name, grid, lines, text)
    w, step, t = state_of(result, name, row, time)
    meta = result.meta
    return save_field(out, w, grid, name, f"{meta['spec']} {meta['run']}: {name} at t = {t:.17g}, step {step}", text, lines, spec.units.spelt(spec.units.of("name", name)) if spec.units else "1")


def straight(spec, family: str, parameters: dict, grid) -> np.ndarray:
    """The bonds that do not go through the boundary, as pairs of sites."""
    values = Evaluated(spec, parameters).values
    pairs, vectors, where = bonds(spec, family, values), bond_vectors(spec, family, values), grid.where()
    if where is None or vectors is None:
        return pairs[:0]
    return pairs[np.abs(where[pairs[:, 1]] - where[pairs[:, 0]] - vectors).max(axis=1, initial=0) < NEAR * np.ptp(where)]


def saved_series(out: Path, result, family: str, grid, lines, text: bool) -> Path:
    """All outputs, each a file of the folder that has the name of `out` without its ending: .vtr of meshes, .vtu of other lattices."""
    if not result.w or not len(result.t):
        raise UsageError("the result contains no states: run with --what states")
    ending, folder = ".vtr" if grid.spacing() is not None else ".vtu", out.with_suffix("")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as problem:
        raise OutputError(f"cannot write {folder}: {problem.strerror or problem}") from None
    names = [f"{folder.name}/{k:06d}{ending}" for k in range(len(result.t))]
    for k, name in enumerate(names):
        save_field(out.parent / name, result.w[family][k], grid, family, "", text, lines)
    return save(out, series(zip(result.t.tolist(), names)))


def state_of(result, family: str, row: int | None = None, time: float | None = None):
    """(w, step, t) of a family: of an output, or of the last state."""
    if row is not None and time is not None:
        raise UsageError("give either row or time")
    if row is None and time is None:
        first, count = sizes(*with_parameters(result, None))[family]
        meta = result.meta
        return result.final[first:first + count], meta["done"], result.t[-1] if len(result.t) and result.step[-1] == meta["done"] else meta["done"] * meta["h"]
    if not result.w or not len(result.t):
        raise UsageError("the result contains only the last state: run with --what states")
    k = row_at(result, time) if row is None else row
    if not -len(result.t) <= k < len(result.t):
        raise UsageError(f"no row {k}: the result has {len(result.t)}")
    return result.w[family][k], int(result.step[k]), float(result.t[k])


def row_at(result, time: float) -> int:
    """The output at a time. Raises UsageError that names the nearest."""
    away = np.abs(result.t - time)
    k = int(np.argmin(away))
    if not away[k] <= NEAR * abs(result.meta["h"]):
        raise UsageError(f"no output at t = {time:.15g}; the nearest is at {result.t[k]:.15g}")
    return k
