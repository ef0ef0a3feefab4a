"""What each effect of a scene is, costs, and gives up.

Operations and bytes are counted in the formulas: those of one evaluation of the gradient (of a torque, its vector; of damping, its law), all
terms of the sum together, for each site that it moves. Times are measured, of a step with the effect and without it.
"""
from __future__ import annotations

import time as clock
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from ..analyse.symmetry import explain
from ..compile.assemble.model import Model
from ..compile.derive.derivatives import derive, derive_field
from ..errors import SmidgenError
from ..language.evaluate import evaluate
from ..language.expr import Elem, Weight, slots_of
from ..language.instances import instances_of
from ..language.spec import Run, Spec
from ..read.origins import Origin
from ..run.record.conserved import of_time
from ..run.step.integrator import compiled
from ..run.step.prepared import asked, prepare

VECTOR = 24                 # bytes
LEAST, ROUNDS = 0.01, 5     # seconds of a measurement at least; how many, the least of which counts


@dataclass(frozen=True)
class Row:
    """called: by the run; operations, bytes: for a site; ns, without: of a step with it and without it, None where there is none;
    lost: what is given up -> why."""
    effect: str
    called: bool
    kind: str
    source: str
    operations: float | None = None
    bytes: float | None = None
    ns: float | None = None
    without: float | None = None
    lost: Mapping[str, str] | None = None


def effects_table(spec: Spec, origins: Mapping[str, Origin], run: str | None = None, *, method: str | None = None, solver: str | None = None,
                  effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None, times: bool = True) -> list[Row]:
    """A row for each effect of the spec and of its bases; times: measure, too. The other arguments as for `build`."""
    one = asked(spec, run, method, solver, effects, parameters)
    called = tuple(one.effects or spec.effect_names)
    clockwork = Clockwork(spec, one, times)
    return [row_of(spec, one, called, name, origin, clockwork) if name in spec.effect_names else Row(name, False, origin.kind, origin.source)
            for name, origin in origins.items()]


def row_of(spec, one, called, name, origin, clockwork) -> Row:
    numbers = prepare(spec, one.method, None, dict(one.parameters), one.solver).numbers
    effect = next(e for e in spec.effects if e.name == name)
    operations, moved = counts(effect, numbers, {f.name for f in spec.families if f.tracer})
    having, lacking = tuple({*called, name}), tuple(x for x in called if x != name)
    return Row(name, name in called, origin.kind, origin.source, operations, moved, clockwork.ns(having), clockwork.ns(lacking),
               {**given_up(spec, one, effect), **slower(spec, one, having, lacking)})


# Counted

def counts(effect, numbers, tracers) -> tuple[float, float]:
    """(operations, bytes) for each site that it moves; what holds sites moves none."""
    if effect.work is not None:
        return effect.work
    d = derive(effect) if effect.conservative else derive_field(effect, effect.slots, effect.value)
    number = len(next(iter(instances_of(effect.over, numbers.values, numbers.places)[0].values()), [0]))
    rows = {slot: row for slot, row in zip(d.slots, d.gradient) if any(x != 0 for x in row)}
    if carried := {slot: row for slot, row in rows.items() if slot[0] in tracers}:
        rows = carried
    share = number / max(1, sum(numbers.places[family][1] for family in {family for family, _ in rows}))
    return share * sum(operations(row, d.parts) for row in rows.values()), share * sum(moved_bytes(row, d) for row in rows.values())


def operations(row, parts) -> int:
    """Those of one vector, common parts once, and of its addition to the sum; signs are free."""
    common, rest = sp.cse([*row, *parts.values()])
    return sum(unsigned(e) for e in [*(e for _, e in common), *rest]) + sum(x != 0 for x in row)


def unsigned(e) -> int:
    said = sp.sympify(sp.count_ops(e, visual=True))
    return int(said.subs({s: 0 if s.name == "NEG" else 1 for s in said.free_symbols}))


