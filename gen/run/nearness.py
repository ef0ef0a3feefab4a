"""How near the midpoints of a run come to the centre of their sphere.

The midpoint mbar = (w + W)/2 of a step of the spherical midpoint method lies at the distance

    rho = sqrt(|W|^2 - |W - w|^2/4)

from the centre, where m = mbar/rho has no direction: a step there is ill conditioned, and a little farther on there
may be none.
"""
from __future__ import annotations

import numpy as np

from ..methods import METHODS
from .saved import PAST

NEAR = 0.1      # of the radius
STRIDE = 64     # steps between two looks at a large system, at least: a look copies the history of increments


class Nearest:
    """The smallest rho, in radii, of the steps looked at: those to the outputs, of large systems at most each 64th."""

    def __init__(self, model):
        kinds = {f.name: f.kind for f in model.scene.families}
        spherical = METHODS[model.method].of_midpoints and METHODS[model.method].onto_leaf
        self.parts = [part for name, part in model.families.items() if spherical and kinds[name] in ("sphere", "r3")]
        self.rho, self.site, self.step, self.t, self.seen = np.inf, -1, 0, 0.0, 0
        self.stride = min(STRIDE, 1 + model.sites // STRIDE)

    def see(self, model) -> None:
        """Look at the step that led to the present state."""
        if not self.parts or model.count - self.seen < self.stride:
            return
        self.seen, rho = model.count, last_distances(model)
        for first, count in self.parts:
            site = first + int(np.argmin(rho[first:first + count]))
            if rho[site] < self.rho:
                self.rho, self.site, self.step, self.t = float(rho[site]), site, model.count, model.t

    def fact(self) -> dict | None:
        """rho, site, step and t of a step nearer than NEAR, or None."""
        return {"rho": self.rho, "site": self.site, "step": self.step, "t": self.t} if self.rho < NEAR else None


def last_distances(model) -> np.ndarray:
    """rho of each site, in its own |W|, of the step just taken; shape (sites,)."""
    saved, W = model.save(), model.state().astype(float)
    moved = saved[int(saved[PAST]):][:W.size].astype(float)
    size = np.linalg.norm(W, axis=1)
    size = np.where(size > 0, size, 1)
    if moved.size == 0:         # closed form: each site in a field that does not depend on it
        return _in_a_field(W / size[:, None], model.h / 2 * np.asarray(model.field(W, model.t - model.h / 2), float))
    return np.linalg.norm(W - moved.reshape(-1, 3) / 2, axis=1) / size


def _in_a_field(n, g):
    """rho of unit spins that turn about a constant field, g = (h/2) b: the positive root of

        rho^4 - (1 - |g|^2) rho^2 - (n.g)^2 = 0.

    A midpoint rho m with m.g = n.g/rho moves by 2 m x g, of the length 2 sqrt(1 - rho^2).
    """
    d2, a = np.sum(n * g, axis=1)**2, 1 - np.sum(g * g, axis=1)
    root = np.sqrt(a * a + 4 * d2)
    below = np.where(root - a > 0, root - a, 1)
    return np.sqrt(np.where(a >= 0, (a + root) / 2, 2 * d2 / below))
