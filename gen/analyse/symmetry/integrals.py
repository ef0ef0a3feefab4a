"""What is conserved, one dataclass each: what it is, its value, and whether the method keeps it."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Integral:
    """A conserved quantity of the flow.

    kind: 'linear', 'quadratic', 'energy' or 'casimir'; formula: its text; kept: does the method
    keep it exactly (up to round-off); why: the reason for that; always: is it proved for every
    value of the parameters, or for those of the run; numbers: w of shape (sites, 3) -> array of
    the `count` numbers that it stands for.
    """
    name: str
    kind: str
    formula: str
    kept: bool
    why: str
    always: bool
    count: int = 1
    numbers: object = field(default=None, repr=False, compare=False)

    def evaluate(self, w) -> float:
        """The number itself, or, of several, a sum with fixed unequal weights between 1 and 2."""
        found = np.atleast_1d(self.numbers(np.asarray(w)))
        weights = 1 + np.arange(found.size) * 0.6180339887498949 % 1
        return float(found[0] if found.size == 1 else np.dot(weights, found))

    def as_dict(self) -> dict:
        """For JSON."""
        return {k: getattr(self, k) for k in ("name", "kind", "formula", "kept", "why", "always", "count")}



WHY = {
    "linear": "a.(W - w) = h a.X(m), which is zero at every point m",
    "off": "shown on the spheres only, and the classical midpoint looks at points off them",
    "parts": "the parts that H is split into do not keep it one by one",
    "none": "the method is not known to keep linear integrals",
    "turns": "every site turns about dH/dw, in which it is not",
    "own": "W.QW - w.Qw = 2h mbar.QX(m), and mbar is a multiple of m site by site",
    "sum": "mbar is a multiple of m with a factor of its own for each site: a sum over sites is not kept",
    "every": "the classical midpoint keeps every quadratic integral",
    "other": "the method keeps no quadratic integral of w",
    "leaf": "an explicit method leaves the leaf by its error",
    "casimir": "X(m) is perpendicular to grad C(mbar)",
    "energy": "H is a sum of linear and single-site quadratic integrals",
    "bounded": "its error stays bounded over long times for small h, as the method is symplectic",
    "drift": "the method is not symplectic on spheres: the energy may drift",
    "body": "the discrete free body keeps the energy and the momentum of the free body",
}
