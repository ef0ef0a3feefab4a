"""Sites that do not move: which they are, for methods that bring sites back to their spheres."""
from __future__ import annotations

from ...language.expr import Num
from ..derive.derivatives import scalar
from ..plan.contributions import shares_of
from .families import SITE, by_family, returned
from .part import Part


def kernel_of(low, share):
    value, leaves = scalar(share)
    return low.kernel([value], leaves)


def brings_back(method) -> bool:
    """Does it bring sites back to their spheres at the end of a step: by smg_lengths.h, or by a projection after steps of its own size?"""
    return any(name == "inverse" for name, *_ in method.arrays) or (method.controlled and method.keeps_leaf)


class Standing(Part):
    """Models with sites that are pinned or absent: the kernels of 1 where a site moves, 0 where it does not."""
    name = "moving"

    def made(self, model, low):
        found = shares_of(model.contributions)
        return {f.name: kernel_of(low, found.get(f.name, Num(1))) for f in model.families} if found else None

    def functions(self, model):
        """smg_moves(c, k)."""
        return [by_family("smg_real", "smg_moves", SITE, lambda f: returned(model.moving[f.name]), model.families, wanted=brings_back(model.method))]
