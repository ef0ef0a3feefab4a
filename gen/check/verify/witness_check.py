"""Agreement with the independent interpreter: field, energy, one step, residual of the step equation.

The interpreter shares no derivative and no emitted line with the compiler. Field and energy are
compared in extended precision, where round-off of the formulas cannot hide a wrong digit.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ...extremes import largest
from ...methods import METHODS as METHODS_OF_SPECS
from ..witness import EQUATIONS, METHODS
from .case import EPS, Case, size
from .leaves import LONG
from .residual import RESIDUAL, worst
from .reversible import stretch
from .row import Row, at_most, not_applicable

FIELD = 1e-14           # of the largest field: the interpreter returns doubles
STEP = 32               # ulps
CONTROLLED = 1e5        # of a method with step control, whose tolerance is 1e-12
STATES = {"quick": 3, "normal": 8}


def witness_check(case: Case, subject) -> list[Row]:
    """Four rows."""
    return [*formulas(case, subject), step(case, subject), residual(case, subject)]


def formulas(case: Case, subject) -> list[Row]:
    """Field and energy at the states of the case and at others beside, at the busiest times."""
    if subject.field(case.w, 0.0) is None:
        why = "this integrator does not provide the field and the energy"
        return [not_applicable("field", why), not_applicable("energy formula", why)]
    places = [*case.points, *((case.nudged(0.3), t) for t in case.times()[:STATES["normal"]])]
    found = [x for x in (formula_gaps(case, subject, w, t) for w, t in places) if x is not None]
    gaps = np.max(found, axis=0) if found else (np.nan, np.nan)
    note = f"at {len(found)} states"
    return [at_most("field", gaps[0], FIELD, note), at_most("energy formula", gaps[1], FIELD, note)]


def formula_gaps(case: Case, subject, w, t):
    """(field, energy): relative differences; None where the formulas are not finite."""
    try:
        b, energy = case.witness.field(w, t), case.witness.energies(w, t)
    except RunError:
        return None
    there = w.astype(LONG)
    gap = np.abs(subject.field(there, t) - b).max() / largest(np.abs(b).max(), np.finfo(float).tiny)
    power = float(np.sum(np.abs(b) * np.abs(w) * np.abs(case.witness.kappa)[:, None]))
    scale = largest(power, *(abs(x) for x in energy.values()), np.finfo(float).tiny)
    return float(gap), float(abs(subject.energy(there, t) - sum(energy.values())) / scale)


def step(case: Case, subject) -> Row:
    """One step beside the interpreter's, in ulps that the step may stretch."""
    method = case.settings.method
    if not case.small:
        return not_applicable("step", "the interpreter's matrix is dense: the residual is used instead")
    if method not in METHODS:
        return not_applicable("step", "the interpreter does not implement this method")
    found = [float(np.abs(subject.step(w, t, h) - case.witness.step(w, t, h, method)).max())
             / (EPS * size(w) * stretch(subject, w, subject.step(w, t, h), t, h)) for w, t, h in case.trials()]
    return at_most("step", largest(*found), CONTROLLED if METHODS_OF_SPECS[method].controlled else STEP)


def residual(case: Case, subject) -> Row:
    """|W - w - h X(m)| of single steps without history."""
    method = case.settings.method
    if method not in EQUATIONS:
        return not_applicable("residual", "the interpreter cannot compute residuals of this method")
    found = (worst(case, subject, np.array([w, subject.step(w, t, h)]), t, h) for w, t, h in case.trials())
    return at_most("residual", largest(*found), RESIDUAL)
