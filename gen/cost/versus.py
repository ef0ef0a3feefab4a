"""The best methods beside the general integrators, at equal errors, as ratios of times from one table."""
from __future__ import annotations

import math
from dataclasses import dataclass

from ..methods import METHODS
from .frontier import TARGETS, first, keeps_energy, symplectic
from .peers import PEERS
from .report import Cost, duration, label

KINDS = ("symplectic", "energy to round-off", "of all")


@dataclass(frozen=True)
class Cell:
    """The time that something takes for an error; name: of the method."""
    name: str
    seconds: float


def best(cost: Cost, what: str, targets=TARGETS) -> dict[str, list[Cell]]:
    """Of each kind of promise, the fastest method for each error (`what`: end_error or energy)."""
    exact = keeps_energy(cost.rows, float(cost.facts["energy"]))
    lets = {"symplectic": symplectic, "energy to round-off": lambda name: name in exact, "of all": lambda name: name in METHODS}
    rows = {kind: [r for r in cost.rows if kind != "energy to round-off" or r.tolerance != r.tolerance] for kind in KINDS}
    return {kind: [Cell(*first(rows[kind], what, t, lets[kind])) for t in targets] for kind in KINDS}


def others(cost: Cost, what: str, targets=TARGETS) -> dict[str, list[Cell]]:
    """The same of each general integrator that was measured."""
    there = [name for name in PEERS if any(r.method == name for r in cost.rows)]
    return {name: [Cell(*first(cost.rows, what, t, lambda n, name=name: n == name)) for t in targets] for name in there}


def table(cost: Cost, what: str, targets=TARGETS) -> str:
    """Markdown: times of the best, and of each general integrator its time as a multiple of theirs, in the order of KINDS."""
    own, beside = best(cost, what, targets), others(cost, what, targets)
    lines = ["| | " + " | ".join(f"{t:.0e}" for t in targets) + " |", "|---|" + "---|" * len(targets)]
    for kind, cells in own.items():
        lines.append(f"| best, {kind} | " + " | ".join(f"{label(c.name)} {duration(c.seconds)}" if c.name else "-" for c in cells) + " |")
    for name, cells in beside.items():
        said = [" / ".join(times(cell, own[kind][k]) for kind in KINDS) if cell.name else "does not get there" for k, cell in enumerate(cells)]
        lines.append(f"| {label(name)} | " + " | ".join(said) + " |")
    return "\n".join(lines)


def times(cell: Cell, of: Cell) -> str:
    """How many times as long the first takes."""
    return f"{cell.seconds / of.seconds:.2g}" if of.name else "-"


def behind(cost: Cost, what: str, targets=TARGETS) -> list[str]:
    """Where a general integrator is ahead of the best symplectic method, in words."""
    own, found = best(cost, what, targets)["symplectic"], []
    for name, cells in others(cost, what, targets).items():
        for target, cell, mine in zip(targets, cells, own):
            if cell.name and not cell.seconds >= mine.seconds:
                needs = f"{cell.seconds / mine.seconds:.2f} of the time of {label(mine.name)}" if mine.name else "no symplectic method reaches it"
                found.append(f"{label(name)} at {target:.0e}: {needs}")
    return found


def summary(tables: dict[str, Cost], what: str = "end_error", targets=TARGETS) -> str:
    """Markdown, a row a table: the fastest method for each error, and how many times as long as the best symplectic method the
    fastest general integrator takes."""
    lines = ["| | " + " | ".join(f"{t:.0e}" for t in targets) + " |", "|---|" + "---|" * len(targets)]
    for name, cost in tables.items():
        own, beside = best(cost, what, targets), list(others(cost, what, targets).values())
        lines.append(f"| {name} | " + " | ".join(f"{label(c.name)} {duration(c.seconds)}" if c.name else "-" for c in own["of all"]) + " |")
        if beside:
            quickest = [min((row[k] for row in beside if row[k].name), key=lambda c: c.seconds, default=Cell("", math.nan)) for k in range(len(targets))]
            lines.append("| | " + " | ".join(f"{label(c.name)} {times(c, own['symplectic'][k])}" if c.name else "-" for k, c in enumerate(quickest)) + " |")
    return "\n".join(lines)
