"""What a picture must know of a result's spec: leaves, bonds, tracers, dependence on time."""
from __future__ import annotations

import dataclasses

import numpy as np

from ...language.spec import Graph, Lattice, families_of
from ...run.record.conserved import driven, energy_of, of_time, with_tracers
from ...run.step.evaluated import Evaluated
from .standing import both_present, standing

BONDED = 20_000     # most sites of a family whose bonds are drawn


def with_facts(result):
    """The result with more in its meta, from the spec that it carries in `meta["sources"]`:

    casimirs: family -> matrix A of C = w.(A w)/2, of Nambu families; bonds: family -> (m, 2)
    numbers of joined sites; grids: family -> cells in each direction and sites of a cell,
    where one lattice joins them; standing: what `standing` gives; numbers: of the scene that was run; unconserved: names of the effects that tracers feel; driven: why
    the energy of the others is not conserved, or False. A result without its spec is drawn from its numbers
    alone. Raises SpecError when the spec is spoilt.
    """
    meta = result.meta
    if "casimirs" in meta or not meta.get("sources"):
        return result
    from ...run.files.recorded import spec_of
    spec, called = spec_of(meta["sources"], meta["spec"]), set(meta.get("effects") or ())
    known = {p.name for p in spec.parameters}
    numbers = Evaluated(spec, {n: v for n, v in (meta.get("parameters") or {}).items() if n in known})
    scene = numbers.of(dataclasses.replace(spec, effects=tuple(e for e in spec.effects if e.name in called)))
    return dataclasses.replace(result, meta={
        **meta, "casimirs": matrices(numbers), "bonds": bonds(scene), "grids": grids(numbers, called), "standing": standing(numbers, scene), "numbers": scene,
        "unconserved": sorted(with_tracers(spec) & called), "driven": driven(spec, called) and why_driven(spec, called)})


def why_driven(spec, called) -> str:
    """Why the energy of these effects is not conserved, in words."""
    others = dict.fromkeys(e.gives_up["as"] for e in spec.effects if e.name in called and e.gives_up)
    return ", ".join(["H may depend on time: its formula contains t"] * of_time(spec, called) + [*others])


def bonds(numbers: Evaluated) -> dict:
    """family -> (m, 2) numbers of the sites that the lattices and graphs of a scene join, each pair once."""
    from ...language.instances import instances_of
    places, found = numbers.places, {}
    for over in (e.over for e in numbers.spec.energies):
        if isinstance(over, (Lattice, Graph)) and over.family and len(families_of(over)) == 2 and places[over.family][1] <= BONDED:
            sites, _ = instances_of(over, numbers.values, places)
            found.setdefault(over.family, []).append(both_present(numbers, over.family, np.stack([sites[index] for index in families_of(over)], axis=1)))
    return {family: np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0) for family, pairs in found.items()}


def grids(numbers: Evaluated, called) -> dict:
    """family -> (size, sites of a cell) of the only lattice with most directions, of the effects called."""
    from ...run.fields.grid import grids_of
    found = {}
    for family in numbers.spec.families:
        every = grids_of(numbers, family.name, called)
        most = [grid for grid in every if len(grid.size) == max(len(g.size) for g in every)]
        if len(most) == 1:
            found[family.name] = most[0].size, most[0].sites
    return found


def matrices(numbers: Evaluated) -> dict:
    """family -> 3 x 3 list, of the Nambu families of a spec."""
    return {f.name: numbers.casimir_matrices[numbers.places[f.name][0]].tolist()
            for f in numbers.spec.families if f.casimir is not None}


def conserved_energy(result) -> tuple[np.ndarray | None, str]:
    """(H (k,) without what only tracers feel, what to call it); None without energies."""
    without = result.meta.get("unconserved") or ()
    energy = energy_of(result.values, without)
    if energy is None:
        return None, ""
    notes = ["without tracers" if without else "", result.meta.get("driven") or ""]
    return np.asarray(energy, float), ", ".join(filter(None, notes))
