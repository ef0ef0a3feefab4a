"""What the axes of a result's columns are called, in HDF5, in xarray and in tables."""
from __future__ import annotations

import numpy as np

from .received import AXES, COUNTED, LETTER, VECTORS

SITE, COMPONENT = "site", "component"
BESIDE = ("final", "substeps", "positions")      # arrays that have no row for each output


def axes_of(name: str, shape: tuple, families: dict) -> tuple[str, ...]:
    """The names of the axes of one entry of a column, or of the last state: `site` and `component` of states, `site` of Casimirs.

    families: name -> number of sites. Of several families each has its own axis, `site_w`; `site` counts all of them.
    """
    if name in families:
        return (sites_of(name, families), COMPONENT)
    if name.startswith(VECTORS):
        return (COMPONENT,)
    return {"final": (SITE, COMPONENT), "positions": (SITE, COMPONENT), "casimirs": (SITE,)}.get(name) or tuple(f"{name}_{k}" for k in range(len(shape)))


def sites_of(family: str, families: dict) -> str:
    """The axis of the sites of a family."""
    return SITE if len(families) == 1 else f"{SITE}_{family}"


def coordinates(families: dict) -> dict[str, np.ndarray]:
    """axis -> what it counts: the numbers of sites, and x, y, z. Of types that no column has, by which they are told from columns."""
    counted = {SITE: sum(families.values()), **{sites_of(family, families): count for family, count in families.items()}}
    return {**{axis: np.arange(count, dtype=COUNTED) for axis, count in counted.items()}, COMPONENT: np.array([*AXES], LETTER)}


def apart(axes, columns) -> dict[str, str]:
    """axis -> its name beside columns of these names: with underscores behind it where a column, or another axis, is called so."""
    names = {}
    for axis in axes:
        name = axis
        while name in columns or name in names.values():
            name += "_"
        names[axis] = name
    return names


def flat_names(name: str, shape: tuple) -> list[str]:
    """Columns of numbers of one entry: `w[3].x`, `momentum.w.x`, `casimirs[2]`, `energy`."""
    if not shape:
        return [name]
    if len(shape) == 2:
        return [f"{name}[{i}].{axis}" for i in range(shape[0]) for axis in AXES]
    if name.startswith(VECTORS):
        return [f"{name}.{axis}" for axis in AXES]
    return [f"{name}[{i}]" for i in range(shape[0])]


def label(h5, families: dict) -> None:
    """Dimension scales for all axes of the data sets of an open file, as netCDF has them: `t` along the outputs, sites and components along an entry."""
    columns = {name: h5[name] for name in h5}
    axes = {name: axes_of_column(name, column.shape, families) for name, column in columns.items()}
    lengths = {axis: size for name, column in columns.items() for axis, size in zip(axes[name], column.shape) if axis != "t"}
    values = {**{axis: np.arange(size, dtype=COUNTED) for axis, size in lengths.items()}, **coordinates(families)}
    names = apart(values, columns)
    scales = {"t": columns["t"], **{axis: h5.create_dataset(names[axis], data=values[axis]) for axis in values}}
    for axis, scale in scales.items():
        scale.make_scale(names.get(axis, axis))
    for name, column in columns.items():
        for place, axis in enumerate(axes[name]):
            if not axis == name == "t":     # a scale has none
                column.dims[place].attach_scale(scales[axis])


def axes_of_column(name: str, shape: tuple, families: dict) -> tuple[str, ...]:
    """The names of the axes of a column of k outputs, or of an array beside the columns."""
    return axes_of(name, shape, families) if name in BESIDE else ("t", *axes_of(name, shape[1:], families))
