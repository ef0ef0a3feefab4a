"""What a picture must know of a result's spec: leaves, bonds, tracers, dependence on time."""
from __future__ import annotations

import dataclasses

import numpy as np

from ..expr import Spin, Time, walk
from ..spec import Graph, Lattice

BONDED = 20_000     # most sites of a family whose bonds are drawn


def with_facts(result):
    """The result with more in its meta, from the spec that it carries in `meta["sources"]`:

    casimirs: family -> matrix A of C = w.(A w)/2, of Nambu families; bonds: family -> (m, 2)
    numbers of joined sites; unconserved: names of the effects that tracers feel; driven: does
    an effect depend on time? A result without its spec is drawn from its numbers alone.
    Raises SpecError when the spec is spoilt.
    """
    meta = result.meta
    if "casimirs" in meta or not meta.get("sources"):
        return result
    from ..recorded import spec_of
    spec, called = spec_of(meta["sources"]), set(meta.get("effects") or ())
    known = {p.name for p in spec.parameters}
    values = {n: v for n, v in (meta.get("values") or {}).items() if n in known}
    return dataclasses.replace(result, meta={
        **meta, "casimirs": matrices(spec, values), "bonds": bonds(spec, values, called),
        "unconserved": sorted(with_tracers(spec) & called), "driven": of_time(spec, called)})


def bonds(spec, values, called) -> dict:
    """family -> (m, 2) numbers of the sites that the first of its lattices and graphs joins."""
    from ..start import parameter_values, sizes
    from ..witness.instances import instances_of
    env, places, found = parameter_values(spec, values), sizes(spec, values), {}
    for over in (e.over for e in spec.effects if e.name in called):
        if isinstance(over, (Lattice, Graph)) and len(over.bound) == 2 and \
                over.family not in found and places[over.family][1] <= BONDED:
            numbers, _ = instances_of(over, env, places)
            found[over.family] = np.stack([numbers[index] for index in over.bound], axis=1)
    return found


def matrices(spec, values) -> dict:
    """family -> 3 x 3 list, of the Nambu families of a spec."""
    from ..start import casimir_matrices, sizes
    every, places = casimir_matrices(spec, values), sizes(spec, values)
    return {f.name: every[places[f.name][0]].tolist()
            for f in spec.families if f.casimir is not None}


def of_time(spec, effects=None) -> bool:
    """Does an effect (of those named) depend on the time?"""
    return any(isinstance(node, Time) for e in spec.effects if effects is None or e.name in effects
               for node in walk(e.value))


def with_tracers(spec) -> set[str]:
    """Names of the effects that tracers feel: their energy is not conserved."""
    tracers = {f.name for f in spec.families if f.tracer}
    return {e.name for e in spec.effects
            if any(isinstance(n, Spin) and n.family in tracers for n in walk(e.value))}


def conserved_energy(result) -> tuple[np.ndarray | None, str]:
    """(H (k,) without what only tracers feel, what to call it); None without energies."""
    values, without = result.values, result.meta.get("unconserved") or ()
    if without:
        kept = [np.asarray(v, float) for n, v in values.items()
                if n.startswith("energy.") and n.removeprefix("energy.") not in without]
        return (np.sum(kept, axis=0), "without tracers") if kept else (None, "")
    if "energy" not in values:
        return None, ""
    note = "H depends on time" if result.meta.get("driven") else ""
    return np.asarray(values["energy"], float), note
