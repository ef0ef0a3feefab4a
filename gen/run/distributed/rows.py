"""The outputs of a distributed run: each rank writes its part of them, and of checkpoints, to the files of the store."""
from __future__ import annotations

import os
import time as clock

import numpy as np

from ... import ranks
from ...errors import UsageError
from ...extremes import largest
from ...language.held import absent
from ...language.places import on_lattice, placed_on
from ...language.spec import Lattice
from ..files.output import RESERVED, result_of
from ..files.places import write_at
from ..record.conserved import driven, energy_of, with_tracers
from ..record.record import columns_of
from ..run import describe
from ..step.evaluated import per_site
from .store import on_all, on_first


class Rows:
    """The outputs of a distributed run: each rank writes its vectors, rank 0 numbers. Keeps the largest deviation of the energy."""

    def __init__(self, model, settings, store):
        self.model, self.settings, self.store = model, settings, store
        self.layout, self.count, self.seconds, self.first, self.largest = columns_of(model, settings.what), 0, 0.0, None, 0.0
        if named := next((f for f in model.families if f in RESERVED), None):
            raise UsageError(f"'{named}' is already the name of another column of the results; rename the family")
        self.family = next(iter(model.families))
        over = placed_on(model.spec, self.family)
        self.over = over if isinstance(over, Lattice) else None
        self.gone = absent(model.scene, self.family)        # a condition, or None

    def arrays(self) -> dict:
        """name -> (shape, dtype) of all that the file has."""
        rows = self.settings.steps // self.settings.every + 1 if self.settings.what else 2
        whole = ((self.model.sites, 3), self.model.real)
        extras = {"final": whole, **({"positions": ((self.model.sites, 3), np.dtype(float))} if self.over else {})}
        return {**{name: ((rows, *shape), kind) for name, (shape, kind) in self.layout.items()}, **extras}

    def begin(self, newest) -> None:
        """A new file, or the one that was being written."""
        model, store = self.model, self.store
        if newest is None:
            self.places = on_first(store, lambda: store.create(describe(model, self.settings), self.arrays()))
            on_all(store, store.open)
            return
        self.count, self.seconds, self.first, self.largest = newest["rows"], newest["seconds"], newest["first"], newest["largest"]
        self.places = ranks.on_first(lambda: store.places(self.arrays()))
        state = ranks.on_all(lambda: store.found(lambda: np.memmap(store.state(newest["count"]), model.real, "r")))
        on_all(store, store.open)
        model.restore(state)

    def is_due(self, step: int) -> bool:
        """Is there an output of this step that has not been written?"""
        every = self.settings.every if self.settings.what else self.settings.steps or 1
        return step % every == 0 and step // every == self.count

    def take(self) -> None:
        """One output of the present state."""
        values = dict(zip(self.model.columns, self.model.values())) if set(self.layout) - {"step", "t", self.family} else {}
        energy = energy_of(values, with_tracers(self.model.scene)) if "energy" in self.layout else None
        if energy is not None:
            self.first = float(energy) if self.first is None else self.first
            self.largest = float(largest(self.largest, abs(energy - self.first)))
        on_all(self.store, lambda: self.write(values))
        self.count += 1

    def write(self, values: dict) -> None:
        """This rank's part of a row."""
        if self.family in self.layout:
            self.put(self.family, self.places[self.family].row(self.count))
        momentum = f"momentum.{self.family}"
        numbers = {**values, "step": self.model.count, "t": self.model.t, momentum: [values.get(f"{momentum}.{x}") for x in "xyz"]}
        for name, (_, kind) in self.layout.items() if ranks.first() else ():
            if name != self.family:
                write_at(self.store.handle, np.asarray(numbers[name], kind), self.places[name].row(self.count))

    def put(self, name: str, offset: int) -> None:
        """Vectors of this rank's sites in an array of all, 0 at sites that are not there."""
        model, part = self.model, self.model.part
        for first, count in [(model.first, len(part))] if self.gone is None else model.windows():
            vectors = part[first - model.first:][:count]
            if self.gone is not None:
                vectors = np.where(per_site(self.gone, model.prepared.numbers.values, count, first)[:, None], 0, vectors)
            write_at(self.store.handle, vectors, offset + 3 * first * self.places[name].kind.itemsize)

    def save(self, seconds: float) -> None:
        """A checkpoint: the rows and the state of all ranks are on the disk before it counts."""
        store, count = self.store, self.model.count
        on_all(store, lambda: (store.write_state(self.model), os.fsync(store.handle)))
        facts = {"count": count, "rows": self.count, "seconds": seconds, "first": self.first, "largest": self.largest,
                 "checkpoint": self.settings.checkpoint}
        on_first(store, lambda: self.count_on(facts))

    def count_on(self, facts) -> None:
        self.store.put("newest.json", facts)
        for old in self.store.folder.glob("state-*.bin"):
            if old != self.store.state(facts["count"]):
                old.unlink()

    def close(self, status: str, began: float):
        """The last state and the metadata; the file gets its name."""
        model, keep = self.model, status == "interrupted" and bool(self.settings.checkpoint)
        if keep:
            self.save(clock.perf_counter() - began)
        else:
            on_all(self.store, self.write_last)
        meta = {**describe(model, self.settings, status), "estimate": False}
        t, halved = model.t, model.halved
        model.close()
        columns = list(self.layout)
        on_first(self.store, lambda: self.store.finish(meta, self.count, columns, keep))
        facts = {"t": t, "halved": halved, "seconds": clock.perf_counter() - began}
        return result_of(meta, {"step": np.empty(0, np.int64), "t": np.empty(0)}, {**self.summary(), **facts})

    def summary(self) -> dict:
        """As that of other runs; of deviations only that of the energy over the outputs is known."""
        kind = "changes" if driven(self.model.scene) else "errors"
        nothing = {"errors": {}, "changes": {}, "axes": [], "without": [], "at_end": [], "by_rows": None, "in_parts": 0, "nearest": None}
        return {**nothing, **({kind: {"energy": self.largest}} if self.count > 1 and self.first is not None else {})}

    def write_last(self) -> None:
        """What no row has: the last state, and where sites stand."""
        self.put("final", self.places["final"].offset)
        sites = self.over.sites if self.over else 1
        for first, count in self.model.windows() if self.over else ():
            found = on_lattice(self.over, self.model.prepared.numbers.values, first // sites, -(-(first + count) // sites))
            write_at(self.store.handle, found[first % sites:][:count], self.places["positions"].row(first))
        os.fsync(self.store.handle)
