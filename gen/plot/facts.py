"""What a picture must know of a result's spec: leaves, tracers, dependence on time."""
from __future__ import annotations

import numpy as np

from ..conserved import driven, energy_of, with_tracers


def with_facts(result):
    """Add to the result's meta, from the spec that it carries in `meta["sources"]`:

    casimirs: family -> matrix A of C = w.(A w)/2, of Nambu families; unconserved: names of
    the effects that tracers feel; driven: does the energy of the others depend on time? A result without
    its spec is drawn from its numbers alone. Raises SpecError when the spec is spoilt.
    """
    meta = result.meta
    if "casimirs" in meta or not meta.get("sources"):
        return result
    from ..recorded import spec_of
    spec, called = spec_of(meta["sources"]), set(meta.get("effects") or ())
    meta["casimirs"] = matrices(spec, meta.get("values") or {})
    meta["unconserved"] = sorted(with_tracers(spec) & called)
    meta["driven"] = driven(spec, called)
    return result


def matrices(spec, values) -> dict:
    """family -> 3 x 3 list, of the Nambu families of a spec."""
    from ..start import casimir_matrices, sizes
    known = {p.name for p in spec.parameters}
    values = {n: v for n, v in values.items() if n in known}
    every, places = casimir_matrices(spec, values), sizes(spec, values)
    return {f.name: every[places[f.name][0]].tolist()
            for f in spec.families if f.casimir is not None}


def conserved_energy(result) -> tuple[np.ndarray | None, str]:
    """(H (k,) without what only tracers feel, what to call it); None without energies."""
    without = result.meta.get("unconserved") or ()
    energy = energy_of(result.values, without)
    if energy is None:
        return None, ""
    notes = ["without tracers"] * bool(without) + ["H depends on time"] * bool(result.meta.get("driven"))
    return np.asarray(energy, float), ", ".join(notes)