def moved_bytes(row, d) -> int:
    """The vectors and entries of arrays that one gradient reads, and the vector that it adds to."""
    free = set().union(*(x.free_symbols for x in row))
    read = sum(bool(free & set(v)) for v in d.vectors)
    return VECTOR * (read + 1) + 8 * sum(isinstance(d.leaves.get(s.name), (Elem, Weight)) for s in free)


# Measured

class Clockwork:
    """Times of steps, each scene once."""

    def __init__(self, spec: Spec, one: Run, times: bool):
        self.spec, self.one, self.times, self.known = spec, one, times and one.h is not None and bool(spec.starts), {}

    def ns(self, effects: tuple) -> float | None:
        """Nanoseconds a step; None where there is no such scene, or its steps fail."""
        if not self.times or not effects:
            return None
        key = frozenset(effects)
        if key not in self.known:
            try:
                self.known[key] = self.measured([e for e in self.spec.effect_names if e in key])
            except SmidgenError:
                self.known[key] = None
        return self.known[key]

    def measured(self, effects) -> float:
        model = compiled(prepare(self.spec, self.one.method, effects, dict(self.one.parameters), self.one.solver))
        h = float(evaluate(self.one.h, model.prepared.numbers.values))
        model.start(self.one.start, h=h).steps(20)
        begun, count, taken = model.save(), 16, []
        while not taken or taken[-1] < LEAST:
            count *= 2
            taken.append(seconds(model, begun, count))
        return 1e9 * min([taken[-1], *(seconds(model, begun, count) for _ in range(ROUNDS - 1))]) / count


def seconds(model, begun, count: int) -> float:
    """Of the processor. The steps are those from the state `begun`."""
    model.restore(begun).advance(0)
    began = clock.thread_time()
    model.steps(count)
    return clock.thread_time() - began


# Given up

def given_up(spec, one, effect) -> dict[str, str]:
    """What this effect alone takes from a motion by energies that rotations and time leave unchanged."""
    if effect not in spec.energies:
        return effect.lost
    lost = {"energy": "depends on the time"} if of_time(spec, {effect.name}) else {}
    about = turned_about(spec, one, effect)
    if len(about) < 3:
        kept = " and ".join(f"({', '.join(f'{x:.3g}' for x in axis)})" for axis in about)
        lost["momentum"] = f"conserved only along {kept}" if kept else "this energy has no rotational symmetry"
    return lost


def turned_about(spec, one, effect) -> np.ndarray:
    """The axes about which all sites may turn together, for this energy alone."""
    found = explain(replace(spec, effects=spec.energies), one.name or None, effects=[effect.name], parameters=dict(one.parameters))
    named = {family for family, _ in slots_of(effect.value)}
    whole = [np.asarray(axes).reshape(-1, 3) for families, axes in found.rotations if named <= set(families)]
    return max(whole, key=len, default=np.empty((0, 3)))


def slower(spec, one, having, lacking) -> dict[str, str]:
    """The layout that steps without it have, and with it have not."""
    try:
        before, after = layout(spec, one, lacking), layout(spec, one, having)
    except SmidgenError:
        return {}
    return {"layout": f"{before} without it, {after} with it"} if after == "sites" != before else {}


def layout(spec, one, effects) -> str:
    prepared = prepare(spec, one.method, [e for e in spec.effect_names if e in effects], dict(one.parameters), one.solver)
    return Model(prepared.scene, prepared.plan).plan.layout


# Shown

def table(rows):
    """A rich Table."""
    from rich.markup import escape
    from rich.table import Table
    found = Table(caption="operations and bytes are those of the gradient for each moving site; ns is the time of a step")
    for column in ("effect", "used", "kind", "operations", "bytes", "ns with", "ns without", "lost", "source"):
        found.add_column(column, overflow="fold", justify="right" if column in ("operations", "bytes", "ns with", "ns without") else "left")
    for row in rows:
        numbers = ("" if x is None else f"{x:,.4g}" if x < 1e4 else f"{x:,.0f}" for x in (row.operations, row.bytes, row.ns, row.without))
        lost = "; ".join(f"{what}: {why}" for what, why in (row.lost or {}).items())
        found.add_row(row.effect, "yes" if row.called else "no", row.kind, *numbers, escape(lost), escape(row.source))
    return found
