"""Steps on lattices by name, with vectors of bonds in the energy, against the witness: by rows in lanes and from site to site."""
import numpy as np
import pytest

import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.language.crystals import CRYSTALS
from smidgen.language.places import bond_vectors, bonds, positions
from smidgen.run.step.evaluated import Evaluated

SPEC = """
[model]
name = "m"
[space]
w = {{ sphere = "{count}" }}
[parameters]
n = {n}
[effects.exchange]
over = "bond(i, j) of {lattice}"
energy = "-dot(w[i], w[j]) + 0.3*dot(r(i, j), cross(w[i], w[j])) + 0.2*dot(r(i, j), w[i])*dot(r(i, j), w[j])"
[effects.wave]
over = "site(i) of w"
energy = "-0.2*cos(0.7*r(i).x + 0.3*r(i).y - 0.4*r(i).z)*w[i].z"
[observables.spiral]
over = "bond(i, j) of {lattice}"
value = "dot(r(i, j), cross(w[i], w[j]))"
[starts.spiral]
theta = "1 + 0.1*cos(r(i).x)"
phi = "r(i).y + 2*r(i).z"
"""


def spec_of(name: str):
    d = CRYSTALS[name].directions
    sites = len(CRYSTALS[name].positions)
    return smidgen.load_text(SPEC.format(lattice=f"{name}({', '.join('n' * d)}, periodic)", count="*".join([str(sites), *"n" * d]), n={1: 16, 2: 6, 3: 4}[d]))


@pytest.mark.parametrize("name", [name if name in ("triangular", "honeycomb", "pyrochlore") else pytest.param(name, marks=pytest.mark.long) for name in CRYSTALS])
def test_a_step_by_rows_is_that_of_the_witness(name):
    spec = spec_of(name)
    notes = generate(spec, "spherical-midpoint", "auto").notes["reason"]
    assert "by rows" in notes
    result = smidgen.run(spec, start="spiral", h=0.02, steps=3, every=1)
    witness = Witness(spec)
    w = result.w["w"]
    assert np.abs(witness.residuals(w, 0.0, 0.02)).max() < 1e-15
    assert result.values["energy"][-1] == pytest.approx(witness.energy(w[-1]), abs=1e-12)


@pytest.mark.parametrize("name", ["kagome", pytest.param("pyrochlore", marks=pytest.mark.long)])
def test_formulas_of_places_have_the_values_that_geometry_gives(name):
    """By numpy, from positions and vectors of bonds alone."""
    spec = spec_of(name)
    values = Evaluated(spec).values
    r, pairs, along = positions(spec, "w", values), bonds(spec, "w", values), bond_vectors(spec, "w", values)
    theta, phi = 1 + 0.1 * np.cos(r[:, 0]), r[:, 1] + 2 * r[:, 2]
    w = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    a, b = w[pairs[:, 0]], w[pairs[:, 1]]
    spiral = np.sum(along * np.cross(a, b))
    exchange = -np.sum(a * b) + 0.3 * spiral + 0.2 * np.sum(np.sum(along * a, 1) * np.sum(along * b, 1))
    result = smidgen.run(spec, start="spiral", h=0.02, steps=1, what=["states", "energy", "spiral"])
    np.testing.assert_allclose(result.w["w"][0], w, atol=1e-13)
    assert result.values["energy.exchange"][0] == pytest.approx(exchange, abs=1e-11)
    assert result.values["energy.wave"][0] == pytest.approx(-0.2 * np.sum(np.cos(r @ [0.7, 0.3, -0.4]) * w[:, 2]), abs=1e-11)
    assert result.values["spiral"][0] == pytest.approx(spiral, abs=1e-11)


LISTED = """
[model]
name = "m"
[space]
w = { sphere = "n*n" }
[parameters]
n = 8
[lattices.film]
size = ["n", "n"]
boundary = "periodic"
vectors = [[1, 0], [0, 1]]
bonds.x = [{ offset = [1, 0] }]
bonds.y = [{ offset = [0, 1] }]
[starts.s]
random = 3
"""
TWO = LISTED + """
[effects.x]
over = "bond(i, j) of film.x"
energy = "0.5*triple(vec(0, 1, 0), w[i], w[j])"
[effects.y]
over = "bond(i, j) of film.y"
energy = "-0.5*triple(vec(1, 0, 0), w[i], w[j])"
"""
ONE = LISTED + """
[effects.moriya]
over = "bond(i, j) of film.first"
energy = "0.5*triple(cross(vec(0, 0, 1), r(i, j)), w[i], w[j])"
"""


@pytest.mark.parametrize("method", ["spherical-midpoint", pytest.param("sublattice-rotations", marks=pytest.mark.long), pytest.param("gauss-4", marks=pytest.mark.long)])
def test_a_vector_of_bonds_spares_lists_of_bonds_and_costs_no_bit(method):
    two, one = (smidgen.run(smidgen.load_text(text), start="s", method=method, h=0.05, steps=5).final for text in (TWO, ONE))
    np.testing.assert_array_equal(one, two)


NUMBERED = """
[effects.both]
over = "bond(i, j, b) of film.first"
energy = "uniform(3, b)*r(i, j).x*dot(w[i], w[j])"
"""


def test_a_formula_may_name_the_vector_and_the_number_of_a_bond():
    spec = smidgen.load_text(LISTED.replace("n = 8", "n = 4") + NUMBERED)
    assert "names both the vector and the number" in generate(spec, "spherical-midpoint", "auto").notes["reason"]
    w = smidgen.run(spec, start="s", h=0.05, steps=2, every=1).w["w"]
    assert np.abs(Witness(spec).residuals(w, 0.0, 0.05)).max() < 1e-15
