"""Where the sites of a result stand, which bonds join them there, and what a player colours them by."""
from __future__ import annotations

import numpy as np

from ...language.evaluate import evaluate
from ...language.instances import instances_of
from ...language.places import bond_vectors, bonds, placed_on, positions
from ...language.spec import Lattice, families_of
from ...language.units import LENGTH, unit as unit_named
from ...run.step.evaluated import Evaluated
from .units import MODEL

LINKS = 600_000     # most bonds of a family that a page carries
SITE_OUTPUTS = 1_000_000    # sites times outputs up to which a page carries the numbers of sites
MAPS = 8            # most of them


def standing(numbers: Evaluated, scene: Evaluated) -> dict:
    """Of a spec, and of its scene whose bonds are shown: family -> {"places": (n, 3), "unit": theirs, "names": of the sites of a cell, "links": (m, 2) numbers of sites that a bond joins there, not through a boundary}; families
    without places are left out."""
    found = {}
    for name, (_, count) in numbers.places.items():
        where = positions(numbers.spec, name, numbers.values)
        if where is not None and len(where) == count and np.all(np.isfinite(where)):
            over = placed_on(numbers.spec, name)
            unit, size = length_of(numbers.spec.units, over)
            names = over.places.names if isinstance(over, Lattice) else ()
            found[name] = {"places": where / size, "unit": unit, "names": names, "links": links(numbers, scene, name, where)[:LINKS]}
    return found


def length_of(units, over) -> tuple[str, float]:
    """The unit in which places are told, and its size: the `length` of [units], else that in which the lattice constant is written; "" where places
    are no lengths, as without a constant that has a unit."""
    if units is None:
        return MODEL, 1.0
    if not isinstance(over, Lattice) or not over.places.measured:
        return "", 1.0
    if "length" in dict(units.named) or not over.places.unit:
        return units.spelt(LENGTH), 1.0
    return over.places.unit, float(units.factor(unit_named(over.places.unit)))


def links(numbers: Evaluated, scene: Evaluated, family: str, where) -> np.ndarray:
    """The bonds whose vector is the difference of the places of their ends."""
    asked = numbers.spec, family, numbers.values, scene.spec
    pairs, along = bonds(*asked), bond_vectors(*asked)
    near = np.abs(where[pairs[:, 1]] - where[pairs[:, 0]] - along).max(axis=1, initial=0) <= 1e-6 * np.abs(along).max(initial=0)
    return both_present(scene, family, pairs[near])


def both_present(numbers: Evaluated, family: str, pairs) -> np.ndarray:
    """Those of the pairs of sites (m, 2) of which neither is absent."""
    return pairs[numbers.present[numbers.places[family][0] + pairs].all(axis=1)]


def site_terms(spec, called) -> list:
    """The terms whose value a site has a share of: effects that are energies, and observables."""
    return [(f"energy.{e.name}", e) for e in spec.energies if e.name in called] + [(o.name, o) for o in spec.observables]


def site_maps(numbers: Evaluated, called, t, states: dict) -> list[dict]:
    """name, family, unit and values (k, n) of all that sites have a share of: of each term its sites share its value equally.

    t (k,); states {family: (k, n, 3)} at these times. What gives no finite number or joins no sites of the families is left out.
    """
    if len(t) * sum(w.shape[1] for w in states.values()) > SITE_OUTPUTS:
        return []
    found = [one for label, term in site_terms(numbers.spec, called) for one in shares(label, term, numbers, t, states)]
    return whole([one for one in found if np.all(np.isfinite(one["values"]))], called)[:MAPS]


def whole(maps, called) -> list[dict]:
    """The same after the energy of each site, where it has several parts."""
    sums = []
    for family in dict.fromkeys(m["family"] for m in maps):
        parts = [m for m in maps if m["family"] == family and m["name"].startswith("energy.")]
        if len(parts) > 1:
            sums.append({**parts[0], "name": "energy", "values": sum(m["values"] for m in parts)})
    return sums + maps


def shares(label: str, term, numbers: Evaluated, t, states: dict):
    """One map a family that the term runs over."""
    homes = {index: family for index, family in families_of(term.over).items() if family in states}
    if not homes:
        return
    sites, columns = instances_of(term.over, numbers.values, numbers.places)
    there = np.all([numbers.present[numbers.places[family][0] + sites[index]] for index, family in families_of(term.over).items()], axis=0)
    sums = {family: np.zeros(states[family].shape[:2]) for family in set(homes.values())}
    for k, time in enumerate(t):
        env = {**numbers.values, **sites, **columns, "t": time, "spins": {name: w[k] for name, w in states.items()}}
        value = np.where(there, evaluate(term.value, env), 0) / len(homes)
        for index, family in homes.items():
            sums[family][k] += np.bincount(sites[index], value, states[family].shape[1])
    for family, values in sums.items():
        yield {"name": label, "family": family, "unit": term.unit, "values": values}
