"""The motion near an equilibrium w, linear in the deviations d of the sites that move, which are tangent to their leaves:

    kappa d' = C w x (H d - mu C d),    H the Hessian of the energy at w, and dH/dw = mu C w there, C = 1 on spheres.

In a frame (e1, e2) of each site, e1 x e2 = n = C w/|C w|, that is a' = (|C w|/kappa) J A a with the symmetric A = E (H - mu C) E^T and
J = (0 -1; 1 0): the classical form
of linear spin waves (S. Toth and B. Lake, J. Phys.: Condens. Matter 27 (2015) 166002).
"""
from __future__ import annotations

import numpy as np

from ..errors import UsageError
from ..packages import needed
from ..run.step.evaluated import Evaluated
from .hessian import Energy


class Linear:
    """i, j, blocks: H - mu C, 3 x 3 for each pair of sites that move; normal: (sites, 3); rate: |C w|/kappa of each site, with the sign
    of the bracket."""

    def __init__(self, numbers: Evaluated, energy: Energy, w):
        self.numbers, self.w = numbers, np.asarray(w, float)
        self.normal, length = normals(numbers, self.w)
        self.gradient = energy.gradient(self.w)
        i, j, blocks = energy.hessian(self.w)
        if not np.isfinite(blocks).all():
            raise UsageError("the second derivatives of the energy are not finite at the equilibrium: no motion near it is linear")
        mu = np.sum(self.normal * self.gradient, axis=1) / np.where(length > 0, length, 1)
        every = np.arange(len(self.w))
        i, j = np.concatenate([i, every]), np.concatenate([j, every])
        blocks = np.concatenate([blocks, -mu[:, None, None] * numbers.casimir_matrices])
        kept = numbers.moving[i] & numbers.moving[j]
        self.i, self.j, self.blocks = i[kept], j[kept], blocks[kept]
        self.rate = numbers.spec.orientation * length / numbers.kappas

    def tangent(self, frames) -> np.ndarray:
        """The blocks of A, 2 x 2, in frames (sites, 2, 3)."""
        return np.einsum("kab,kbc,kdc->kad", frames[self.i], self.blocks, frames[self.j])

    def newton(self) -> np.ndarray:
        """One step of Newton's method towards an equilibrium on spheres: A a = -E g, of the shortest a."""
        linalg, sparse = needed("scipy.sparse.linalg", "relaxation"), needed("scipy.sparse", "relaxation")
        frames, sites = frames_of(self.normal), len(self.w)
        rows = (2 * self.i[:, None, None] + np.arange(2)[:, None]) + np.zeros((1, 1, 2), int)
        columns = (2 * self.j[:, None, None] + np.arange(2)) + np.zeros((1, 2, 1), int)
        a = sparse.csr_array((self.tangent(frames).ravel(), (rows.ravel(), columns.ravel())), shape=(2 * sites, 2 * sites))
        slope = np.einsum("sab,sb->sa", frames, self.gradient) * self.numbers.moving[:, None]
        step = linalg.minres(a, -slope.ravel(), rtol=1e-12, maxiter=5 * sites + 100)[0].reshape(sites, 2)
        moved = self.w + np.einsum("sa,sab->sb", step, frames)
        length = np.linalg.norm(self.w, axis=1) / np.linalg.norm(moved, axis=1)
        return np.where(self.numbers.moving[:, None], moved * length[:, None], self.w)


def normals(numbers: Evaluated, w) -> tuple:
    """(n, |C w|) of all sites: unit vectors across their leaves, C w = w on spheres. Raises UsageError where one that moves is 0."""
    found = np.einsum("sab,sb->sa", numbers.casimir_matrices, w)
    length = np.linalg.norm(found, axis=1)
    zero = np.flatnonzero((length == 0) & numbers.moving)
    if zero.size:
        raise UsageError(f"site {zero[0]} is 0, so it has no leaf to move on")
    return found / np.where(length > 0, length, 1)[:, None], length


def frames_of(normal) -> np.ndarray:
    """(sites, 2, 3): two unit vectors e1, e2 across each of the unit vectors n, with e1 x e2 = n."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(axis, normal)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normal, first)], axis=1)
