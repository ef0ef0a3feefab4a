"""Compositions of a midpoint: what their stages keep."""
from __future__ import annotations

from .part import Part, buffer, where_true


class Composed(Part):
    """A step of several stages."""
    name = "composed"

    def made(self, model, low):
        return model.method.stages if model.method.stages > 1 else None

    def settings(self, model):
        return {"SMG_COMPOSED": model.composed, **where_true(SMG_STAGES_KEPT=keeps_stages(model))}

    def buffers(self, model):
        if not model.method.of_midpoints:
            return []
        misses = buffer("misses", 5, "errors of each level of the predictor in a step, and the number of stages")
        before = buffer("before", 6 * model.total, "w and compensation before the step")
        kept = buffer("increments", 3 * model.composed * model.total, "increments of all stages of the last step")
        return [misses, before, *([kept] if keeps_stages(model) else [])]

    def members(self, model):
        if not model.method.of_midpoints:
            return []
        stage = ("int stage", "stages done of the current or last step")
        return [stage] if model.solo else [stage, (f"smg_real *spare[{model.history}]", "as many again, so that a failed stage leaves the history unchanged")]

    def most_around(self, model, step):
        return step.times_reported(model.composed)

    def step(self, model):
        return "smg_composition.h"


def keeps_stages(model) -> bool:
    """Does the tangent map need the increments of all stages? A single sphere has them in its history."""
    return "tangent" in model.features and not model.solo
