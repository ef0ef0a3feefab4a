"""A run as it would be taken with a step h: does it come to its end, and through which states?"""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .trial import Failure, failure_of

WORK = 200_000          # sites times steps of one orbit
STEPS = 20_000          # the most
FEWEST = 4              # steps of however many sites
STATES = 256            # that are kept on the way


@dataclass(frozen=True)
class Orbit:
    """h; count: the steps that succeeded; places: (t, w) on the way, the start first and the last state last;
    failure: of the step after the last, or None; whole: was the whole run looked at?"""
    h: float
    count: int
    places: tuple
    failure: Failure | None
    whole: bool

    @property
    def end(self) -> float:
        """The last time."""
        return self.places[-1][0]


def orbit(model, w, t: float, h: float, span: float) -> Orbit:
    """Steps of h from (t, w) on, for the time `span` or as many as the work allows, up to the first that fails."""
    wanted, allowed = math.ceil(span / abs(h) - 1e-9), longest(model)
    count = min(wanted, allowed)
    model.start(np.array(w, model.real), t0=t, h=h)
    places, failure = [(t, np.array(w))], None
    for mark in _marks(count, model.sites):
        model.advance(mark - model.count)
        places.append((model.t, model.state()))
        if model.count < mark:
            failure = failure_of(model.failure(), h)
            break
    return Orbit(h, model.count, tuple(places), failure, wanted <= allowed)


def _marks(count: int, sites: int):
    """After how many steps a state is kept: all of them, or some that are evenly spaced."""
    kept = min(count, STATES, max(FEWEST, WORK // sites))
    return [round(count * (k + 1) / kept) for k in range(kept)]


def longest(model) -> int:
    """The most steps of an orbit."""
    return min(STEPS, max(FEWEST, WORK // model.sites))
