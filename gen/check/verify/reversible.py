"""Time reversal: a step of h from t and one of -h from t + h return to where they began.

In both precisions: a defect that double precision hides is two thousand times larger in units
of the last place of extended precision.
"""
from __future__ import annotations

import math

import numpy as np

from ...chance import generator
from ...extremes import largest
from ...methods import METHODS
from .case import Case, ulp
from .row import Row, at_most

ULPS = 32


def reversible(case: Case, subject) -> list[Row]:
    """The worst return of all states, steps and precisions, in ulps of the largest component."""
    found = largest(*(returned(subject, x, t, short(h))
                      for w, t, h in case.trials() for x in (w, case.long(w))))
    note = "" if METHODS[case.settings.method].symmetric or found <= ULPS else "the method is not symmetric"
    return [at_most("reversible", found, ULPS, note)]


def short(h: float, bits: int = 24) -> float:
    """h rounded so that t + h is exact at the times of a case: the way back begins there."""
    fraction, power = math.frexp(h)
    return math.ldexp(round(math.ldexp(fraction, bits)), power - bits)


def returned(subject, w, t, h) -> float:
    """How far from w one ends, in ulps; the inverse map may stretch round-off."""
    there = subject.step(w, t, h)
    back = subject.step(there, t + h, -h)
    return float(np.abs(back - w).max()) / (ulp(w) * stretch(subject, w, there, t, h))


def stretch(subject, w, there, t, h, nudge=1e-6) -> float:
    """How much a step stretches small distances, there or back; at least 1."""
    found = 1.0
    dice = generator("stretching")
    for begin, time, step in ((w, t, h), (there, t + h, -h)):
        near = tilted(begin, nudge, dice)
        apart = np.abs(subject.step(near, time, step) - subject.step(begin, time, step)).max()
        found = largest(found, apart / np.abs(near - begin).max())
    return found


def tilted(w, angle, dice):
    """All of w turned a little, each site about an axis of its own: |w| stays."""
    axes = dice.standard_normal(w.shape).astype(w.dtype)
    axes /= np.sqrt(np.sum(axes * axes, axis=1))[:, None]
    c, s = np.cos(w.dtype.type(angle)), np.sin(w.dtype.type(angle))
    return c * w + s * np.cross(axes, w) + (1 - c) * np.sum(axes * w, axis=1)[:, None] * axes
