"""Random numbers for analysis: every generator of numpy is made here.

A start is drawn from the seed by language/draws.py. If a measurement drew its directions from the same numbers, a tangent
vector would be parallel to w, a rotation about it would leave w where it is. So all uses here have another generator,
Philox4x64, and a key of their own for each use.
"""
from __future__ import annotations

import numpy as np

from .errors import UsageError

# use -> its part of the key; a number is never given twice
USES = {
    "tangent vectors": 1,           # analyse/lyapunov.py
    "a second start": 2,            # analyse/advice/clock.py
    "symmetries": 3,                # analyse/symmetry/look.py
    "values modulo a prime": 4,     # analyse/symmetry/modular.py
    "conserved momentum": 5,        # run/record/conserved.py
    "validate": 6,                  # check/validate.py
    "verify": 7,                    # check/verify/case.py
    "times": 8,                     # check/verify/case.py
    "stretching": 9,                # check/verify/reversible.py
    "sizes of integrals": 10,       # check/verify/integrals.py
    "cancellation": 11,             # check/verify/residual.py
    "a field by hand": 12,          # cost/peers/by_hand.py
    "points of a leaf": 13,         # show/demo/experiments.py
    "round-off of a predictor": 14, # check/verify/effort.py
    "beginnings of iterations": 15, # check/verify/effort.py
    "jumps": 16,                    # analyse/symmetry/jumps.py
}


def generator(use: str, seed: int = 0) -> np.random.Generator:
    """A generator for one of USES, always the same for one seed. Raises KeyError for another use, UsageError for a seed that is
    no integer of 0 or more."""
    if not (isinstance(seed, (int, np.integer)) and seed >= 0):
        raise UsageError(f"the seed must be a non-negative integer, not {seed!r}")
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(seed, spawn_key=(USES[use],))))
