"""The units of what a result holds, as pictures write them."""
from __future__ import annotations

from .text import shown

MODEL = "model units"
NONE = {"time": MODEL, "energy": MODEL, "length": MODEL}


def unit_of(result, column: str) -> str:
    """Of a column: as the metadata have it, "dimensionless" for 1."""
    found = columns_of(result).get(column, MODEL)
    return "dimensionless" if found == "1" else shown(found)


def columns_of(result) -> dict:
    return (result.meta.get("units") or {}).get("columns", {})


def plain(column: str) -> str:
    """Where nothing tells the units."""
    return MODEL


def kinds_of(result) -> dict:
    """The units of time, energy and length in which a model counts."""
    found = result.meta.get("units") or {}
    return {kind: found.get(kind) or MODEL for kind in NONE}
