"""Casimirs: every w stays on its sphere or on its leaf C = c.

One step in extended precision tells whether the method keeps them; many steps in double, whether
round-off does not pile up: it may reach a few ulps of a random walk, sqrt(N).
"""
from __future__ import annotations

import math

import numpy as np

from ..errors import RunError
from .case import EPS, LONG_EPS, Case
from .row import Row, at_least, at_most, refused

ULPS = 8
STEPS = {"quick": 1000, "normal": 10000}


def casimirs(case: Case, subject) -> list[Row]:
    """The run's own first steps, and the worst Casimir error in ulps, over sqrt(N) of N steps."""
    count = min(STEPS.get(case.settings_tier, STEPS["normal"]), max(case.settings.steps, 1))
    try:
        end = subject.run(case.w[None], 0.0, case.h, [count])[0, 0]
    except RunError as error:
        return [refused("steps", str(error)), refused("casimirs", "the run ended early")]
    many = changed(case, case.w.astype(float), end) / (EPS * math.sqrt(count))
    one = max(changed(case, case.long(w), subject.step(case.long(w), t, h)) for w, t, h in case.trials()) / LONG_EPS
    return [at_least("steps", count, count),
            at_most("casimirs", max(many, one), ULPS, f"{one:.2g} ulp of one step in extended precision, "
                    f"{many:.2g} ulp sqrt(N) of {count} steps")]


def changed(case: Case, before, after) -> float:
    """Largest relative change of a Casimir; relative to |w|^2 where C may vanish."""
    leaves = case.leaves
    gap = np.abs(leaves.values(after) - leaves.values(before))
    return float(np.max(gap / leaves.sizes(before)))
