"""The error of a run, estimated from the same run with other steps (Richardson; Hairer, Norsett, Wanner, II.4).

Two runs to the same time T with steps h and g end at w + C h^p and w + C g^p, to leading order. So the first one is off by
their difference times h^p/abs(g^p - h^p). The second run takes half as many steps, half the time of the run; where so large a
step does not exist it takes twice as many. Round-off, which the difference does not show, is added as eps sqrt(N).
"""
from __future__ import annotations

import numpy as np

from ..errors import RunError
from ..methods import METHODS
from .integrator import Integrator
from .pace import Pace


def end_error(model: Integrator, settings, final: np.ndarray, stopped=lambda: False) -> float | None:
    """The largest distance of a site of `final`, (sites, 3), from the exact solution, in units of the largest |w|.

    model: the compiled model of the run; it is begun anew. None where no other step gets to the end, where the method
    takes steps of its own, and after Ctrl-C (`stopped`).
    """
    method, steps = METHODS[model.method], settings.steps
    if method.controlled or not steps:
        return None
    size = float(np.linalg.norm(final, axis=1).max())
    for other in ((steps + 1) // 2, 2 * steps):
        end = None if other == steps else ended(model, settings, other, stopped)
        if end is not None:
            off = float(np.linalg.norm(final - end, axis=1).max()) / size
            return off / abs((steps / other) ** method.order - 1) + float(np.finfo(float).eps * np.sqrt(steps))
        if stopped():
            return None
    return None


def ended(model: Integrator, settings, steps: int, stopped) -> np.ndarray | None:
    """The end with that many steps; None where one fails."""
    pace = Pace()
    try:
        model.start(settings.start, h=settings.h * settings.steps / steps, seed=settings.seed, tolerance=settings.tolerance)
        while model.count < steps:
            asked = min(steps - model.count, pace.size)
            if stopped() or pace.timed(model.advance, asked) < asked:
                return None
        return model.state()
    except RunError:
        return None
