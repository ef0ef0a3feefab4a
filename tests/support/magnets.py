"""Magnets on lattices by name, and states near an order."""
import numpy as np
import smidgen

MAGNET = """[model]
name = "magnet"
orientation = {orientation}
[space]
w = {{ sphere = "{count}", kappa = 2, radius = 1.5 }}
[parameters]
n = {n}
J = {J}
[effects.exchange]
over = "bond(i, j) of {lattice}(n{more_n}, periodic)"
energy = "-J*dot(w[i], w[j])"
{more}
[starts.order]
theta = "{theta}"
phi = "{phi}"
[runs.demo]
start = "order"
h = 0.05
time = 120
output = {{ every = 4, what = ["states"] }}
"""
RATE = 0.8 * 1.5 / 2        # J r/kappa
NEEL, TURNS = "pi*mod(i + floor(i/n), 2)", "2*pi/3*(mod(i, n) + floor(i/n))"
FIELD = '[effects.field]\nover = "site(i) of w"\nenergy = "-0.2*w[i].z"\n'
AXIS = '[effects.axis]\nover = "site(i) of w"\nenergy = "-0.1*w[i].z^2"\n'
DMI = '[effects.dmi]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "-J*tan(2*pi/8)*cross(w[i], w[j]).z"\n'


def magnet(lattice, sites=1, n=6, theta="0", phi="0", J=0.8, more="", orientation=1):
    dimension = 1 if lattice in ("chain", "ladder") else 2
    return smidgen.load_text(MAGNET.format(lattice=lattice, count="*".join([str(sites)] + ["n"] * dimension), more_n=", n" * (dimension - 1), n=n, theta=theta,
                                           phi=phi, J=J, more=more, orientation=orientation))


def shaken(w, size=0.02, seed=5):
    """Near w: waves of every q at once, small enough not to meet."""
    moved = w + size * np.random.default_rng(seed).standard_normal(w.shape)
    return moved * (np.linalg.norm(w, axis=1) / np.linalg.norm(moved, axis=1))[:, None]
