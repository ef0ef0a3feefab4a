"""Means of thermal steps without sampling: a Markov chain in one cosine u, whose kernel acts on Legendre polynomials of u."""
from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import quad

DEGREE = 60


def nodes(degree=DEGREE):
    """Cosines of Gauss and Legendre, and their weights."""
    return legendre.leggauss(2 * degree)


def transition(ends, degree=DEGREE):
    """The matrix by which a step that takes each node to one of `ends` takes the coefficients of a function to those of its value after the step."""
    u, weights = nodes(degree)
    return (np.arange(degree + 1) + 0.5)[:, None] * (legendre.legvander(u, degree) * weights[:, None]).T @ legendre.legvander(ends, degree)


def heat(diffusion, h, degree=DEGREE):
    """What N(h/2) of one vector multiplies each polynomial by: the character of a turn by t about a random axis, over its dimension, with the variance of the C."""
    x = diffusion * h / 2
    variance = 2 * (x - x * x / 6)

    def density(t):
        return np.sqrt(2 / np.pi) * t * t / variance**1.5 * np.exp(-t * t / (2 * variance))
    return np.array([quad(lambda t, n=n: density(t) * np.sin((n + 0.5) * t) / np.sin(t / 2) / (2 * n + 1), 1e-9, 12 * np.sqrt(variance), limit=400, epsabs=1e-14)[0]
                     for n in range(degree + 1)])


def stationary(matrix):
    """The means of the polynomials: the functional p with p K = p, p(1) = 1."""
    values, vectors = np.linalg.eig(matrix.T)
    p = vectors[:, np.argmin(np.abs(values - 1))].real
    return p / p[0]
