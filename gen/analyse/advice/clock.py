"""An H that depends on time: when is it strongest, and how fast does it change?

The field b of two states that do not move, the start and a turned one, is sampled over the whole run. A pulse is seen
when it is longer than the spacing of the samples. How fast b changes follows from the samples (`pace.py`), and from a few
that are closer together, since a modulation may be faster than their spacing.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...chance import generator
from ...language.expr import timed
from .equation import StepEquation
from .pace import CLOSER, FOUR, Pace, together

SAMPLES = 16, 4096      # the least and the most times that are looked at
WORK = 1_000_000        # sites times samples between them
MOMENTS = 16            # times at which the field is strongest, one for a site or fewer
CLOSE = 4, 64           # the least of closer samples for each of their spacings, and how many others go with one of them
GOLDEN = (5 ** 0.5 - 1) / 2


@dataclass(frozen=True)
class Clock:
    """spacing: of the times looked at; moments: the times at which the field of a site is strongest; change: the angular
    frequency of the fastest modulation of a field that was found, 1/time; abrupt: does a field change faster than could be resolved?"""
    spacing: float
    moments: tuple
    change: float
    abrupt: bool


def is_timed(scene) -> bool:
    """Does H, or a torque, depend on t?"""
    return any(timed(*e.formulas.values()) for e in scene.effects)


def clock(equation: StepEquation, span: float) -> Clock | None:
    """The Clock of the run of length `span` >= 0 from the state of the equation; None: H does not depend on time."""
    if not (span and is_timed(equation.model.scene)):
        return None
    count = int(np.clip(WORK // len(equation.w), *SAMPLES))
    times = equation.t + equation.sign * span * np.linspace(0, 1, count)
    spacing, found = span / (count - 1), [_sampled(equation.field, w, times) for w in (equation.w, _turned(equation.w))]
    best = {float(times[k]): size for moments, sizes, _ in found for k, size in zip(moments, sizes)}
    moments = sorted(best, key=best.get, reverse=True)[:MOMENTS]
    return Clock(spacing, tuple(sorted(moments)), *together([pace for *_, paces in found for pace in paces]))


def _sampled(field, w, times):
    """(index of the time at which the field of each site is largest, that field, the Pace at each spacing)."""
    best, where, pace = np.zeros(len(w)), np.zeros(len(w), int), Pace(times[1] - times[0], times[-1])
    block = int(np.clip(WORK // SAMPLES[0] // len(w), 1, SAMPLES[0]))
    for first in range(0, len(times), block):
        fields = _fields(field, w, times[first:first + block + FOUR - 1])
        sizes = np.linalg.norm(fields, axis=-1)
        where = np.where(sizes.max(axis=0) > best, first + sizes.argmax(axis=0), where)
        best = np.maximum(best, sizes.max(axis=0))
        pace.add(fields)
    moving = best > 0
    return where[moving], best[moving], [pace, *(_closer(field, w, times, pace.spacing / part) for part in CLOSER)]


def _closer(field, w, times, spacing) -> Pace:
    """The Pace of a few groups of samples with a smaller spacing, at times that are in step with no modulation."""
    pace, least, others = Pace(spacing, times[-1]), *CLOSE
    for k in range(max(least, len(times) // others)):
        begin = times[0] + k * GOLDEN % 1 * (times[-1] - times[0])
        pace.add(_fields(field, w, begin + spacing * np.arange(FOUR)))
    return pace


def _fields(field, w, times):
    """The field of every site at these times, 0 where it is not finite; shape (times, sites, 3)."""
    return np.nan_to_num([field.at(w, t) for t in times], posinf=0, neginf=0)


def _turned(w):
    """Each vector turned by an angle of its own, always the same."""
    axes = generator("a second start").standard_normal(w.shape)
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    along = np.sum(axes * w, axis=1)[:, None] * axes
    return 2 * along - w        # half a turn
