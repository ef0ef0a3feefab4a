"""Outputs that are computed from the states as a run goes, without keeping these: only where they are named."""
from __future__ import annotations

from ...errors import UsageError
from ...read.names import COMPUTED
from ..fields.grid import grids_of
from ..fields.lattice import charge, magnetisation

SHAPES = {"magnetisation": (3,), "charge": ()}      # of one entry


def computed_columns(model, what) -> list[str]:
    """`charge.w`, .. of what a run names. Raises UsageError where no family has a charge."""
    own = {o.name for o in model.scene.observables}
    asked = [kind for kind in COMPUTED if kind in what and kind not in own]
    names = [f"{kind}.{family}" for kind in asked for family in model.families if kind != "charge" or film_of(model, family)]
    if "charge" in asked and not any(name.startswith("charge.") for name in names):
        raise UsageError(f"{model.spec.name} has no topological charge, which requires a family on a two-dimensional lattice with one site per cell")
    return names


def film_of(model, family: str):
    """The only lattice of a family that has a topological charge; None if there is none or there are several."""
    films = [g for g in grids_of(model.prepared.numbers, family) if len(g.size) == 2 and g.sites == 1]
    return films[0] if len(films) == 1 else None


def functions_of(model, names) -> dict:
    """column -> the function of states (k, sites, 3) that gives its k entries."""
    return {name: function_of(model, *name.split(".", 1)) for name in names if name.split(".")[0] in COMPUTED and "." in name}


def function_of(model, kind: str, family: str):
    first, count = model.families[family]
    grid = film_of(model, family)
    if kind == "charge":
        return lambda w: charge(w[:, first:first + count], grid)
    return lambda w: magnetisation(w[:, first:first + count])
