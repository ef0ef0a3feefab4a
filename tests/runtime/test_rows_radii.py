"""Lattices by rows whose spheres have radii of their own."""
import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError
from support.by_sites import by_sites
from support.going_on import one_by_one, restored
from support.widths import same_in_lanes
from test_field_rows import NEAR
from test_rows import DM, EXCHANGE, HONEY, SKEW, lattice
from test_rows_held import ABSENT, PINNED
from test_rows_in_time import by_rows, field
from test_rows_laws import LAWS, close

RADII = ', radius = "1 + mod(i, 2)/2 + mod(i, 5)/7"'
STRENGTHS = ', kappa = "(4 + mod(i, 2))*(1 - 2*mod(i, 3)/3)"'
SPECS = {
    "open": lattice("radii", "square(n, 5, open)", 9, "5*n", EXCHANGE + DM + LAWS["all"], more=RADII),
    "blocks": lattice("radii", "square(n, 8, periodic)", 16, "8*n", EXCHANGE + DM + PINNED + field("-0.3*w[i].z^2*cos(t)"), more=RADII + STRENGTHS),
    "three colours": lattice("radii", "skew.near", 13, "4*n", EXCHANGE + ABSENT + field("-0.2*i*w[i].x/13"), SKEW, more=RADII),
    "honeycomb": lattice("radii", "honey.all", 5, "6*n", EXCHANGE + LAWS["gilbert"], HONEY, more=RADII),
    "drawn": lattice("radii", "chain(n, periodic)", 33, "n", EXCHANGE + LAWS["warm"], more=', radius = "0.5 + uniform(3, i)"')}
QUICK = ("open", "blocks")


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.long) for n in SPECS])
def test_rows_solve_the_step(name):
    """Against the witness, which knows no rows."""
    assert by_rows(SPECS[name]) and close(SPECS[name], 4, 5 if name == "drawn" else None) <= 4e-14


@pytest.mark.parametrize("name, method", [("honeycomb", "dormand-prince-8"), ("three colours", "dop853-projected"), *(pytest.param(n, "extrapolation-12", marks=pytest.mark.long) for n in ("blocks", "open"))])
def test_explicit_methods_evaluate_the_field_by_rows(name, method):
    model = smidgen.build(SPECS[name], method=method).start("random", h=0.08, t0=0.37)
    w = model.w.copy()
    end = Witness(SPECS[name]).steps(w, 0.37, 0.08, 3, method)[-1]
    assert by_rows(SPECS[name], method) and np.abs(model.steps(3).w - end).max() <= NEAR.get(method, 4e-14)


@pytest.mark.long
def test_states_are_those_from_site_to_site():
    """Where no h is small enough for rows, Newton proves the steps site by site."""
    ends = [build(SPECS["three colours"]).start("random", h=0.05).steps(12).w.copy() for build in (smidgen.build, by_sites)]
    assert np.abs(ends[0] - ends[1]).max() <= 2e-13


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes, name="open"):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SPECS[name])
    assert same_in_lanes(built, (2, 4, 8)) and same_in_lanes(lambda lanes: built(lanes, "blocks"), (4, 8))


@pytest.mark.long
def test_the_same_bits_for_two_threads(monkeypatch):
    wanted = smidgen.build(SPECS["open"]).start("random", h=0.08).steps(9).save()
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    assert np.array_equal(smidgen.build(SPECS["open"], threads=2).start("random", h=0.08).steps(9).save(), wanted)


@pytest.mark.parametrize("name", ["open", pytest.param("blocks", marks=pytest.mark.long)])
def test_restored_it_goes_on(name):
    model = smidgen.build(SPECS[name])
    assert restored(model) and one_by_one(model)


def test_one_large_sphere_decides():
    """For its radius no step of this h goes by rows: it has the state from site to site."""
    assert close(lattice("large", "chain(n, periodic)", 16, "n", EXCHANGE, more=', radius = "if(i == 5, 30, 1)"'), 3, rows=False) <= 1e-11


@pytest.mark.parametrize("energy, method, said", [("0.1*w[i].x^4", "spherical-midpoint", ", and the energy of `field` is not quadratic"), ("0.1*w[i].x", "gauss-4", "")])
def test_what_prevents_it_is_said(energy, method, said):
    spec = lattice("radii", "chain(n, periodic)", 16, "n", EXCHANGE + field(energy), more=RADII)
    assert generate(spec, method).notes["reason"].endswith(f"the radius of `w` differs from site to site{said}")


SMALL = lattice("small", "chain(n, periodic)", 16, "n", """r = {{ default = 1.0, size = "n" }}
f = {{ default = 1.0, size = "n" }}
""" + EXCHANGE.replace("-0.7", "-r[i]*r[j]"), more=', radius = "r[i]", kappa = "r[i]/f[i]"')


def fifth(model, w, h, size):
    """The status of a step, and where the fifth site is in units of its size."""
    try:
        return None, model.start(w.copy(), h=h).steps(1).w[5] / size
    except RunError as error:
        return error.status, np.zeros(3)


def test_a_small_sphere_whose_branch_ends_is_noticed():
    """It turns five times as fast as the others. In 2 of 60 large steps its midpoint runs into the centre; in units of the largest radius it hardly moves, and
    another solution was taken."""
    rng, ends = np.random.default_rng(1), []
    r, f = (np.where(np.arange(16) == 5, value, 1.0) for value in (2.0**-40, 5))
    by_row, alone = (build(SMALL, parameters={"r": list(r), "f": list(f)}) for build in (smidgen.build, by_sites))
    for _ in range(60):
        w = rng.normal(size=(16, 3))
        w *= (r / np.linalg.norm(w, axis=1))[:, None]
        h = rng.uniform(0.3, 0.9)
        ends.append((fifth(by_row, w, h, 2.0**-40), fifth(alone, w, h, 2.0**-40)))
    assert all(one[0] == other[0] and np.abs(one[1] - other[1]).max() < 1e-9 for one, other in ends)
    assert sum(one[0] is not None for one, _ in ends) == 2
