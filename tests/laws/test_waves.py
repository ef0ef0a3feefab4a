"""Waves and walls of chains, by laws in closed form: dispersion with field, anisotropy, Dzyaloshinskii-Moriya interaction and two sublattices; the width of a wall."""
import numpy as np
import pytest

import smidgen

CHAIN = """[model]
name = "waves"
[space]
w = {{ sphere = "n" }}
[parameters]
n = {n}
J = {J}
K = {K}
D = {D}
B = {B}
[lattices.line]
size = ["n"]
boundary = "{boundary}"
bonds.next = [{{ offset = [1] }}]
[effects]
exchange = {{ use = "spins/exchange", J = "J", bonds = "line.next" }}
easy = {{ use = "spins/uniaxial", K = "K" }}
moriya = {{ use = "spins/dmi", D = [0, 0, "D"], bonds = "line.next" }}
field = {{ use = "spins/zeeman", B = [0, 0, "B"] }}
{more}
[starts.up]
theta = 0
phi = 0
"""


def chain(n, J=1.0, K=0.0, D=0.0, B=0.0, boundary="periodic", more=""):
    return smidgen.load_text(CHAIN.format(n=n, J=J, K=K, D=D, B=B, boundary=boundary, more=more))


@pytest.mark.parametrize("K, D, B", [(0.0, 0.0, 0.0), (0.3, 0.0, 0.2), (0.0, 0.4, 0.0), (0.25, -0.35, 0.15)])
@pytest.mark.parametrize("q, height", [(2 * np.pi / 12, 0.9), (-5 * 2 * np.pi / 12, 0.4)])
def test_a_spiral_turns_at_the_rate_of_its_wave(K, D, B, q, height):
    """Of any height c of w.z: B + 2 c (K + J (1 - cos q) + D sin q), for c = 1 the dispersion of magnons."""
    j, J = np.arange(12), 0.8
    at = np.sqrt(1 - height**2) * np.exp(1j * q * j)
    one = smidgen.build(chain(12, J, K, D, B), method="gauss-8")
    one.start(np.stack([at.real, at.imag, np.full(12, height)], 1), h=0.05).steps(200)
    rate = B + 2 * height * (K + J * (1 - np.cos(q)) + D * np.sin(q))
    after = one.w[:, 0] + 1j * one.w[:, 1]
    assert np.abs(after - at * np.exp(1j * rate * 10)).max() < 1e-10 and np.abs(one.w[:, 2] - height).max() < 1e-12


@pytest.mark.parametrize("K, B", [(0.0, 0.0), (0.2, 0.0), (0.2, 0.1)])
@pytest.mark.parametrize("way", [1, -1])
def test_waves_of_two_sublattices(K, B, way):
    """Antiferromagnetic: B +- 2 sqrt((J + K)^2 - J^2 cos^2 q), up to the square of the amplitude."""
    n, J, q, size = 16, 0.7, 2 * np.pi * 3 / 16, 1e-5
    j = np.arange(n)
    omega = way * 2 * np.sqrt((J + K) ** 2 - (J * np.cos(q)) ** 2)
    small = size * np.exp(1j * q * j) * np.where(j % 2, (omega - 2 * (J + K)) / (2 * J * np.cos(q)), 1)
    small /= max(1, np.abs(small).max() / size)
    w = np.stack([small.real, small.imag, (1 - 2 * (j % 2)) * np.sqrt(1 - np.abs(small) ** 2)], 1)
    one = smidgen.build(chain(n, -J, K, 0.0, B), method="gauss-8").start(w, h=0.05).steps(200)
    assert np.abs(one.w[:, 0] + 1j * one.w[:, 1] - small * np.exp(1j * (omega + B) * 10)).max() < 1e-5 * size


@pytest.mark.parametrize("D", [0.0, pytest.param(0.2, marks=pytest.mark.long), 0.35])
def test_the_width_of_a_wall_with_dzyaloshinskii_moriya_interaction(D):
    """Far from its middle a wall at rest falls off by exp(-1/d) a site, 2 cosh(1/d) = 2 (J + K)/sqrt(J^2 + D^2), and turns by -atan(D/J): exactly, up to the
    square of what is left of it. D, which favours the turn, makes the wall wider."""
    J, K, n = 1.0, 0.15, 64
    one = smidgen.build(chain(n, J, K, D, boundary="open", more='damping = { use = "spins/damping", alpha = 0.8 }'))
    j = np.arange(n)
    theta, phi = 2 * np.arctan(np.exp((j - (n - 1) / 2) * np.sqrt(2 * K / J))), -np.arctan2(D, J) * j
    one.start(np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1), h=0.25).steps(2600)
    across = one.w[:, 0] + 1j * one.w[:, 1]
    falls = across[12:17] / across[13:18]         # towards the left end, where it is 1e-3 and less
    wanted = np.exp(-np.arccosh((J + K) / np.hypot(J, D)) + 1j * np.arctan2(D, J))
    assert np.abs(across[18]) < 0.02 and np.abs(falls / wanted - 1).max() < 3e-4
