"""The symplectic leaves: frames, displacements along them, derivatives, the symplectic form.

On the leaf of site i, a sphere or a level set of its C, with normal n = grad C(w), the bracket
w' = (1/kappa) n x grad H belongs to the form

    omega(u, v) = sum_i kappa_i n_i.(u_i x v_i)/|n_i|^2

(Kirillov, Kostant, Souriau): a map with tangent M is symplectic when omega_W(M u, M v) = omega_w(u, v).
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LONG = np.longdouble
OFFSETS = (1, 2, 3)
WEIGHTS = np.array([45, -9, 1], LONG) / 60          # of f(x + k d) - f(x - k d)


@dataclass(frozen=True)
class Leaves:
    """kappa (sites,), casimir (sites, 3, 3), radius (sites,): nan off spheres."""
    kappa: np.ndarray
    casimir: np.ndarray
    radius: np.ndarray

    def normal(self, w):
        """n = grad C(w) of every site, shape (sites, 3)."""
        return np.einsum("sab,sb->sa", self.casimir.astype(w.dtype), w)

    def values(self, w):
        """2 C(w) of every site, on spheres |w|^2; leading axes of w are kept."""
        return np.einsum("...sa,sab,...sb->...s", w, self.casimir.astype(w.dtype), w)

    def sizes(self, w):
        """Round-off of 2 C(w) is measured by |w|.|A||w|, larger than C near its zeros; no divisor is 0 where w is."""
        found = np.einsum("...sa,sab,...sb->...s", np.abs(w), np.abs(self.casimir).astype(w.dtype), np.abs(w))
        return np.maximum(found, np.finfo(float).tiny)

    def polished(self, w):
        """Sites of spheres scaled to their radius in the precision of w."""
        sphere = ~np.isnan(self.radius)
        scale = np.where(sphere, np.where(sphere, self.radius, 1) / np.where(sphere, lengths(w), 1), w.dtype.type(1))
        return w * scale[:, None]

    @staticmethod
    def squares(n):
        """|n|^2 of every site; 1 where n = 0, which has no form."""
        found = np.sum(n * n, axis=1)
        return np.where(found > 0, found, 1)

    def form(self, w, left, right):
        """omega(u, v) for all columns u of left, v of right (columns, sites, 3): (left, right)."""
        n = self.normal(w)
        n = n * (self.kappa / self.squares(n))[:, None]
        return np.einsum("asi,bsi->ab", np.cross(n, left), right)


def lengths(w):
    """|w| of every site."""
    return np.sqrt(np.sum(w * w, axis=-1))


def frame(n):
    """Orthonormal e1, e2 with e1 x e2 = n/|n|."""
    low = np.eye(3, dtype=n.dtype)[np.argmin(np.abs(n))]
    e1 = np.cross(low, n)
    e1 /= np.sqrt(e1 @ e1)
    return e1, np.cross(n / np.sqrt(n @ n), e1)


def moved(leaves: Leaves, w, v, s):
    """w displaced by s v, |s| small: on spheres along great circles, elsewhere straight."""
    size = lengths(v)[:, None]
    r = np.where(np.isnan(leaves.radius), 0, leaves.radius)[:, None].astype(w.dtype)
    on = (size > 0) & (r > 0)
    angle = np.where(on, s * size / np.where(r > 0, r, 1), 0)
    turned = np.cos(angle) * w + np.sin(angle) * r * v / np.where(size > 0, size, 1)
    return np.where(on, turned, w + s * v)


def derivative(leaves: Leaves, step, w, v, width):
    """M v of the map `step` at w: a seven-point central difference, its error about width^6."""
    total = np.zeros_like(w)
    for k, weight in zip(OFFSETS, WEIGHTS):
        ahead, behind = (step(moved(leaves, w, v, LONG(sign * k * width))) for sign in (1, -1))
        total = total + weight * (ahead - behind)
    return total / LONG(width)
