"""Features that are functions or macros and no more: the tangent map, ensembles, plain sums."""
from __future__ import annotations

from ...errors import UsageError
from ..plan.contributions import diffusions_of
from .part import Part, where_true


class Asked(Part):
    """A model has what is asked for by its name."""

    def made(self, model, low):
        return True if self.name in model.features else None


class Tangent(Asked):
    """The tangent map of the step."""
    name = "tangent"
    templates = {"public": "tangent.h.j2", "bodies": "tangent.c.j2", "flat": "tangent_abi.c.j2"}

    def fits(self, model):
        if diffusions_of(model.contributions):
            raise UsageError("the feature `tangent` requires motion without noise: remove kT")

    def settings(self, model):
        return where_true(SMG_COUPLED_LIFTED=model.lifts())

    def behind(self, model):
        return ["smg_tangent.h"]


class Ensemble(Asked):
    """Many states side by side."""
    name = "ensemble"
    types = ("ensemble",)
    templates = {"public": "ensemble.h.j2", "bodies": "ensemble.c.j2", "flat": "ensemble_abi.c.j2"}

    def behind(self, model):
        return ["smg_ensemble.h"]


class PlainSums(Asked):
    """No compensated sums."""
    name = "plain-sums"

    def settings(self, model):
        return {"SMG_PLAIN_SUMS": 1}
