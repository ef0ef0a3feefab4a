"""The units of the outputs of a run, for its metadata."""
from __future__ import annotations

from ...language.units import BASES, ENERGY, NONE, TIME
from .record import columns_of


def units_of(model, what, averaged=()) -> dict | None:
    """codata: the edition of the constants; energy, time, length, field: the units in which the model counts; momentum, casimirs: those of all
    families; columns: name -> unit, "1" of what has none; means: the same of the quantities `averaged`, where there are some.

    None where numbers have no units."""
    units = model.spec.units
    if units is None:
        return None
    columns = {name: of_column(model.scene, units, name) for name in columns_of(model, what) if name != "step"}
    whole = {kind: of_families(model.families, units, what) for kind, what in (("momentum", "momentum"), ("casimirs", "casimir"))}
    means = {"means": {name: of_column(model.scene, units, name) for name in averaged}} if averaged else {}
    return {"codata": units.codata, **{kind: scale.text for kind, scale in zip(BASES, units.scales)}, **whole, **means, "columns": columns}


def of_families(families, units, what: str) -> str:
    """The unit of what all families have."""
    return ", ".join(dict.fromkeys(units.spelt(units.of(what, f)) for f in families))


def of_column(scene, units, name: str) -> str:
    """Of a column, or of a number in it, `momentum.w.x`."""
    observable = next((o for o in scene.observables if o.name == name), None)
    if observable is not None:
        return observable.unit
    kind, family = (*name.split("."), "")[:2]
    if kind in ("t", "energy"):
        return units.spelt(TIME if kind == "t" else ENERGY)
    if name == "casimirs":
        return of_families((f.name for f in scene.families), units, "casimir")
    if kind == "momentum":
        return units.spelt(units.of("momentum", family))
    return units.spelt(NONE if kind == "charge" else units.of("name", family or name))
