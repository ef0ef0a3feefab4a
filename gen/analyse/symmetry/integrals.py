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
    "off": "this is proved only on the spheres, and the classical midpoint evaluates the field off them",
    "parts": "the parts into which H is split do not conserve it individually",
    "none": "the method is not known to conserve linear integrals",
    "turns": "every site turns about dH/dw, which does not depend on the site itself",
    "own": "W.QW - w.Qw = 2h mbar.QX(m), and mbar is a multiple of m site by site",
    "sum": "mbar is a multiple of m with a factor that differs from site to site, so a sum over sites is not conserved",
    "every": "the classical midpoint conserves every quadratic integral",
    "other": "the method conserves no quadratic integral of w",
    "leaf": "an explicit method drifts off the leaf",
    "casimir": "X(m) is perpendicular to grad C(mbar)",
    "energy": "H is a sum of linear and single-site quadratic integrals",
    "bounded": "as the method is symplectic, the energy error stays bounded over long times for small h",
    "drift": "the method is not symplectic on spheres: the energy may drift",
    "body": "the discrete free body conserves the energy and the momentum of the free body",
}
