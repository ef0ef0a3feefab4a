"""Lyapunov exponents, by the tangent map or from nearby trajectories.

    top = smidgen.build(spec, features=("tangent",))
    found = smidgen.lyapunov.exponents(top, w, h=0.1, steps=100_000)
    found.values        # the spectrum per unit of time, largest first
"""
from .analyse.lyapunov import Exponents, exponents, nearby

__all__ = ["Exponents", "exponents", "nearby"]
