"""What a player has beside the trajectory: places of sites, bonds and cells there, numbers of sites, numbers over time."""
from __future__ import annotations

import numpy as np
from matplotlib.tri import Triangulation

from .cells import spacing
from .coding import deflated
from .standing import site_maps
from .text import printable
from .units import columns_of, kinds_of

SERIES = 40         # most numbers over time
FLAT_SITES = 70_000     # most sites of a lattice that has isolines


class Extras:
    """Of a result with facts: as the parts of a page ask for them."""

    def __init__(self, result, states: dict):
        meta = result.meta
        self.t, self.states, self.values = np.asarray(result.t, float), states, result.values
        self.standing, self.grids = meta.get("standing") or {}, meta.get("grids") or {}
        self.units, self.columns = kinds_of(result), columns_of(result)
        self.numbers, self.called = meta.get("numbers"), set(meta.get("effects") or ())
        self.length = min((spacing(one["places"]) for one in self.standing.values()), default=1.0)

    def family(self, name: str) -> dict:
        """places, links and cell of a family that has places, which are in units of the distance of neighbours."""
        found = self.standing.get(name)
        if found is None or len(found["places"]) != self.states[name].shape[1]:
            return {}
        more = {"cell": cell(*self.grids[name], found["names"])} if name in self.grids else {}
        sides = triangles(found["places"])
        cover = {} if sides is None else {"cover": [covered(found["places"] / self.length, sides), *self.covers(found["places"], more)]}
        return {"places": deflated(found["places"] / self.length, "<f4"), "links": deflated(found["links"], "<i4"), **more, **cover,
                **({} if sides is None else {"triangles": deflated(sides, "<i4")})}

    def covers(self, where, more: dict) -> list:
        """The same of the sites of each place of a cell, where there are several."""
        each = more["cell"]["sites"] if more else 1
        found = [(where[k::each] / self.length, triangles(where[k::each])) for k in range(each)] if each > 1 else []
        return [covered(some, sides) if sides is not None else 0.0 for some, sides in found]

    def maps(self, keep) -> list[dict]:
        """Numbers of sites at the outputs `keep`, as bytes between the smallest and the largest."""
        if self.numbers is None or not any(name in self.standing for name in self.states):
            return []
        found = site_maps(self.numbers, self.called, self.t[keep], {name: w[keep] for name, w in self.states.items()})
        energy = self.units["energy"] if self.columns else ""
        some = [one for one in found if one["family"] in self.standing and np.ptp(one["values"]) > 0]
        return [mapped({**one, "unit": one["unit"] or energy * one["name"].startswith("energy")}) for one in some]

    def series(self, keep) -> list[dict]:
        """The other numbers of the result over time."""
        rows = [row for name, values in self.values.items() if name != "casimirs" for row in columns(name, np.asarray(values, float))]
        return [plotted(name, values[keep], self.unit(name)) for name, values in rows[:SERIES] if np.isfinite(values[keep]).any()]

    def unit(self, name: str) -> str:
        """Of a number over time; of a component, that of its vector."""
        found = self.columns.get(name) or self.columns.get(name[:-2], "")
        return "" if found == "1" else found


def triangles(where):
    """(m, 3) numbers of sites: Delaunay's triangles of a flat lattice, without those that bridge gaps; None of any other, or of very many."""
    if len(where) > FLAT_SITES or np.ptp(where[:, 2]) > 0 or np.linalg.matrix_rank(where - where[0]) < 2:
        return None
    found = Triangulation(*where[:, :2].T).triangles
    sides = np.linalg.norm(where[found] - where[np.roll(found, 1, axis=1)], axis=2).max(axis=1)
    return found[sides < 2.1 * np.median(sides)]


def covered(where, sides) -> float:
    """The radius of discs about sites that leave no hole: of the circles through the corners of most triangles, and a little more."""
    a, b, c = (np.linalg.norm(where[sides[:, k]] - where[sides[:, k - 1]], axis=1) for k in range(3))
    s = (a + b + c) / 2
    area = np.sqrt(np.maximum(s * (s - a) * (s - b) * (s - c), 1e-12))
    return float(1.03 * np.quantile(a * b * c / (4 * area), 0.8))


def cell(size, sites: int, names) -> dict:
    called = [printable(name) for name in names] if len(names) == sites else [str(k) for k in range(sites)]
    return {"size": [int(n) for n in size], "sites": int(sites), **({"names": called} if sites > 1 else {})}


def mapped(one: dict) -> dict:
    """A map as it travels: about 0 where it has both signs."""
    values = one["values"]
    low, high = float(values.min()), float(values.max())
    if low < 0 < high:
        low, high = -max(-low, high), max(-low, high)
    return {"name": printable(one["name"]), "family": printable(one["family"]), "unit": printable(one["unit"]), "low": low, "high": high,
            "table": "diverging" if low < 0 < high else "sequential",
            "values": deflated(np.rint((values - low) / (high - low) * 255), "u1")}


def columns(name: str, values):
    """A number over time, or the components of a vector."""
    if values.ndim == 1:
        return [(name, values)]
    return [(f"{name}.{x}", values[:, k]) for k, x in enumerate("xyz")] if values.ndim == 2 and values.shape[1] == 3 else []


def plotted(name: str, values, unit: str) -> dict:
    """One number over time as it travels, with a range that is not empty."""
    good = values[np.isfinite(values)]
    low, high = float(good.min()), float(good.max())
    room = 0.0 if high > low else max(abs(low) * 1e-6, 1e-16)
    return {"name": printable(name), "unit": printable(unit), "low": low - room, "high": high + room, "values": deflated(values, "<f4")}
