"""Outputs of a run in blocks, as the C writes them: times, states, values, Casimirs, and how near midpoints came to a centre.

The midpoint mbar = (w + W)/2 of a step of the spherical midpoint method lies at the distance rho = |w + W|/2 from the
centre of its sphere, where m = mbar |w|/rho has no direction: a step there is ill conditioned, and a little farther on there
may be none. The last step before each output is looked at.
"""
from __future__ import annotations

import ctypes

import numpy as np

from ...methods import METHODS

CHUNK = 2 ** 22         # bytes of outputs between two writes
MOST = 4096             # outputs between two writes
NEAR = 0.1              # of |W|: a midpoint nearer than that is worth a warning


class Addresses(ctypes.Structure):
    """struct smg_outputs of runtime/core/smg_outputs.h."""
    _fields_ = [*((name, ctypes.c_void_p) for name in ("t", "states", "values", "casimirs", "asked", "near")), ("pairs", ctypes.c_int64),
                ("nearest", ctypes.c_void_p), ("where", ctypes.c_void_p)]


class Block:
    """Room for `capacity` outputs of a model.

    t: shape (capacity,); states: (capacity, sites, 3), or None when they are not asked for; values: (capacity, columns)
    in the order of `Integrator.columns`, of which those in `asked` are found (None: all), the others stay NaN; casimirs: (capacity, sites), or None.
    """

    def __init__(self, model, states: bool, asked=None, casimirs: bool = True):
        numbers = model.sites * (3 * states + casimirs) + len(model.columns)
        self.asked = flags_of(model.columns, asked)
        self.capacity = max(1, min(MOST, CHUNK // (model.real.itemsize * numbers)))
        self.t = np.empty(self.capacity)
        self.states = np.empty((self.capacity, model.sites, 3), model.real) if states else None
        self.values = np.full((self.capacity, len(model.columns)), np.nan, model.real)
        self.casimirs = np.empty((self.capacity, model.sites), model.real) if casimirs else None
        self.near = np.array(spherical_parts(model), np.int64).reshape(-1, 2)
        self.nearest, self.where = np.array([np.inf]), np.array([-1, 0], np.int64)

    def addressed(self, begin: int) -> Addresses:
        """What the C takes to write from row `begin` on."""
        at = [None if a is None else a[begin:].ctypes.data for a in (self.t, self.states, self.values, self.casimirs)]
        return Addresses(*at, self.asked.ctypes.data, self.near.ctypes.data, len(self.near), self.nearest.ctypes.data, self.where.ctypes.data)

    def near_centre(self, model) -> dict | None:
        """rho (in units of |W|), site, step and t of the step nearest to a centre, if nearer than NEAR; else None."""
        rho, (site, step) = float(np.sqrt(self.nearest[0])), self.where.tolist()
        return {"rho": rho, "site": site, "step": step, "t": model.t0 + step * model.h} if rho < NEAR else None

    def seen(self) -> list | None:
        """The step nearest to a centre so far, as JSON has it: rho^2, site, step; None before one was looked at."""
        return [float(self.nearest[0]), *self.where.tolist()] if np.isfinite(self.nearest[0]) else None

    def go_on(self, seen: list | None) -> None:
        """Be where `seen` was told."""
        if seen is not None:
            self.nearest[0], self.where[:] = seen[0], seen[1:]


def flags_of(columns, asked) -> np.ndarray:
    """Of each column, is it asked for? The components of the momentum are found together."""
    momentum = asked is not None and any(name.startswith("momentum.") for name in asked)
    return np.array([asked is None or name in asked or (momentum and name.startswith("momentum.")) for name in columns], np.uint8)


def clean(rows):
    """The same numbers; the bytes of a long double that hold none of it are 0, for files hold them too."""
    return np.positive(rows, out=np.zeros_like(rows)) if rows.dtype == np.longdouble else rows


def spherical_parts(model) -> list:
    """(first, end) of the families whose midpoints are projected onto a sphere."""
    kinds = {f.name: f.kind for f in model.scene.families}
    return [(first, first + count) for name, (first, count) in model.families.items()
            if METHODS[model.method].of_midpoints and METHODS[model.method].onto_leaf and kinds[name] in ("sphere", "r3")]
