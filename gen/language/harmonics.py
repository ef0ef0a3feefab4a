"""Real spherical harmonics as polynomials of a unit vector.

    Y_lm = N_lm Q_lm(z) Re (x + i y)^m for m >= 0,  N_l|m| Q_l|m|(z) Im (x + i y)^|m| for m < 0,     Q_lm = d^m P_l/dz^m

without the phase (-1)^m of Condon and Shortley (Abramowitz and Stegun, 8.6.6 without their (-1)^m).
"""
from __future__ import annotations

from math import comb, factorial, perm, pi, sqrt

# name of the function -> N_lm^2 without (2 - delta_m0) (l - m)!/(l + m)!
NORMS = {
    "orthonormal_harmonics": lambda l: (2 * l + 1) / (4 * pi),      # the integral of Y^2 over the sphere is 1
    "geodesy_harmonics": lambda l: 2 * l + 1,                       # the mean of Y^2 over the sphere is 1
    "schmidt_harmonics": lambda l: 1,                               # the mean is 1/(2 l + 1)
}


def norm(function: str, l: int, m: int) -> float:
    return sqrt(NORMS[function](l) * (1 + (m > 0)) * factorial(l - m) / factorial(l + m))


def derived(l: int, m: int) -> dict:
    """power -> coefficient of d^m P_l/dz^m, exact: P_l = 2^-l sum (-1)^k C(l, k) C(2 l - 2 k, l) z^(l - 2 k)."""
    powers = {l - 2 * k: (-1) ** k * comb(l, k) * comb(2 * l - 2 * k, l) for k in range(l // 2 + 1)}
    return {p - m: c * perm(p, m) / 2 ** l for p, c in powers.items() if p >= m}
