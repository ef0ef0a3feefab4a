"""The step equation u - h Y(w + u/2) = 0 in numpy, over the field about which sites turn (`turning.py`).

Y = X(P(mbar)) at the time t + h/2, with P the projection of the method; for Moser-Veselov
Y = X(mbar)/q. Derivatives are central differences of Y: they need to find a fold, not a solution
to the last digit.
"""
from __future__ import annotations

import numpy as np

from ...methods import METHODS
from ...run.step.integrator import Integrator
from .turning import Turning

DIFFERENCE = 3e-6       # of mbar, in units of its own length


class Nowhere(Exception):
    """The midpoint has no projection, or the field there is not finite. site: where."""

    def __init__(self, site: int):
        super().__init__(site)
        self.site = site


def _refuse(bad) -> None:
    """Raises Nowhere for the first site that is bad, in one state or in many."""
    if bad.any():
        raise Nowhere(int(np.argmax(bad.reshape(-1, bad.shape[-1]).any(axis=0))))


class StepEquation:
    """The equation of one step of `model` from (t, w); a negative `sign` steps backward."""

    def __init__(self, model: Integrator, w: np.ndarray, t: float, sign: float = 1.0, field: Turning | None = None):
        self.model, self.w, self.t, self.sign, self.field = model, np.array(w, float), t, sign, field or Turning(model)
        self.casimir = model.prepared.numbers.casimir_matrices
        r = model.prepared.numbers.radii
        self.level = np.where(np.isnan(r), self._twice_c(self.w), r * r)      # w.(A w), kept by the projection
        self.length = np.linalg.norm(self.w, axis=1)

    def of(self, w, t: float) -> StepEquation:
        """That of another state."""
        return StepEquation(self.model, w, t, self.sign, self.field)

    def _twice_c(self, w):
        return np.einsum("...si,sij,...sj->...s", w, self.casimir, w)

    def project(self, mbar):
        """m = mbar sqrt(c/C(mbar)), of one state or of many; the origin of R^3 stays. Raises Nowhere."""
        if not METHODS[self.model.method].onto_leaf:
            return mbar
        with np.errstate(all="ignore"):
            ratio = np.where(self.length == 0, 0, self.level / self._twice_c(mbar))
        bad = ~(np.isfinite(ratio) & (ratio >= 0) & ((ratio > 0) | (self.length == 0)))
        _refuse(bad)
        return mbar * np.sqrt(ratio)[..., None]

    def rate(self, mbar, h):
        """Y, shape (.., sites, 3), at the midpoint mbar, one or many, of a step h >= 0."""
        m, t = self.project(mbar), self.t + self.sign * h / 2
        b = np.reshape([self.field.at(one, t) for one in m.reshape(-1, *self.w.shape)], m.shape)
        with np.errstate(all="ignore"):
            y = self.sign * self.model.scene.orientation * np.cross(np.einsum("sij,...sj->...si", self.casimir, m), b)
            if METHODS[self.model.method].divided:
                y = y / ((1 + np.sqrt(1 - h * h * np.sum(b * b, axis=-1))) / 2)[..., None]
        _refuse(~np.isfinite(y).all(axis=-1))
        return y

    def residual(self, u, h):
        """F(u, h), flat."""
        return (u - h * self.rate(self.w + u / 2, h)).ravel()

    def slope(self, mbar, h):
        """dY/dmbar, shape (3 sites, 3 sites)."""
        steps = np.repeat(DIFFERENCE * np.maximum(np.linalg.norm(mbar, axis=1), 1e-9), 3)
        moves = np.diag(steps).reshape(-1, *mbar.shape)
        change = self.rate(mbar + moves, h) - self.rate(mbar - moves, h)
        return (change.reshape(len(steps), -1) / (2 * steps)[:, None]).T

    def jacobian(self, u, h):
        """J = dF/du = 1 - (h/2) dY/dmbar."""
        return np.eye(u.size) - h / 2 * self.slope(self.w + u / 2, h)

    def direction(self, u, h, jacobian):
        """du/dh along the branch: J u' = Y + h dY/dh."""
        mbar, d = self.w + u / 2, 1e-6 * max(h, 1e-3)
        change = (self.rate(mbar, h + d) - self.rate(mbar, h)) / d
        return np.linalg.solve(jacobian, (self.rate(mbar, h) + h * change).ravel()).reshape(u.shape)
