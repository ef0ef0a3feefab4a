"""An H that depends on time: when is it strongest, and how fast does it change?

The field b of two states that do not move, the start and a turned one, is sampled over the whole run. A pulse is seen
when it is longer than the spacing of the samples.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...chance import generator
from ...extremes import largest
from ...language.expr import Time, walk
from .equation import StepEquation

SAMPLES = 16, 4096      # the least and the most times that are looked at
WORK = 1_000_000        # sites times samples between them
MOMENTS = 16            # times at which the field is strongest, one for a site or fewer


@dataclass(frozen=True)
class Clock:
    """spacing: of the times looked at; moments: the times at which the field of a site is strongest; change: the largest
    |db/dt| of a site over its largest |b|, 1/time."""
    spacing: float
    moments: tuple
    change: float


def is_timed(scene) -> bool:
    """Does H, or a torque, depend on t?"""
    return any(isinstance(node, Time) for e in scene.effects for formula in e.formulas.values() for node in walk(formula))


def clock(equation: StepEquation, span: float) -> Clock | None:
    """The Clock of the run of length `span` >= 0 from the state of the equation; None: H does not depend on time."""
    if not (span and is_timed(equation.model.scene)):
        return None
    count = int(np.clip(WORK // len(equation.w), *SAMPLES))
    times = equation.t + equation.sign * span * np.linspace(0, 1, count)
    spacing, found = span / (count - 1), [_sampled(equation.model, w, times, span / (count - 1))
                                          for w in (equation.w, _turned(equation.w))]
    best = {float(times[k]): size for moments, sizes, _ in found for k, size in zip(moments, sizes)}
    moments = sorted(best, key=best.get, reverse=True)[:MOMENTS]
    return Clock(spacing, tuple(sorted(moments)), largest(*(change for *_, change in found)))


def _sampled(model, w, times, spacing):
    """(index of the time at which each site's |b| is largest, that |b|, the largest relative change)."""
    best, where, change, before = np.zeros(len(w)), np.zeros(len(w), int), np.zeros(len(w)), None
    for k, t in enumerate(times):
        b = np.nan_to_num(np.asarray(model.field(w, t), float), posinf=0, neginf=0)
        size = np.linalg.norm(b, axis=1)
        where[size > best] = k
        best = np.maximum(best, size)
        if before is not None:
            change = np.maximum(change, np.linalg.norm(b - before, axis=1) / spacing)
        before = b
    moving = best > 0
    return where[moving], best[moving], float(np.max(change[moving] / best[moving], initial=0.0))


def _turned(w):
    """Each vector turned by an angle of its own, always the same."""
    axes = generator("a second start").standard_normal(w.shape)
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    along = np.sum(axes * w, axis=1)[:, None] * axes
    return 2 * along - w        # half a turn
