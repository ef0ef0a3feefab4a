"""Casimirs: every w stays on its sphere or on its leaf C = c.

One step in extended precision tells whether the method keeps them; the run in double, after every step
k, whether round-off does not pile up: it may reach a few ulps of a random walk, sqrt(k).
"""
from __future__ import annotations

import numpy as np

from ...extremes import largest
from .case import EPS, LONG_EPS, Case
from .row import Row, at_most, refused

ULPS = 8


def casimirs(case: Case, subject) -> list[Row]:
    """The worst Casimir error in ulps, of the run after k steps over sqrt(k)."""
    if case.path is None:
        return [refused("casimirs", "the run ended before its last step")]
    steps = np.arange(1, len(case.path))
    many = float(np.max(changed(case, case.path[0], case.path[1:]) / (EPS * np.sqrt(steps))))
    one = largest(*(changed(case, case.long(w), subject.step(case.long(w), t, h)) for w, t, h in case.trials())) / LONG_EPS
    return [at_most("casimirs", largest(many, one), ULPS, f"{one:.2g} ulp for one step in extended precision, "
                    f"{many:.2g} ulp sqrt(N) over {len(steps)} steps")]


def changed(case: Case, before, after):
    """Largest relative change of a Casimir; relative to |w|^2 where C may vanish. Leading axes of `after` are kept."""
    leaves = case.leaves
    return np.max(np.abs(leaves.values(after) - leaves.values(before)) / leaves.sizes(before), axis=-1)
