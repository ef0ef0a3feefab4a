"""What a run records: columns, the buffers that collect them, and the largest deviations."""
from __future__ import annotations

import math

import numpy as np

from ...errors import UsageError
from ...extremes import largest
from .conserved import conserved_axes, driven, energy_of, momentum_of, round_off_of_momentum, with_tracers
from ..step.integrator import Integrator
from ..files.output import RESERVED
from ..step.block import Block, clean
from .computed import SHAPES, computed_columns, functions_of

LARGE = 100         # times the energies at the start: an energy that is worth a word where a step fails
COMPARED = ("energy", "momentum", "casimirs")      # with the first output


class Recorder:
    """Collects outputs in blocks and hands them to the sinks; keeps the largest deviations.

    span: how long the run is; means: takes averages of all outputs, or None; settings: of a run, whose first and last outputs alone are kept where they name none.
    """

    def __init__(self, model, layout, sinks, span: float, means=None, settings=None):
        self.means, self.every = means, 1 if settings is None else settings.every
        self.ends = None if settings is None or settings.what else (0, settings.steps // settings.every * settings.every)
        self.model, self.sinks, self.count, self.begun = model, sinks, 0, False
        self.computed = functions_of(model, layout)
        asked = asked_of(model, layout, () if means is None else means.names)
        self.block = Block(model, bool(self.computed) or any(f in layout for f in model.families), asked, "casimirs" in layout)
        self.steps = np.empty(self.block.capacity, np.int64)
        entries = outputs_of(model, self.block)
        self.columns = {name: entries[name] for name in layout if name in entries}
        self.deviations = Deviations(model, model.values(), model.casimirs(), span, layout)
        gone = ~model.prepared.numbers.present      # in no output: their vectors are 0
        self.gone = np.flatnonzero(gone) if gone.any() else None
        self.substeps = []          # (step, t, k) of steps taken as 2^k smaller ones

    @property
    def capacity(self) -> int:
        """Outputs between two writes."""
        return self.block.capacity

    @property
    def room(self) -> int:
        """Outputs until the next write."""
        return self.capacity - self.count

    def take(self, first: int, every: int, count: int) -> int:
        """Up to `count` outputs, one after `first` steps and then one every `every` steps; returns how many steps were done.

        first = 0 is an output of the present state.
        """
        before, begin = self.model.count, self.count
        done = self.model.outputs(first, every, self.block, begin, count)
        self.steps[begin:begin + done] = before + first + every * np.arange(done)
        new = slice(begin, begin + done)
        if self.block.states is not None:
            self.without_absent(self.block.states[new])
        if done:
            self.begun = True
            self.deviations.see(self.block.values[new], None if self.block.casimirs is None else self.block.casimirs[new])
            if self.means is not None:
                self.means.see(self.steps[new] // self.every, self.block.values[new])
        self.count += done if self.sinks else 0
        if not self.room:
            self.flush()
        return self.model.count - before

    def without_absent(self, w: np.ndarray) -> np.ndarray:
        """States (.., sites, 3) as outputs have them: 0 at sites that are not there."""
        if self.gone is not None:
            w[..., self.gone, :] = 0
        return w

    def split(self, k: int) -> None:
        """The step to the present state was taken as 2^k smaller ones."""
        self.substeps.append((self.model.count, self.model.t, k))

    def look_at_end(self) -> None:
        """The deviations of the present state, of what the outputs do not hold."""
        self.deviations.see_end(self.model.values()[None], self.model.casimirs()[None])

    def facts(self) -> dict:
        """What a resumed run must know beside the state and the rows."""
        return {**self.deviations.facts(), "substeps": self.substeps, "nearest": self.block.seen(), **({} if self.means is None else {"means": self.means.statistics.facts()})}

    def go_on(self, facts: dict) -> None:
        """Be where `facts` were taken."""
        self.begun = True
        self.deviations.go_on(facts)
        self.substeps = [tuple(row) for row in facts["substeps"]]
        self.block.go_on(facts.get("nearest"))
        if self.means is not None:
            self.means.statistics.go_on(facts["means"])

    def flush(self) -> None:
        """Hand the buffered outputs on."""
        chunk = {"step": self.steps[:self.count], "t": self.block.t[:self.count],
                 **{name: clean(rows[:self.count]) for name, rows in self.columns.items()},
                 **{name: of(self.block.states[:self.count]) for name, of in self.computed.items()}}
        if self.ends is not None:
            chunk = {name: rows[np.isin(self.steps[:self.count], self.ends)] for name, rows in chunk.items()}
        for sink in self.sinks if len(chunk["step"]) else ():
            sink.write(chunk)
        self.count = 0


class Deviations:
    """The largest deviations from the first output: errors of what is conserved, changes of the rest.

    span: how long the run is; layout: the columns of its outputs: what they do not hold is compared at the end alone. Which energy and
    momentum are meant, and what of them is conserved, says conserved.py; with one output there is nothing to compare.
    """

    def __init__(self, model, values, casimirs, span: float, layout):
        self.scene, self.columns, self.c0, self.outputs = model.scene, model.columns, casimirs.copy(), 0
        self.held = {name for name in COMPARED if any(column.split(".")[0] == name for column in layout)}
        self.without, self.driven = with_tracers(model.scene), driven(model.scene)
        self.axes, self.largest = conserved_axes(model, span), {}
        self.grain, self.first = round_off_of_momentum(model), values.copy()
        self.energy, self.momentum = self._of(values[None])

    def _of(self, values):
        """(energies (k,) or None, momenta (k, 3)) of k outputs."""
        named = dict(zip(self.columns, values.T))
        rows = {f"momentum.{f.name}": np.stack([named[f"momentum.{f.name}.{x}"] for x in "xyz"], -1) for f in self.scene.families}
        return energy_of(named, self.without), momentum_of(rows, self.scene)

    def see(self, values, casimirs) -> None:
        """Compare k outputs with the first: values (k, columns), Casimirs (k, sites), of what they hold."""
        self.outputs += len(values)
        self._compare(self.held, values, casimirs)

    def see_end(self, values, casimirs) -> None:
        """Compare the last state, as one output, in what outputs do not hold."""
        self._compare(set(COMPARED) - self.held, values, casimirs)

    def _compare(self, names, values, casimirs):
        energy, momentum = self._of(values)
        if "energy" in names and energy is not None:
            self._raise("changes" if self.driven else "errors", "energy", energy - self.energy)
        if "momentum" in names and not all(f.tracer for f in self.scene.families):
            self._momentum(momentum - self.momentum)
        if "casimirs" in names:
            self._raise("errors", "casimirs", casimirs - self.c0)

    def _momentum(self, change):
        """Its part in the conserved directions, and the rest."""
        along = change @ self.axes.T
        if len(self.axes):
            self._raise("errors", "momentum", self._above_round_off(along))
        if len(self.axes) < 3:
            self._raise("changes", "momentum", self._above_round_off(change - along @ self.axes))

    def _above_round_off(self, change):
        """0 for less than the momentum can tell; NaN stays."""
        return np.where(np.abs(change) < self.grain, 0, change)

    def _raise(self, kind, name, change):
        found = self.largest.setdefault(kind, {})
        found[name] = largest(found.get(name, 0.0), abs(change).max())

    def grown(self, values) -> str:
        """What is said of the effect whose energy in `values` is LARGE times all energies at the start; "" where none is."""
        of = [k for k, name in enumerate(self.columns) if name.startswith("energy.")]
        start = max((abs(self.first[k]) for k in of), default=0.0)
        k = max(of, key=lambda k: abs(values[k]), default=None)
        if k is None or not LARGE * start < abs(values[k]) < math.inf or not start:
            return ""
        return (f"; the energy of effect '{self.columns[k].removeprefix('energy.')}' is {values[k]:.3g} here, {self.first[k]:.3g} at the start: "
                "H may be singular near this state or time")

    def summary(self) -> dict:
        """errors and changes: name -> the largest one; axes: the directions (k, 3) along which the momentum is conserved; without: the effects that
        the energy leaves out; at_end: the names whose deviation is that of the last state."""
        found = self.largest if self.outputs > 1 else {}
        return {"errors": found.get("errors", {}), "changes": found.get("changes", {}), "axes": self.axes.tolist(), "without": sorted(self.without),
                "at_end": [name for name in COMPARED if name not in self.held]}

    def facts(self) -> dict:
        """What a resumed run must know."""
        return {"outputs": self.outputs, "largest": self.largest}

    def go_on(self, facts: dict) -> None:
        """Be where `facts` were taken."""
        self.outputs, self.largest = facts["outputs"], facts["largest"]


def asked_of(model, layout, more) -> set:
    """Columns of the model that the outputs of a layout are made of, and some more."""
    return {name for name in model.columns if name in layout or name in more or name.rpartition(".")[0] in layout and name.startswith("momentum.")}


def entry_size(layout: dict) -> int:
    """Bytes of one output."""
    return sum(kind.itemsize * math.prod(shape) for shape, kind in layout.values())


def outputs_of(model, block) -> dict:
    """column -> its entries in a block of outputs."""
    at = {name: k for k, name in enumerate(model.columns)}
    found = {name: block.values[:, k] for name, k in at.items() if not name.startswith("momentum.")}
    for family, (first, count) in model.families.items():
        found[family] = None if block.states is None else block.states[:, first:first + count]
        k = at[f"momentum.{family}.x"]
        found[f"momentum.{family}"] = block.values[:, k:k + 3]
    return {**found, "casimirs": block.casimirs}


def columns_of(model: Integrator, what) -> dict:
    """Layout of the outputs: column -> (shape of one entry, dtype)."""
    named = {"step": ((), np.dtype(np.int64)), "t": ((), np.dtype(np.float64))}
    real, scene = model.real, model.scene
    if "states" in what:
        named.update({f: ((count, 3), real) for f, (_, count) in model.families.items()})
    if "energy" in what:
        named["energy"] = ((), real)
        named.update({f"energy.{e.name}": ((), real) for e in scene.energies})
    if "momentum" in what:
        named.update({f"momentum.{f}": ((3,), real) for f in model.families})
    if "casimirs" in what:
        named["casimirs"] = ((model.sites,), real)
    named.update({name: (SHAPES[name.split(".")[0]], real) for name in computed_columns(model, what)})
    _distinct([*model.families, *(o.name for o in scene.observables)])
    named.update({o.name: ((), real) for o in scene.observables if o.name in what})
    return named


def _distinct(names):
    for k, name in enumerate(names):
        if name in RESERVED or name in names[:k]:
            raise UsageError(f"'{name}' is already the name of another column of the results; rename the family or observable")
