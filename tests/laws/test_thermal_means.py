"""Boltzmann's means without sampling: their bias falls by four when h is halved, whatever kappa, the radius, the orientation and the form of damping are."""
import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import quad
from support.thermal import heat, nodes, stationary, transition

import smidgen
from smidgen.check.witness import Witness

FIELD, AXIS = "-B*w[i].z/R", "-w[i].z^2"
EXACT = 1 / np.tanh(2) - 0.5


def spec_of(energy, over="site(i) of w", sites=120, form="ll", kappa=1.0, radius=1.0, orientation=1, kT=0.5, alpha=0.5, B=1.0):
    return smidgen.load_text(f"""[model]
name = "warm"
orientation = {orientation}
[space]
w = {{ sphere = {sites}, kappa = {kappa}, radius = {radius} }}
[parameters]
B = {B}
R = {radius}
[effects.own]
over = "{over}"
energy = "{energy}"
[effects.bath]
over = "site(k) of w"
damping = {alpha}
kT = {kT}
form = "{form}"
[starts.a]
random = 5
""")


def heights(spec, h, radius=1.0):
    """The means of Legendre polynomials of w.z/R: every node is a spin of its own."""
    u, factors = nodes()[0], heat(Witness(spec).diffusion[0], h)
    w = radius * np.stack([np.sqrt(1 - u**2), 0 * u, u], 1)
    ends = smidgen.build(spec.calm).start(w, h=h).step().state()[:, 2] / radius
    return stationary(factors[:, None] * transition(ends) * factors)


@pytest.mark.parametrize("form, kappa, radius, orientation, kT, alpha, B, known", [
    ("ll", 4.0, 1.0, 1, 0.5, 0.5, 1.0, .5372929093), ("ll", 4.0, 2.0, 1, 1.0, 0.5, 2.0, .5372929093), ("ll", 4.0, 2.0, 1, 1.0, 0.3, 2.0, .5372982702),
    ("gilbert", 4.0, 2.0, 1, 1.0, 0.3, 2.0, .5373008747), ("ll", 4.0, 1.0, -1, 0.5, 0.5, 1.0, .5372929093), ("ll", 0.5, 1.0, 1, 0.5, 0.5, 1.0, None),
    ("gilbert", 0.5, 2.0, -1, 1.0, 0.5, 2.0, None), ("ll", -1.0, 1.0, 1, 0.5, 0.5, 1.0, None), ("gilbert", -1.0, 2.0, -1, 1.0, 0.3, 2.0, None)])
def test_damping_balances_noise(form, kappa, radius, orientation, kT, alpha, B, known):
    """A spin in a field, B R/kT = 2: coth 2 - 1/2 up to h^2."""
    spec = spec_of(FIELD, form=form, kappa=kappa, radius=radius, orientation=orientation, kT=kT, alpha=alpha, B=B)
    found = {h: heights(spec, h, radius)[1] for h in (0.1, 0.05)}
    assert known is None or abs(found[0.1] - known) < 2e-10
    assert 3.9 < (found[0.1] - EXACT) / (found[0.05] - EXACT) < 4.1


@pytest.mark.parametrize("form", ["ll", pytest.param("gilbert", marks=pytest.mark.long)])
def test_the_mean_square_of_a_spin_with_an_easy_axis(form):
    """K = 1, kT = 1/2."""
    exact = quad(lambda u: u * u * np.exp(2 * u * u), -1, 1)[0] / quad(lambda u: np.exp(2 * u * u), -1, 1)[0]
    assert abs(exact - .531264557686533) < 1e-14
    biases = [(1 + 2 * heights(spec_of(AXIS, form=form), h)[2]) / 3 - exact for h in (0.2, 0.1, 0.05)]
    assert all(3.85 < before / after < 4.15 for before, after in zip(biases, biases[1:]))


@pytest.mark.parametrize("form, biases", [("ll", (-2.82543e-2, -7.30696e-3, -1.84316e-3)), ("gilbert", (-1.83728e-2, -4.69646e-3, -1.18091e-3))])
def test_two_spins(form, biases):
    """J = 1, kT = alpha = 1/2: their scalar product is a chain by itself, since noise turns both alike in all directions."""
    spec = spec_of("-dot(w[i], w[j])", "pair(i, j) of w", 2, form)
    u, one, diffusion = nodes()[0], smidgen.build(spec.calm), Witness(spec).diffusion[0]
    for h, bias in zip((0.4, 0.2, 0.1), biases):
        ends = [np.prod(one.start(np.array([[0, 0, 1.0], [np.sqrt(1 - c * c), 0, c]]), h=h).step().state(), axis=0).sum() for c in u]
        factors = heat(diffusion, h) ** 2
        found = stationary(factors[:, None] * transition(np.clip(ends, -1, 1)) * factors)
        assert abs(found[1] - EXACT - bias) < 6e-8 + 6e-6 * abs(bias)


def test_the_kernel_is_that_of_boltzmann_where_steps_are_small():
    """All of the distribution, not its mean alone."""
    found = heights(spec_of(FIELD), 0.02)
    exact = [quad(lambda u, l=l: legendre.legval(u, np.eye(5)[l]) * np.exp(2 * u), -1, 1)[0] / np.sinh(2) for l in range(5)]
    assert np.abs(found[:5] - exact).max() < 3e-5
