"""The advice for a run: an h with which it completes, and with a margin, as far as the work allows to look.

Two orbits are looked at, with the h itself and with a smaller one; from each of the states kept on the way, and around
the times at which H is strongest, a step of ROOM h must exist, and h may turn the fastest motion once around. Where
that fails, h is lowered to what exists there, and all is looked at again.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace

from .orbit import Orbit, longest, orbit
from .rates import fastest
from .trial import Failure, first_step

MARGIN = 0.85           # of the limits that are found
ROOM = 1.15             # times h: a step that exists from every state; a little less than 1/MARGIN
TURN = 2 * math.pi      # h times the fastest rate at the cap: one rotation a step
FINER = 4               # parts of h: a smaller step, where the run has none of its own
ROUNDS = 24             # of lowering h
LOWERED = 0.97          # at most, each time
LEAST = 1e-3            # of the first h: below, it is hardly the step that ends the run
FASTER = 1.01           # a rate that is faster by less is the same


@dataclass(frozen=True)
class Refusal:
    """A state from which a step fails: where, what the step said."""
    t: float
    w: object
    failure: Failure


@dataclass(frozen=True)
class Look:
    """h > 0; orbits: those looked at; rate, rate_t: the fastest local rate and its time; refusal: what lowered h last, or
    None; failing: the time at which a step still fails that should exist, or beyond which nothing was seen of it; or None."""
    h: float
    orbits: tuple
    rate: float
    rate_t: float
    refusal: Refusal | None = None
    failing: float | None = None


def along(model, equation, h: float, known: tuple, span: float, own: float, clock) -> Look:
    """The Look of a run of length `span` from the state of `equation`. h: from the start; known: the fastest rate known
    before, and its time; own: the run's |h|, or 0; clock: of an H that depends on time."""
    least, refusal = LEAST * h, None
    for _ in range(ROUNDS):
        orbits = _orbits(model, equation, h, span, own)
        places = [place for o in orbits for place in o.places]
        found, at = fastest(equation, places + _moments(orbits[0], clock, 0.0))
        found, at = (found, at) if found > FASTER * known[0] else known
        look = Look(h, orbits, found, at, refusal)
        lower, more = TURN / found if found * h > FASTER * TURN else h, None
        if lower == h:
            more = _refusal(model, equation, look, places, clock)
            if more is None:
                return replace(look, failing=_unseen(equation, look))
            lower = min(MARGIN * more.failure.limit, LOWERED * h)
        failing = more.t if more else at
        if lower < least:
            break
        h, refusal = lower, more or refusal
    return replace(look, failing=failing)


def _unseen(equation, look):
    """The time of the refusal, where no orbit came so far again; else None."""
    came = max(equation.sign * o.end for o in look.orbits)
    return look.refusal.t if look.refusal and equation.sign * look.refusal.t > came else None


def _orbits(model, equation, h, span, own) -> tuple:
    """With h, and with a smaller one: the run's own, or as small as lets the work allow the whole run."""
    fine = min(max(own if 0 < own < h else h / FINER, span / longest(model)), h)
    return tuple(orbit(model, equation.w, equation.t, equation.sign * step, span) for step in dict.fromkeys((h, fine)))


def _moments(o: Orbit, clock, lead: float) -> list:
    """(t - lead, w) of the times at which H is strongest, with the last state before of the orbit."""
    forward = 1 if o.h > 0 else -1
    return [(t - lead, [w for at, w in o.places if forward * (t - at) >= 0][-1]) for t in (clock.moments if clock else ())]


def _refusal(model, equation, look, places, clock):
    """The first state from which a step fails that should exist, or None."""
    for o in look.orbits:
        if o.failure is not None:
            t, w = o.places[-1]
            return Refusal(t, w, first_step(model, w, t, o.h) or o.failure)
    step = equation.sign * look.h * ROOM
    for t, w in places + _moments(look.orbits[0], clock, step / 2):
        failure = first_step(model, w, t, step)
        if failure is not None:
            return Refusal(t, w, failure)
    return None
