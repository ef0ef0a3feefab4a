"""Thermal noise. The other rows are those of the step without it, which stands unchanged between its two halves; here is the whole."""
from __future__ import annotations

import numpy as np

from ...compile.select import select
from ...errors import RunError
from ...language.spec import Spec
from ...methods import METHODS as METHODS_OF_SPECS
from ...run.settings import model_of
from ...run.step.integrator import Integrator
from ..witness import METHODS, Witness
from .case import EPS, Case, size
from .row import Row, at_most, not_applicable, refused
from .witness_check import CONTROLLED, STEP

STEPS, SEED = 2, 20240501       # few: noise does not stretch distances, but steps do
AGAIN = 20                      # steps after a restart


def noise(spec: Spec, case: Case) -> list[Row]:
    """Two rows; none where the scene of `spec` has no noise."""
    s = case.settings
    if not select(spec, s.effects, s.parameters).heated:
        return []
    model = model_of(spec, s, "double")
    try:
        model.start(case.w.copy(), h=case.h, seed=SEED).steps(STEPS)
    except RunError as error:
        return [refused("noise", str(error))]
    try:
        return [beside(spec, case, model), restored(case, model)]
    except RunError as error:
        return [not_applicable("noise", f"orbits cannot be followed: {error}")]


def beside(spec: Spec, case: Case, model: Integrator) -> Row:
    """STEPS steps from the start, C and interpreter."""
    s = case.settings
    if not case.small or s.method not in METHODS:
        return not_applicable("noise", "the interpreter cannot take steps of this size or method")
    mine = model.start(case.w.copy(), h=case.h, seed=SEED).steps(STEPS).state()
    other = Witness(spec, s.parameters, s.effects, seed=SEED).steps(case.w, 0.0, case.h, STEPS, s.method)[-1]
    bound = CONTROLLED if METHODS_OF_SPECS[s.method].controlled else STEP
    return at_most("noise", float(np.abs(mine - other).max()) / (EPS * size(case.w)), STEPS * bound, f"{STEPS} steps")


def restored(case: Case, model: Integrator) -> Row:
    """The part of AGAIN steps after a restart whose bits differ."""
    model.start(case.w.copy(), h=case.h, seed=SEED).steps(STEPS)
    saved, path = model.save(), []
    for _ in range(AGAIN):
        path.append(model.step().state())
    model.start(case.nudged(0.1), h=case.h / 2, seed=SEED + 1).steps(1)
    model.restore(saved)
    return at_most("noise restored", sum(model.step().state().tobytes() != w.tobytes() for w in path) / AGAIN, 0)
