"""Exact Poisson maps and flows, to try a measurement of the defect on."""
import numpy as np


def rotation(axis, angle):
    """The matrix of the rotation by `angle` about `axis` (Rodrigues), in extended precision."""
    e = np.asarray(axis, np.longdouble)
    e = e / np.sqrt(e @ e)
    k = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    return np.eye(3, dtype=np.longdouble) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def pair_flow(kappa, coupling, t):
    """The flow of H = J w_1.w_2 on two spins of strengths kappa and any radii.

    w_1' = w_1 x (J/kappa_1) w_2 = (J/(kappa_1 kappa_2)) w_1 x S with S = kappa_1 w_1 + kappa_2 w_2,
    and w_2' likewise: S stays, both turn about it by -|S| J t/(kappa_1 kappa_2).
    """
    def flow(w):
        total = kappa[0] * w[0] + kappa[1] * w[1]
        angle = -np.sqrt(total @ total) * coupling * t / (kappa[0] * kappa[1])
        return w @ rotation(total, angle).T
    return flow


def linear_flow(casimir, slope, t):
    """The flow of w' = A w x a, grad C = A w and H = a.w: exp(t L), L = -[a]_x A, by its series."""
    a = np.asarray(slope, np.longdouble)
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    generator = -t * cross @ np.asarray(casimir, np.longdouble)
    total = term = np.eye(3, dtype=np.longdouble)
    for k in range(1, 40):
        term = term @ generator / k
        total = total + term
    return lambda w: w @ total.T


def dilation(factor):
    """Of the unit sphere from its north pole, factor times in the stereographic plane.

    There the area grows by factor^2; it is symplectic for no factor but 1.
    """
    def move(w):
        x, y, z = w[0]
        p, q = factor * x / (1 + z), factor * y / (1 + z)
        return np.array([[2 * p, 2 * q, 1 - p * p - q * q]]) / (1 + p * p + q * q)
    return move
