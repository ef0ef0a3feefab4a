"""The fastest local rate of a state: what a step has to resolve."""
from __future__ import annotations

import math

import numpy as np

from ...extremes import with_largest
from .equation import Nowhere, StepEquation

UNKNOWNS = 150          # up to here with all of J; beyond, from the field alone
EVALUATIONS = 2000      # of the field, for the rates of all the states that are looked at
FINE = 1e-3             # relative error of the phase of the fastest motion, at the h that is called fine
SAMPLES = 10            # steps in a period of the modulation of H, with that h


def local_rate(equation: StepEquation) -> float:
    """The fastest rate at the state, 1/time: sqrt(r^2 + v^2), r the spectral radius of DX P' in the tangent
    planes and v the largest |X|/|w|. A spin at an angle a to a field B has r = B cos a, v = B sin a, and turns
    with the rate B. For many sites the largest field."""
    w = equation.w
    y = np.linalg.norm(equation.rate(w, 0.0), axis=1)
    if w.size > UNKNOWNS:
        return strength(equation, w, equation.t)
    spins = np.max(np.abs(np.linalg.eigvals(equation.slope(w, 0.0))))
    moves = np.max(y / np.where(equation.length > 0, equation.length, 1))
    return float(np.hypot(spins, moves))


def strength(equation: StepEquation, w, t: float) -> float:
    """The largest field of a site, times the norm of its Casimir; 0 where it is not finite."""
    size = np.linalg.norm(equation.field.at(w, t), axis=1)
    return float(np.max(np.nan_to_num(size * np.linalg.norm(equation.casimir, 2, axis=(1, 2)), posinf=0)))


def fastest(equation: StepEquation, places) -> tuple:
    """(the fastest local rate, its t) of the places (t, w) with the strongest fields, as many as the work allows."""
    each = 1 if equation.w.size > UNKNOWNS else 1 + 2 * equation.w.size
    known = sorted(((strength(equation, w, t), t, k) for k, (t, w) in enumerate(places)), reverse=True)
    found = [(0.0, equation.t)]
    for _, t, k in known[:max(4, EVALUATIONS // each)]:
        try:
            found.append((local_rate(equation.of(places[k][1], t)), t))
        except Nowhere:
            continue
    return with_largest(found, key=lambda rate: rate[0])


def fine_step(rate: float, change: float) -> float | None:
    """The h > 0 at which the phase of the fastest motion has an error of FINE, and a period of the modulation of H has SAMPLES steps."""
    limits = (math.sqrt(12 * FINE), rate), (math.tau / SAMPLES, change)
    return min((float(turn / pace) for turn, pace in limits if pace > 0), default=None)
