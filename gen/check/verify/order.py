"""The observed order, by halving: of one step in extended precision, and of a run against the flow.

One step. E(h) = |step_h - step_h/2 o step_h/2| is O(h^{p+1}) for order p. In extended precision it
can be followed down to h about 1e-5, where a first-order term shows even when it is a hundred
thousand times smaller than the rest: time frozen within the step, a weak term treated otherwise.
It is looked at where dX/dt is largest in the run, since a frozen time hides where dX/dt = 0.

Flow. The same halving at a fixed time, against the exact solution by the independent interpreter:
the step is consistent with the spec's equation, and not just with itself.
"""
from __future__ import annotations

import math
from operator import itemgetter

import numpy as np

from ...errors import RunError
from ...extremes import smallest, with_smallest
from ...methods import METHODS
from .case import LONG_EPS, Case, size
from .row import Row, at_least, not_applicable

SLACK = 0.1             # of order 2, in proportion of others: an observed order is off by terms of higher order and by round-off
RESOLVED = 500          # ulps of extended precision below which an error is round-off
HALVINGS = 40
FLOW_ERROR = 1e-9       # errors below measure the reference flow, good to about 1e-13
FLOW_HALVINGS = 12
STEPS = 8


def order(case: Case, subject) -> list[Row]:
    """One row: the worst of all states of one step, and of the flow."""
    if METHODS[case.settings.method].controlled:
        return [not_applicable("order", "the method chooses its own steps to meet a tolerance")]
    local = [(one_step(case, subject, w, t), t) for w, t in case.points]
    flow = against_flow(case, subject)
    claimed = METHODS[case.settings.method].order
    known = [(p, t) for p, t in local if p is not None]
    worst, t = with_smallest(known, itemgetter(0)) if known else (None, 0.0)
    both = [p for p in (worst, flow) if p is not None]
    if not both:
        return [Row("order", None, "", None, "yes", "exact: errors at round-off for every h")]
    notes = [f"{worst:.3f} of one step at t = {t:.4g}" if known else "one step is exact",
             f"{flow:.3f} against the flow" if flow is not None else "exact against the flow"]
    return [at_least("order", smallest(*both), claimed * (1 - SLACK / 2), "; ".join(notes))]


def one_step(case: Case, subject, w, t) -> float | None:
    """Observed order between the finest two halvings that round-off leaves alone, of the probing step where none of the run's are; None: exact."""
    found = (errors_of(subject, case.long(w), t, h) for h in case.steps())
    return next((math.log2(errors[-2] / errors[-1]) - 1 for errors in found if len(errors) > 1), None)


def errors_of(subject, w, t, h) -> list:
    """Of h, h/2, h/4 and so on, as far as they are more than round-off."""
    floor, errors = RESOLVED * LONG_EPS * size(w), []
    while len(errors) < HALVINGS:
        error = halved(subject, w, t, h)
        if error < floor:
            break
        errors.append(error)
        h /= 2
    return errors


def halved(subject, w, t, h) -> float:
    """|one step of h - two of h/2|, largest component."""
    two = subject.step(subject.step(w, t, h / 2), t + h / 2, h / 2)
    return float(np.abs(subject.step(w, t, h) - two).max())


def against_flow(case: Case, subject) -> float | None:
    """Observed order of the finest two runs whose errors the reference resolves; None: exact."""
    w, t = case.points[0]
    time = STEPS * case.probe
    exact = case.witness.flow(w, t, [t + time])[0]
    errors = []
    for k in range(FLOW_HALVINGS):
        error = end_error(subject, w, t, time, STEPS * 2**k, exact)
        if error is not None and error < FLOW_ERROR * size(w):
            break
        errors.append(error)
    fine = [e for e in errors[-2:] if e is not None]
    if len(fine) < 2:
        return None if error is not None and error < FLOW_ERROR * size(w) else math.nan
    return math.log2(fine[0] / fine[1])


def end_error(subject, w, t, time, steps, exact) -> float | None:
    """Largest error at the end, None where a step fails."""
    try:
        end = subject.run(w[None], t, time / steps, [steps])[0, 0]
    except RunError:
        return None
    return float(np.abs(end - exact).max())
