"""Spins all parallel in strong fields, |h b| beyond 1/3: along a spin that stands still round-off would be the same in every step."""
import numpy as np
import pytest
import smidgen
from support.systems import tiers

LATTICES = {"square(n, n, periodic)": (16, 4), "cubic(n, n, n, periodic)": (64, 6)}     # sites with n = 4, neighbours
SPEC = """
[model]
name = "parallel"
[space]
w = {{ sphere = {sites} }}
[parameters]
n = {{ default = 4 }}
B = {{ default = 0 }}
[effects.exchange]
over = "bond(i, j) of {lattice}"
energy = "dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "B*w[i].z"
"""


def parallel(sites, seed):
    w = np.random.default_rng(seed).normal(size=3)
    return np.tile(w / np.linalg.norm(w), (sites, 1))


def lengths(model):
    return np.linalg.norm(model.state().astype(np.longdouble), axis=1)


def changes(lattice, field, strength, count, orbits=6):
    """|w_i| - |w_i(0)| after `count` steps, of every spin and orbit, in units of 2^-53."""
    sites, neighbours = LATTICES[lattice]
    model = smidgen.build(smidgen.load_text(SPEC.format(lattice=lattice, sites=sites)), parameters={"B": field})
    found = []
    for seed in range(orbits):
        model.start(parallel(sites, seed), h=strength / neighbours)
        before = lengths(model)
        found.append(lengths(model.steps(count)) - before)
    return np.array(found, float) * 2**53


@pytest.mark.parametrize("strength", [0.8, 1.2, 1.7, 2.8])
@pytest.mark.parametrize("lattice", LATTICES)
def test_spins_at_rest_keep_their_length(lattice, strength):
    """By rows up to 1.2, beyond it from site to site."""
    assert np.abs(changes(lattice, 0, strength, 1000)).max() < 3


@pytest.mark.parametrize("strength", [0.8, 1.2, pytest.param(1.7, marks=pytest.mark.long), 2.8])
@pytest.mark.parametrize("lattice", tiers(LATTICES, (), ("square(n, n, periodic)",)))
def test_lengths_walk_where_the_spins_turn_about_a_field(lattice, strength):
    """Half a unit in the last place a step, each of its own sign, would be sqrt(N)/2."""
    found = changes(lattice, 1, strength, 1000)
    assert np.sqrt(np.mean(found**2)) < np.sqrt(1000) / 2


@pytest.mark.quick
@pytest.mark.parametrize("strength", [0.8, 1.9, 2.8, 30])
def test_one_spin_along_its_field_stays(strength):
    """In closed form: the field, B z + 2 x - y, is along the spin."""
    text = SPEC.format(lattice="chain(n, open)", sites=1).replace("B*w[i].z", "B*(w[i].z + 2*w[i].x - w[i].y)").split("[effects.exchange]")
    spec = smidgen.load_text(text[0] + "[effects.field]" + text[1].split("[effects.field]")[1])
    w = np.array([[2, -1, 1]]) / np.sqrt(6)
    model = smidgen.build(spec, parameters={"B": 1}).start(w, h=strength / np.sqrt(6))
    before = lengths(model)
    assert np.abs(lengths(model.steps(1000)) - before).max() < 2**-52


if __name__ == "__main__":      # the numbers in docs/round_off.md
    for lattice in LATTICES:
        for field, strength in ((0, 1.2), (0, 2.8), (1, 0.8), (1, 1.2), (1, 1.7), (1, 2.8)):
            print(lattice, field, strength, *(f"{np.sqrt(np.mean(changes(lattice, field, strength, n)**2)):.2g}" for n in (10, 100, 1000)))
