"""The questions put to the algebra, each within its own bounds; no answer is None, never a guess."""
from __future__ import annotations

import functools
from dataclasses import dataclass, field

from ...errors import UsageError
from ...run.step.evaluated import Evaluated, parameter_values, sizes
from . import conserved
from .formulas import NotDecided
from .orbits import orbits, written_out
from .polynomial import Budget, TooMuch
from .torque import Torques, torques


@dataclass
class Asked:
    """A selected spec and its torques in the readings that are needed.

    now: with the values of the run; written: the same term by term, for small systems; always:
    with parameters as symbols; off: without |w|^2 = r^2, where a method looks at points that
    are off the sphere. Each may be None: too much work.
    """
    spec: object
    values: dict
    places: dict
    now: Torques | None
    written: Torques | None
    always: Torques | None
    off: Torques | None
    answers: dict = field(default_factory=dict)

    @functools.cached_property
    def present(self):
        """Is each site there? Shape (sites,)."""
        return Evaluated(self.spec, self.values).present

    @property
    def families(self) -> list:
        return [f.name for f in self.spec.families]


def ask(spec, values: dict, on_sphere: bool) -> Asked:
    """All readings of a selected spec."""
    numbers, places = parameter_values(spec, values), sizes(spec, values)
    tables = {name: numbers[name] for name, _ in spec.tables}
    sums, terms = orbits(spec.energies), written_out(spec.energies, numbers, places)

    def read(which, given, sphere):
        return None if which is None else attempt(lambda: torques(spec, which, given, tables, Budget(), sphere))
    now = read(sums, numbers, True)
    if now is None:                     # the other readings are no easier
        return Asked(spec, numbers, places, None, None, None, None)
    return Asked(spec, numbers, places, now, read(terms, numbers, True), read(sums, None, True),
                 read(terms or sums, numbers, on_sphere))


def attempt(question):
    """The answer, or None when it takes too much work or leaves what the algebra knows."""
    try:
        return question()
    except (TooMuch, NotDecided, UsageError, RecursionError, OverflowError):
        return None


def space(asked: Asked, key, rows, size: int, most=None):
    """The null space of rows(torques): orbit by orbit, then of the writing-out where there is one.

    key: what is asked, so that it is worked out once; most: how large the space can be at most,
    where that is known: once it is reached nothing more is tried.
    """
    if key not in asked.answers:
        best = None if asked.now is None else _null_space(asked.now, rows, size)
        if asked.written is not None and (best is None or most is None or len(best) < most):
            more = _null_space(asked.written, rows, size)
            best = max((f for f in (best, more) if f is not None), key=len, default=None)
        asked.answers[key] = best
    return asked.answers[key]


def _null_space(found: Torques, rows, size: int):
    found.algebra.budget = Budget()
    return attempt(lambda: conserved.null_space(found.algebra, rows(found), size))


def holds(found: Torques | None, rows, vector) -> bool:
    """Is the combination conserved in this reading, proved?"""
    if found is None:
        return False
    found.algebra.budget = Budget()
    return bool(attempt(lambda: conserved.vanishes(found.algebra, rows(found), vector)))
