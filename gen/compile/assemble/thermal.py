"""Thermal noise, a map around the step (runtime/core/smg_thermal.h): the rate D at which it turns each site."""
from __future__ import annotations

from ...language.expr import Num
from ..derive.derivatives import scalar
from ..plan.contributions import diffusions_of
from .families import SITE, by_family, returned
from .part import Part, buffer


class Thermal(Part):
    """Sites in a heat bath: the kernels of D of all families, 0 of those that are in none."""
    name = "thermal"
    templates = {"between": "thermal.h.j2", "flat": "thermal_abi.c.j2"}

    def made(self, model, low):
        found = diffusions_of(model.contributions)
        return {f.name: low.kernel([value], leaves) for f in model.families for value, leaves in [scalar(found.get(f.name, Num(0)))]} if found else None

    def functions(self, model):
        """smg_diffusion(c, k): D of site k."""
        return [by_family("smg_real", "smg_diffusion", SITE, lambda f: returned(model.thermal[f.name]), model.families, wanted=True)]

    def settings(self, model):
        return {"SMG_THERMAL": 1}

    def around(self, model):
        return [buffer("unturned", 3 * model.total, "w before the noise of the current step")]

    def most_around(self, model, step):
        """A step that fails, and two halves."""
        return step * 3

    def members(self, model):
        return [("uint64_t seed", "seed of the noise"), ("uint32_t member", "number of the member of an ensemble, for its noise"),
                ("int64_t halved", "number of steps taken as two steps of h/2, with the same noise")]
