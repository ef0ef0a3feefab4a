"""Gauss collocation of s stages in collective variables, by numpy: the witness's own, from the theory and not from tables.

Every w is lifted to z in C^2 with w_k = z^* sigma_k z. H is extended to be constant along rays: with p = r w/abs(w), r of the
start, and b the field at p, its gradient is (r/abs(w)) (b - p (p.b)/r^2); then w' = w x b is z' = (i/2)(b.sigma) z. The stages solve
Z_i = z + h sum_j a_ij F(Z_j), where, with shifted Legendre polynomials P_k (Hairer, Norsett, Wanner, II.7),

    a_ij = b_j sum_(k < s) (2k + 1) P_k(c_j) (integral of P_k from 0 to c_i).
"""
from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

SIGMA = np.array([[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])
MOST = 1000     # fixed-point iterations
PATIENCE = 5    # of them without a smaller change: round-off is reached


def tableau(s: int):
    """(c, b, a) of s stages."""
    x, weights = legendre.leggauss(s)
    c, b = (x + 1) / 2, weights / 2
    values = np.array([legendre.legval(x, np.eye(s + 2)[k]) for k in range(s + 2)])
    integrals = np.array([(values[1] + 1) / 2, *((values[k + 1] - values[k - 1]) / (2 * (2 * k + 1)) for k in range(1, s))])
    a = np.einsum("j,k,kj,ki->ij", b, 2 * np.arange(s) + 1, values[:s], integrals)
    return c, b, a


def lifted(w):
    """z of shape (sites, 2) with w_k = z^* sigma_k z, by the half of the sphere that w is on."""
    r = np.linalg.norm(w, axis=1)
    north = w[:, 2] >= 0
    large = np.sqrt((r + np.abs(w[:, 2])) / 2)
    small = (w[:, 0] + 1j * w[:, 1]) / (2 * np.where(large > 0, large, 1))
    return np.where(north[:, None], np.stack([large + 0j, small], 1), np.stack([small.conj(), large + 0j], 1))


def lowered(z):
    """w of shape (sites, 3)."""
    return np.einsum("sa,kab,sb->sk", z.conj(), SIGMA, z).real


def along_rays(witness, w, r, t: float) -> np.ndarray:
    """The field of the Hamiltonian that is constant along rays, 0 at sites of length 0."""
    size = np.linalg.norm(w, axis=1, keepdims=True)
    n = np.divide(w, size, out=np.zeros_like(w), where=size > 0)
    b = witness.turning(r * n, t)
    return np.divide(r, size, out=np.zeros_like(size), where=size > 0) * (b - n * np.sum(n * b, axis=1, keepdims=True))


def step(witness, w, t: float, h: float, s: int) -> np.ndarray | None:
    """The state after one step of the system of `witness`; None where the iteration does not settle."""
    c, b, a = tableau(s)
    z, H, r = lifted(w), witness.spec.orientation * h, np.linalg.norm(w, axis=1, keepdims=True)

    def slope(Z, at):
        return 0.5j * np.einsum("sk,kab,sb->sa", along_rays(witness, lowered(Z), r, t + at * h), SIGMA, Z)

    K, least, idle = np.array([slope(z, at) for at in c]), np.inf, 0
    for _ in range(MOST):
        new = np.array([slope(z + H * np.einsum("j,jsa->sa", a[i], K), c[i]) for i in range(s)])
        change, K = np.abs(new - K).max(), new
        if not np.isfinite(change):
            return None
        idle, least = (0, change) if change < least else (idle + 1, least)
        if change == 0 or idle > PATIENCE and least <= 1e-12 * np.abs(K).max():
            return lowered(z + H * np.einsum("j,jsa->sa", b, K))
    return None
