"""Where the sites of a result stand, which bonds join them there, and what a player colours them by."""
from __future__ import annotations

import numpy as np

from ...language.evaluate import evaluate
from ...language.instances import instances_of
from ...language.spec import Lattice, families_of
from ...run.step.evaluated import Evaluated

LINKS = 600_000     # most bonds of a family that a page carries
SITE_OUTPUTS = 1_000_000    # sites times outputs up to which a page carries the numbers of sites
MAPS = 8            # most of them


def standing(numbers: Evaluated) -> dict:
    """family -> {"places": (n, 3), "links": (m, 2) numbers of sites that a bond joins there, not through a boundary}; families without places are left out."""
    found = {}
    for name, (_, count) in numbers.places.items():
        where, pairs = places_of(numbers, name)
        if where is not None and len(where) == count and np.all(np.isfinite(where)):
            found[name] = {"places": where, "links": pairs[:LINKS]}
    return found


def places_of(numbers: Evaluated, family: str):
    """(places or None, links)."""
    lattices = [t.over for t in (*numbers.spec.energies, *numbers.spec.observables) if isinstance(t.over, Lattice) and t.over.family == family]
    if not lattices or lattices[0].sites > 1:
        return None, None
    over = max(lattices, key=lambda o: len(o.size))
    size = [int(evaluate(e, numbers.values)) for e in over.size]
    where = np.zeros((int(np.prod(size)), 3))
    where[:, :len(size)] = np.indices(size[::-1]).reshape(len(size), -1)[::-1].T
    sites, _ = instances_of(over, numbers.values, numbers.places)
    pairs = np.stack([sites[index] for index in over.bound[:2]], axis=1) if len(over.bound) == 2 else np.zeros((0, 2), int)
    return where, pairs[np.linalg.norm(where[pairs[:, 0]] - where[pairs[:, 1]], axis=1) < 1.01]


def site_terms(spec, called) -> list:
    """The terms whose value a site has a share of: effects that are energies, and observables."""
    return [(f"energy {e.name}", e) for e in spec.energies if e.name in called] + [(o.name, o) for o in spec.observables]


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
        parts = [m for m in maps if m["family"] == family and m["name"].startswith("energy ")]
        if len(parts) > 1:
            sums.append({**parts[0], "name": "energy", "values": sum(m["values"] for m in parts)})
    return sums + maps


def shares(label: str, term, numbers: Evaluated, t, states: dict):
    """One map a family that the term runs over."""
    homes = {index: family for index, family in families_of(term.over).items() if family in states}
    if not homes:
        return
    sites, columns = instances_of(term.over, numbers.values, numbers.places)
    sums = {family: np.zeros(states[family].shape[:2]) for family in set(homes.values())}
    for k, time in enumerate(t):
        env = {**numbers.values, **sites, **columns, "t": time, "spins": {name: w[k] for name, w in states.items()}}
        value = np.broadcast_to(evaluate(term.value, env), len(next(iter(sites.values())))) / len(homes)
        for index, family in homes.items():
            sums[family][k] += np.bincount(sites[index], value, states[family].shape[1])
    for family, values in sums.items():
        yield {"name": label, "family": family, "unit": term.unit, "values": values}
