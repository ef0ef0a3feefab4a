"""Comparators with thermal noise in their steps: the bias of a mean that is known, computed without sampling, falls as the weak order says.

For one spin in a field along z the height u = w.z is a Markov chain. Its kernel acts on Legendre polynomials of u; the mean over the noise of a step,
three normal numbers, is a sum over points of Gauss and Hermite. That the C takes the same steps is shown by tests/laws/test_noise.py.
"""
from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial import hermite_e, legendre

import smidgen
from smidgen.check.witness import WITHIN, Witness

DEGREE, NODES = 20, 12
FIELD = """[model]
name = "warm"
[space]
w = {{ sphere = {sites} }}
[effects.field]
over = "site(i) of w"
energy = "-w[i].z"
[effects.bath]
over = "site(i) of w"
damping = 0.5
kT = 0.5
form = "{form}"
[starts.up]
theta = 0
phi = 0
"""
EXACT = 1 / np.tanh(2) - 0.5


def points():
    """Of the three normal numbers of a step: (n, 3) and their weights."""
    x, weights = hermite_e.hermegauss(NODES)
    grid = np.stack(np.meshgrid(x, x, x, indexing="ij"), -1).reshape(-1, 3)
    return grid, np.einsum("i,j,k->ijk", *[weights / weights.sum()] * 3).ravel()


def mean_height(method, h, form):
    """Of the stationary distribution of the steps of a method."""
    heights, weights = legendre.leggauss(2 * DEGREE)
    noise, parts = points()
    spec = smidgen.load_text(FIELD.format(sites=len(heights) * len(noise), form=form))
    w = np.repeat(np.stack([np.sqrt(1 - heights**2), 0 * heights, heights], 1), len(noise), axis=0)
    diffusion = 0.25 / (1.25 if form == "gilbert" else 1)
    ends = WITHIN[method](Witness(spec.calm), w, 0.0, h, np.sqrt(2 * diffusion * h) * np.tile(noise, (len(heights), 1)))[:, 2]
    after = np.einsum("j,ijl->il", parts, legendre.legvander(ends.reshape(len(heights), -1), DEGREE))
    matrix = (np.arange(DEGREE + 1) + 0.5)[:, None] * (legendre.legvander(heights, DEGREE) * weights[:, None]).T @ after
    values, vectors = np.linalg.eig(matrix.T)
    p = vectors[:, np.argmin(np.abs(values - 1))].real
    return p[1] / p[0]


@pytest.mark.parametrize("form", ["ll", pytest.param("gilbert", marks=pytest.mark.long)])
@pytest.mark.parametrize("method, order", [("heun", 1), ("depondt-mertens", 1)])
def test_the_bias_of_a_mean_falls_as_the_weak_order_says(method, order, form):
    """B = 1, kT = 0.5, alpha = 0.5, exactly coth 2 - 1/2."""
    biases = [mean_height(method, h, form) - EXACT for h in (0.1, 0.05)]
    for before, after in pairwise(biases):
        assert abs(np.log2(before / after) - order) < 0.2
