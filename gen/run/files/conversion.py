"""Results as the objects of xarray and pandas, which are imported when they are asked for."""
from __future__ import annotations

import json
import math

import numpy as np

from ...packages import needed
from .labels import COMPONENT, apart, axes_of_column, coordinates, flat_names

TOLD = ("spec", "title", "run", "method", "h", "orientation", "status", "program", "version", "generator")    # of the metadata, one attribute each


def dataset(result):
    """The xarray.Dataset of a Result."""
    xarray = needed("xarray", "to_xarray()")
    columns = {**{name: result[name] for name in result}, **({} if result.final is None else {"final": result.final})}
    families = result.meta["families"]
    values = {**coordinates(families), COMPONENT: np.array([*"xyz"])}
    names = apart(values, columns)
    axes = {name: tuple(names.get(axis, axis) for axis in axes_of_column(name, column.shape, families)) for name, column in columns.items()}
    used = {axis for of_one in axes.values() for axis in of_one}
    scales = {names[axis]: value for axis, value in values.items() if names[axis] in used}
    units = (result.meta.get("units") or {}).get("columns", {})
    held = {name: (axes[name], column, {"units": units[name]} if name in units else {}) for name, column in columns.items()}
    beside = {name: held.pop(name) for name in ("t", "step")}
    return xarray.Dataset(held, {**beside, **scales}, told(result.meta))


def told(meta: dict) -> dict:
    """Attributes that netCDF can hold: what ran, and all of the metadata as JSON."""
    return {**{key: meta[key] for key in TOLD if meta.get(key) is not None}, "meta": json.dumps(meta)}


def dataframe(result):
    """The pandas.DataFrame of a Result."""
    pandas = needed("pandas", "to_dataframe()")
    columns = {}
    for name in result:
        rows = result[name].reshape(len(result.t), math.prod(result[name].shape[1:]))
        columns |= dict(zip(flat_names(name, result[name].shape[1:]), rows.T))
    return pandas.DataFrame(columns).set_index("t")
