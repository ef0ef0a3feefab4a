"""The error of a run, estimated from a second run that is more or less accurate by a known factor (Richardson; Hairer,
Norsett, Wanner, II.4).

Two runs to the same time T with steps h and g end at w + C h^p and w + C g^p, to leading order. So the first one is off by
their difference times h^p/abs(g^p - h^p).
    Orders 2 and 4: half as many steps, half the time of the run; where so large a step does not exist, twice as many.
    Higher orders: so many more steps that the error falls to an eighth, 8^(1/p) times the time of the run. The difference is
    then the error but for an eighth of it, even where h is too large for the leading term to rule.
    Step control: the same, and a tolerance 32 times as small, up to 32^(1/p) times the time. The error goes with the tolerance,
    or with h where h is so small that it is the step.
Round-off, which the difference does not show, is added as eps sqrt(N).
"""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from ..errors import RunError
from ..methods import METHODS
from .integrator import Integrator
from .pace import Pace

LOW = 4             # orders up to this: the second run takes half as many steps
FINER = 8           # of higher ones: as small a part of the error is left in the second run
TIGHTER = 32        # with step control: as small a part of the tolerance; more than FINER, so that h alone cannot be what is left
TOLERANCE = {"double": 1e-12, "long double": 1e-15}     # of step control unless asked for: SMG_TOLERANCE of its header


@dataclasses.dataclass(frozen=True)
class Second:
    """The other run: steps, tolerance, and its error in units of that of the first."""
    steps: int
    tolerance: float | None
    error: float


def end_error(model: Integrator, settings, final: np.ndarray, stopped=lambda: False) -> float | None:
    """The largest distance of a site of `final`, (sites, 3), from the exact solution, in units of the largest |w|.

    model: the compiled model of the run; it is begun anew. None where no second run gets to the end, and after
    Ctrl-C (`stopped`).
    """
    size = float(np.linalg.norm(final, axis=1).max())
    for second in seconds(model, settings):
        end = ended(model, settings, second, stopped)
        if end is not None:
            off = float(np.linalg.norm(final - end, axis=1).max()) / size
            return off / abs(second.error - 1) + float(np.finfo(final.dtype).eps) * math.sqrt(settings.steps)
        if stopped():
            return None
    return None


def seconds(model: Integrator, settings) -> list[Second]:
    """The second runs to try, one after the other."""
    method, steps, tolerance = METHODS[model.method], settings.steps, settings.tolerance
    if not steps:
        return []
    finer = max(steps + 1, math.ceil(steps * FINER ** (1 / method.order)))
    if method.controlled:
        return [Second(finer, (tolerance or TOLERANCE[settings.real]) / TIGHTER, 1 / FINER)]
    counts = ((steps + 1) // 2, 2 * steps) if method.order <= LOW else (finer,)
    return [Second(n, tolerance and tolerance * min(1, steps / n), (steps / n) ** method.order) for n in counts if n != steps]


def ended(model: Integrator, settings, second: Second, stopped) -> np.ndarray | None:
    """Its end; None where a step fails."""
    pace = Pace()
    try:
        model.start(settings.own_start, h=settings.h * settings.steps / second.steps, seed=settings.seed, tolerance=second.tolerance)
        while model.count < second.steps:
            asked = min(second.steps - model.count, pace.size)
            if stopped() or pace.timed(model.advance, asked) < asked:
                return None
        return model.state()
    except RunError:
        return None
