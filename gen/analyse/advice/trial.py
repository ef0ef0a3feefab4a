"""First steps of the generated code itself: what the continuation says is tried before it is said."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import RunError

TRIES = 16, 400     # the least and the most steps between a sixteenth of an h and h
TRIED = 20_000      # sites times tries between them
LOWEST = 2.0 ** -20     # of the cap: below, no step is looked for


@dataclass(frozen=True)
class Failure:
    """A step that failed: its h, and what was said; reached: the largest h that exists there, 0 when that is not known."""
    h: float
    message: str
    reached: float
    sites: tuple

    @property
    def limit(self) -> float:
        """The largest h that seems to exist."""
        return self.reached or self.h / 1.2


def failure_of(error: RunError, h: float) -> Failure:
    """What a step of size h said."""
    part = error.reached if 0 < error.reached <= 1 else 0.0
    sites = tuple(s for s in (error.site, error.partner) if s >= 0)
    return Failure(abs(h), str(error).partition(": ")[2].partition(" (")[0], part * abs(h), sites)


def first_step(model, w, t: float, h: float):
    """None when the first step of size h succeeds, else the Failure."""
    try:
        model.start(np.array(w, model.real), t0=t, h=h).step()
    except RunError as error:
        return failure_of(error, h)
    return None


def first_failure(model, w, t: float, h: float):
    """The first Failure among evenly spaced steps from h/16 up to h, or None."""
    for part in np.linspace(1 / 16, 1, int(np.clip(TRIED // model.sites, *TRIES))):
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
    if bad is not None and bad.reached > good:
        return bad.reached, bad
    for _ in range(5 if bad is not None and good > 0 else 0):
        middle = (good + bad.h) / 2
        failure = first_step(model, w, t, sign * middle)
        good, bad = (good, failure) if failure is not None else (middle, bad)
    return good, bad
