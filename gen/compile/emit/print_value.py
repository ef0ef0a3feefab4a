"""The printer of the single sphere: a vector is a struct by value, kept in registers."""
from __future__ import annotations

from .formulas import ATOM
from .print_scalar import Scalar


class ByValue(Scalar):
    """Vectors of runtime/core/smg_vec.h."""

    def leaf_component(self, n):
        return f"{n.vector}.{'xyz'[n.axis]}", ATOM
