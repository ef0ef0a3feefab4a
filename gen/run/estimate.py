"""The error of a run, estimated from two more runs that are more and less accurate by known factors (Richardson; Hairer,
Norsett, Wanner, II.4).

A run to the time T with steps of h ends at w + C h^p, to leading order. Another one with steps of g ends off it by the error
of the run times abs(1 - (g/h)^p). The finer run gives the estimate, and the coarser one the proof that errors do fall as h^p:
where it says an error more than twice as large or as small, there is no estimate.
    Orders 2 and 4: half and twice as many steps, 2.5 times the steps of the run. Of a single step: two and four parts.
    Higher orders: so many more and fewer steps that the error is an eighth and eightfold, 8^(1/p) + 8^(-1/p) times the steps.
    Step control: the same, with a tolerance 32 times as small and 8 times as large. The error goes with the tolerance, or with
    h where h is so small that it is the step; so the coarser run may be worse than eightfold, but not better.
Round-off, which the difference does not show, is added as eps sqrt(N). Differences of its size prove nothing, and stand.
"""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from ..errors import RunError
from ..language.spec import LOOSEST
from ..methods import METHODS
from .step.integrator import Integrator
from .step.pace import Pace

LOW = 4             # orders up to this: half and twice as many steps
FINER = 8           # of higher ones: as small a part of the error is left in the finer run
AGREE = 2           # two estimates agree within this factor
ROUND_OFF = 100     # times eps sqrt(N): differences below it are of round-off
TIGHTER = 32        # with step control: as small a part of the tolerance; more than FINER, so that h alone cannot be what is left
TOLERANCE = {"double": 1e-12, "long double": 1e-15}     # of step control unless asked for: SMG_TOLERANCE of its header


@dataclasses.dataclass(frozen=True)
class Other:
    """Another run: steps, tolerance, and its error in units of that of the first."""
    steps: int
    tolerance: float | None
    error: float


def end_error(model: Integrator, settings, final: np.ndarray, stopped=lambda: False) -> tuple[float | None, str | None]:
    """(error, reason): the largest distance of a site of `final`, (sites, 3), from the exact solution, in units of the
    largest |w| of the sites that are there, or None and why it is not estimated.

    model: the compiled model of the run; it is begun anew. Both are None for no steps and after Ctrl-C (`stopped`).
    """
    if model.scene.heated:
        return None, "with thermal noise, a different number of steps is a different trajectory"
    off, found, there = [], others(model, settings), model.prepared.numbers.present
    size = np.linalg.norm(final[there], axis=1).max() or 1
    for other in found:
        end = ended(model, settings, other, stopped)
        if end is None:
            return None, None if stopped() else f"with {other.steps} steps instead of {settings.steps}, a step fails"
        off.append(float(np.linalg.norm((final - end)[there], axis=1).max() / size))
    return judged(METHODS[model.method], settings.steps, found, off, float(np.finfo(final.dtype).eps)) if found else (None, None)


def judged(method, steps: int, found: list[Other], off: list[float], eps: float) -> tuple[float | None, str | None]:
    """(error, reason) from the distances `off` of the other ends, the check first."""
    check, error = (d / abs(other.error - 1) for d, other in zip(off, found, strict=True))
    round_off = eps * math.sqrt(steps)
    small = error < ROUND_OFF * round_off or method.controlled and check == 0       # or h is the step, and fewer there are not
    if small or error <= AGREE * check and (method.controlled or check <= AGREE * error):
        return error + round_off, None
    said = [f"{other.steps} steps changed it by {d:.2g}" for d, other in zip(off, found, strict=True)]
    law = "step control" if method.controlled else f"order {method.order}"
    ratio = abs((found[0].error - 1) / (found[1].error - 1))
    return None, f"{' and '.join(said)}, but {law} predicts a ratio of {ratio:.2g} (the step is too large, the motion is chaotic, or H is not smooth)"


def others(model: Integrator, settings) -> list[Other]:
    """The two runs beside the first: the one that checks, and the finer one that gives the estimate."""
    method, steps, tolerance = METHODS[model.method], settings.steps, settings.tolerance
    if not steps:
        return []
    factor = FINER ** (1 / method.order)
    fewer, more = max(1, min(steps - 1, int(steps / factor))), max(steps + 1, math.ceil(steps * factor))
    if method.controlled:
        aim = tolerance or TOLERANCE[settings.real]
        return [Other(fewer, min(LOOSEST, aim * FINER), FINER), Other(more, aim / TIGHTER, 1 / FINER)]
    if method.order <= LOW:
        fewer, more = (steps + 1) // 2, 2 * steps
    counts = (fewer if fewer < steps else 2 * more, more)
    return [Other(n, tolerance and tolerance * min(1, steps / n), (steps / n) ** method.order) for n in counts]


def ended(model: Integrator, settings, other: Other, stopped) -> np.ndarray | None:
    """Its end; None where a step fails."""
    pace = Pace()
    try:
        model.start(settings.own_start, h=settings.h * settings.steps / other.steps, seed=settings.seed, tolerance=other.tolerance)
        while model.count < other.steps:
            asked = min(other.steps - model.count, pace.size)
            if stopped() or pace.timed(model.advance, asked) < asked:
                return None
        return model.state()
    except RunError:
        return None
