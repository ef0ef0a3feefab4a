"""First steps of the generated code itself: what the continuation says is tried before it is said."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import RunError

TRIES = 16          # steps between a sixteenth of an h and h
LOWEST = 2.0 ** -20     # of the cap: below, no step is looked for


@dataclass(frozen=True)
class Failure:
    """A first step that failed: its h, and what was said; reached: the largest h that seems to exist."""
    h: float
    message: str
    reached: float
    sites: tuple


def first_step(model, w, t: float, h: float):
    """None when the first step of size h succeeds, else the Failure."""
    try:
        model.start(np.array(w, model.real), t0=t, h=h).step()
    except RunError as error:
        part = error.reached if 0 < error.reached < 1 else 0.0
        sites = tuple(s for s in (error.site, error.partner) if s >= 0)
        said = str(error).partition(": ")[2].partition(" (")[0]
        return Failure(abs(h), said, part * abs(h), sites)
    return None


def first_failure(model, w, t: float, h: float):
    """The first Failure among `TRIES` steps from h/16 up to h, or None."""
    for part in np.geomspace(1 / 16, 1, TRIES):
        failure = first_step(model, w, t, h * part)
        if failure is not None:
            return failure
    return None


def climb(model, w, t: float, cap: float, sign: float):
    """(largest h below the first failure, the Failure or None) by trial from small h up to the cap."""
    good, h = 0.0, cap / 64
    while good == 0.0 and h > LOWEST * cap and (bad := first_step(model, w, t, sign * h)) is not None:
        h /= 4
    bad = None
    while bad is None and good < cap:
        h = min(cap, max(h, 1.3 * good))
        bad = first_step(model, w, t, sign * h)
        good = good if bad is not None else h
    for _ in range(5 if bad is not None and good > 0 else 0):
        middle = (good + bad.h) / 2
        failure = first_step(model, w, t, sign * middle)
        good, bad = (good, failure) if failure is not None else (middle, bad)
    return good, bad
