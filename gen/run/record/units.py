"""The units of the outputs of a run, for its metadata."""
from __future__ import annotations

from ...language.units import BASES, ENERGY, NONE, TIME
from .record import columns_of


def units_of(model, what) -> dict | None:
    """codata: the edition of the constants; energy, time, length, field: the units in which the model counts; columns: name -> unit, "1" of what has none.

    None where numbers have no units."""
    units = model.spec.units
    if units is None:
        return None
    columns = {name: of_column(model, units, name) for name in columns_of(model, what) if name != "step"}
    return {"codata": units.codata, **{kind: scale.text for kind, scale in zip(BASES, units.scales)}, "columns": columns}


def of_column(model, units, name: str) -> str:
    observable = next((o for o in model.scene.observables if o.name == name), None)
    if observable is not None:
        return observable.unit
    kind, _, family = name.partition(".")
    if kind in ("t", "energy"):
        return units.spelt(TIME if kind == "t" else ENERGY)
    if name == "casimirs":
        found = dict.fromkeys(units.spelt(units.of("casimir", f)) for f in model.families)
        return ", ".join(found)
    if kind == "momentum":
        return units.spelt(units.of("momentum", family))
    return units.spelt(NONE if kind == "charge" else units.of("name", family or name))
