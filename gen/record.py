"""What a run records: columns, the buffers that collect them, and the largest errors."""
from __future__ import annotations

import math

import numpy as np

from .errors import UsageError
from .integrator import Integrator
from .nearness import Nearest
from .output import RESERVED

CHUNK = 2 ** 22         # bytes of outputs between two writes


class Recorder:
    """Collects outputs in buffers and hands them to the sinks; keeps the errors' extremes."""

    def __init__(self, model, layout, sinks):
        self.model, self.sinks, self.rows, self.begun = model, sinks, 0, False
        self.capacity = max(1, min(4096, CHUNK // entry_size(layout)))
        self.buffers = {n: np.empty((self.capacity, *shape), kind)
                        for n, (shape, kind) in layout.items()}
        self.state = model.state()
        self.values, self.casimirs = model.values(), model.casimirs()
        self.errors = Extremes(model, self.values, self.casimirs)
        self.nearest = Nearest(model)
        self.substeps = []          # (step, t, k) of steps taken as 2^k smaller ones
        self.picks = [(n, f) for n, f in outputs_of(model).items() if n in layout]
        self.states = any(f in layout for f in model.families)

    def record(self) -> None:
        """One output: the present step."""
        self.begun = True
        self.model.values(self.values)
        self.model.casimirs(self.casimirs)
        self.errors.see(self.values, self.casimirs)
        self.nearest.see(self.model)
        if self.sinks:
            self._fill(self.rows)
            self.rows += 1
            if self.rows == self.capacity:
                self.flush()

    def _fill(self, row):
        model, buffers = self.model, self.buffers
        buffers["step"][row], buffers["t"][row] = model.count, model.t
        if self.states:
            model.state(self.state)
        for name, pick in self.picks:
            buffers[name][row] = pick(self)

    def split(self, k: int) -> None:
        """The step to the present state was taken as 2^k smaller ones."""
        self.substeps.append((self.model.count, self.model.t, k))

    def facts(self) -> dict:
        """What a resumed run must know beside the state and the rows."""
        return {"largest": self.errors.largest, "substeps": self.substeps}

    def go_on(self, facts: dict) -> None:
        """Be where `facts` were taken."""
        self.begun = True
        self.errors.largest, self.substeps = dict(facts["largest"]), [tuple(row) for row in facts["substeps"]]

    def flush(self) -> None:
        """Hand the buffered outputs on."""
        chunk = {name: rows[:self.rows] for name, rows in self.buffers.items()}
        for sink in self.sinks:
            sink.write(chunk)
        self.rows = 0


class Extremes:
    """The largest deviations of energy, momentum and Casimirs from their first values."""

    def __init__(self, model, values, casimirs):
        self.first, self.c0 = values.copy(), casimirs.copy()
        self.momentum = [k for k, n in enumerate(model.columns) if n.startswith("momentum.")]
        self.largest = {"energy": 0.0, "momentum": 0.0, "casimirs": 0.0}

    def see(self, values, casimirs) -> None:
        """Compare one output with the first."""
        change = abs(values - self.first)
        self._raise("energy", change[0])
        self._raise("momentum", change[self.momentum].max())
        self._raise("casimirs", abs(casimirs - self.c0).max())

    def _raise(self, what, value):
        if not value <= self.largest[what]:         # NaN must not be lost
            self.largest[what] = float(value)


def entry_size(layout: dict) -> int:
    """Bytes of one output."""
    return sum(kind.itemsize * math.prod(shape) for shape, kind in layout.values())


def outputs_of(model) -> dict:
    """column -> function that takes it from a Recorder's present values."""
    at = {name: k for k, name in enumerate(model.columns)}
    found = {}
    for family, (first, count) in model.families.items():
        found[family] = lambda r, a=first, b=first + count: r.state[a:b]
        k = at[f"momentum.{family}.x"]
        found[f"momentum.{family}"] = lambda r, k=k: r.values[k:k + 3]
    for name, k in at.items():
        if not name.startswith("momentum."):
            found[name] = lambda r, k=k: r.values[k]
    found["casimirs"] = lambda r: r.casimirs
    return found


def columns_of(model: Integrator, what) -> dict:
    """Layout of the outputs: column -> (shape of one entry, dtype)."""
    named = {"step": ((), np.dtype(np.int64)), "t": ((), np.dtype(np.float64))}
    real, scene = model.real, model.scene
    if "states" in what:
        named.update({f: ((count, 3), real) for f, (_, count) in model.families.items()})
    if "energy" in what:
        named["energy"] = ((), real)
        named.update({f"energy.{e.name}": ((), real) for e in scene.effects})
    if "momentum" in what:
        named.update({f"momentum.{f}": ((3,), real) for f in model.families})
    if "casimirs" in what:
        named["casimirs"] = ((model.sites,), real)
    _distinct([*model.families, *(o.name for o in scene.observables)])
    named.update({o.name: ((), real) for o in scene.observables if o.name in what})
    return named


def _distinct(names):
    for k, name in enumerate(names):
        if name in RESERVED or name in names[:k]:
            raise UsageError(f"'{name}' already names another column of the results; "
                             "call the family or observable something else")
