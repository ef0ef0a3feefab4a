"""Torques that are fields beside the gradients: their kernels stand among those of the energies (`Model.fields`); here is what they take apart again."""
from __future__ import annotations

from .part import Part
from .sums import gradient_body, sum_gradient, sums


class Torques(Part):
    """Fields that are no gradients."""
    name = "twisted"

    def made(self, model, low):
        return model.torques or None

    def functions(self, model):
        """smg_energy_gradient(c, w, g): g += dH/dw, without them."""
        return [sum_gradient("smg_energy_gradient", sums(model, model.energies, lambda t: gradient_body(model, t)))]

    def settings(self, model):
        return {"SMG_TORQUES": 1}
