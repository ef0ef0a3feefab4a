"""The free rigid body w' = w x I^-1 w from w(0) = (c, 0, s), in Jacobi's elliptic functions.

With a = 1/I1 > b = 1/I2 > d = 1/I3, w = (c cn, B sn, s dn)(lambda t | m) solves the equations
    w1' = -(b-d) w2 w3,  w2' = (a-d) w3 w1,  w3' = -(a-b) w1 w2
when B^2 = c^2 (a-d)/(b-d), lambda^2 = s^2 (a-d)(b-d), m = (c/s)^2 (a-b)/(b-d) < 1.
"""
from __future__ import annotations

import numpy as np


def jacobi(u, m: float):
    """sn, cn, dn of u (k,) with parameter 0 <= m < 1.

    Arithmetic-geometric mean and descending Landen steps: Abramowitz and Stegun, 16.4.
    """
    means, gaps = [1.0], [np.sqrt(m)]
    b = np.sqrt(1 - m)
    while gaps[-1] > 1e-16:
        a = means[-1]
        means.append((a + b) / 2)
        gaps.append((a - b) / 2)
        b = np.sqrt(a * b)
    phi = 2.0 ** (len(means) - 1) * means[-1] * np.asarray(u, float)
    for a, c in zip(means[:0:-1], gaps[:0:-1]):
        phi = 0.5 * (phi + np.arcsin(c / a * np.sin(phi)))
    sn = np.sin(phi)
    return sn, np.cos(phi), np.sqrt(1 - m * sn * sn)


def free_body(moments, angle: float, t) -> np.ndarray:
    """w(t) (k, 3) from (cos angle, 0, sin angle), for moments I1 < I2 < I3 and m < 1."""
    a, b, d = 1 / np.asarray(moments, float)
    c, s = np.cos(angle), np.sin(angle)
    m = (c / s) ** 2 * (a - b) / (b - d)
    if not (a > b > d and 0 <= m < 1):
        raise ValueError("the solution has this form for I1 < I2 < I3 and m < 1 only")
    sn, cn, dn = jacobi(s * np.sqrt((a - d) * (b - d)) * np.asarray(t, float), m)
    return np.stack([c * cn, c * np.sqrt((a - d) / (b - d)) * sn, s * dn], axis=1)
