"""After how many steps a choice has paid for its compiler: beside a general integrator that needs none, and beside the next method."""
from __future__ import annotations

import math

import numpy as np

from .measure.case import Case
from .measure.reference import Reference
from .measure.sweep import Row

GENERAL = ("scipy", "gsl-rk8pd")    # the first of them that is there: SciPy's needs no compiler; GSL's is compiled once for all
LIMIT = 2.0         # seconds: a general integrator that takes longer is left out
TRIES = 4           # tolerances tried
TIGHTER = 0.1       # than the one before, the first than the error asked for


def general(case: Case, asked: dict, known: Reference) -> Row | None:
    """A run of a general integrator that meets what was asked for; None where there is none, or none that is quick enough."""
    from .peers import of_case
    from .peers.rows import one
    for name in GENERAL:
        case.peers, _ = of_case(case, (name,))
        tolerance = min(asked.values())
        for _ in range(TRIES if case.peers else 0):
            tolerance *= TIGHTER
            row = one(case, name, known, tolerance, LIMIT)
            if row.status:
                break
            if all(getattr(row, what) <= value for what, value in asked.items()):
                return row
    return None


def steps_until_even(row: Row, other: Row, ready: bool) -> float:
    """Steps of `row` after which its compiler's time is earned back; ready: the other one needs no compiler, or is compiled already.
    0 where it is not slower to compile; infinite where it is not faster."""
    spent = row.compiled - (0 if ready or other.compiled != other.compiled else other.compiled)
    gained = other.seconds - row.seconds
    if spent <= 0:
        return 0 if gained >= 0 else math.inf
    return float(np.ceil(spent / gained)) * row.steps if gained > 0 else math.inf
