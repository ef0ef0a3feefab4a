"""What the rows say: the least time of each method for an error, and who is first."""
from __future__ import annotations

import math

import numpy as np

from ..methods import METHODS
from .measure.sweep import Row

TARGETS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
EXACT = 16 * 2.0 ** -52     # an energy error of one step that is round-off, relative to |H| or 1; of N steps sqrt(N) of it


def seconds_for(rows: list[Row], what: str, error: float) -> float:
    """The time in which a method gets below `error` (`what`: end_error, energy, ..): between two neighbours by a straight
    line of the logarithms, or with a smaller step that takes less time; nan where it never does. The shorter one of its runs to
    round-off and of those to a tolerance."""
    kinds = [[r for r in rows if (r.tolerance == r.tolerance) is loose] for loose in (False, True)]
    times = [x for x in (seconds_along(kind, what, error) for kind in kinds) if x == x]
    return min(times, default=math.nan)


def seconds_along(rows: list[Row], what: str, error: float) -> float:
    """The same along rows of one kind."""
    good = sorted((r for r in rows if not r.status and getattr(r, what) == getattr(r, what)), key=lambda r: (r.steps, -r.tolerance))
    there = next((k for k, row in enumerate(good) if getattr(row, what) <= error), None)
    if there is None:
        return math.nan
    met = good[there].seconds if there == 0 else between(good[there - 1], good[there], what, error)
    return min([met, *(row.seconds for row in good[there:] if getattr(row, what) <= error)])


def between(a: Row, b: Row, what: str, error: float) -> float:
    """The time at which the line through two rows has this error."""
    x, y = (math.log(max(getattr(r, what), 1e-300)) for r in (a, b))
    part = (x - math.log(error)) / (x - y) if x != y else 1.0
    return math.exp(math.log(a.seconds) + part * (math.log(b.seconds) - math.log(a.seconds)))


def by_method(rows: list[Row]) -> dict[str, list[Row]]:
    """method -> its rows."""
    found = {}
    for row in rows:
        found.setdefault(row.method, []).append(row)
    return found


def frontier(rows: list[Row], what: str = "end_error", targets=TARGETS) -> dict[str, list[float]]:
    """method -> its time for each target."""
    return {name: [seconds_for(own, what, target) for target in targets] for name, own in by_method(rows).items()}


def first(rows: list[Row], what: str, error: float, only=lambda name: True) -> tuple[str, float]:
    """The fastest method for an error of those that `only` lets in, and its time; ("", nan) where none gets there."""
    times = {name: seconds_for(own, what, error) for name, own in by_method(rows).items() if only(name)}
    good = {name: t for name, t in times.items() if t == t}
    return min(good.items(), key=lambda item: item[1]) if good else ("", math.nan)


def symplectic(name: str) -> bool:
    """As the registry says."""
    return name in METHODS and METHODS[name].symplectic


def keeps_energy(rows: list[Row], scale: float) -> set[str]:
    """The methods whose energy errors are round-off with every step that got to the end, iterated to round-off."""
    judged = by_method([r for r in rows if not r.status and r.tolerance != r.tolerance and r.energy == r.energy])
    return {name for name, own in judged.items() if all(r.energy <= EXACT * max(scale, 1) * np.sqrt(r.steps) for r in own)}
