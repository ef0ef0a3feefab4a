"""The units of what a result holds, as pictures write them."""
from __future__ import annotations

from .text import shown

MODEL = "model units"
NONE = {"time": MODEL, "energy": MODEL, "length": MODEL}


def unit_of(result, column: str) -> str:
    """Of a column: as the metadata have it, "" for 1."""
    found = columns_of(result).get(column, MODEL)
    return "" if found == "1" else shown(found)


def with_unit(name: str, unit: str, between: str = " ") -> str:
    """`name (unit)`; the name alone of a number without a unit."""
    return f"{name}{between}({unit})" if unit else name


def at_time(t, unit: str) -> str:
    """`t = 400 fs`, for matplotlib; without the unit where none is named."""
    return f"$t$ = {t:g}{shown(behind(unit))}"


def behind(unit: str) -> str:
    """` fs`, behind a number; nothing where no unit is named."""
    return "" if unit in ("", MODEL) else f" ({unit})" if unit[0].isdigit() else f" {unit}"


def columns_of(result) -> dict:
    return (result.meta.get("units") or {}).get("columns", {})


def plain(column: str) -> str:
    """Where nothing tells the units."""
    return MODEL


def kinds_of(result) -> dict:
    """The units of time, energy and length in which a model counts."""
    found = result.meta.get("units") or {}
    return {kind: found.get(kind) or MODEL for kind in NONE}
