"""Sites that feel only themselves go by rows too, as a lattice of one colour whose sites have no neighbours: the step that the equation has, the state from site to site, the same bits however many go at once."""
import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from support.going_on import one_by_one, restored
from support.strict import COMPILERS
from support.widths import same_by_clang, same_in_lanes
from test_rows_by_site import KINDS
from test_rows_in_time import MIDPOINT, by_rows

N = 37
OWN = 'over = "site(i) of w"\n'
MORE = {**{name: f'{OWN}energy = "{energy}"' for name, energy in KINDS.items()},
        "constant field": f'{OWN}energy = "-0.5*w[i].z + 0.2*w[i].x"', "quartic": f'{OWN}energy = "-0.2*(w[i].x^4 + w[i].y^4) + 0.3*w[i].x*w[i].y*w[i].z"', "exponential": f'{OWN}energy = "0.3*exp(0.5*w[i].x) - 0.2*w[i].z"',
        "damping": f'{OWN}damping = "0.1 + 0.05*mod(i, 2)"\n[effects.field]\n{OWN}energy = "-0.5*w[i].z - 0.2*w[i].x^2"', "torque": f'{OWN}torque = "0.2*cross(w[i], cross(w[i], vec(0, 1, 0)))"\n[effects.field]\n{OWN}energy = "-0.5*w[i].z"',
        "pinned": f'{OWN}pinned = "mod(i, 5) < 1"\n[effects.field]\n{OWN}energy = "-0.5*w[i].z - 0.2*w[i].x^2"', "absent": f'{OWN}absent = "mod(i, 5) < 1"\n[effects.field]\n{OWN}energy = "-0.5*w[i].z - 0.2*w[i].x^2"'}
QUICK = ("anisotropy", "a wave", "damping", "absent")
SPACES = {"kappa": ', kappa = "1 + 0.5*mod(i, 3)"', "radius": ', radius = "1 + 0.5*mod(i, 3)"', "tracers": ", tracer = true"}
METHODS = ("spherical-midpoint-4", "classical-midpoint", "gauss-4", "dop853", "extrapolation-12")


def free(effect: str, space: str = "", n: int = N):
    dice = np.random.default_rng(1)
    a, b = ([round(x, 3) for x in dice.uniform(-1, 1, n)] for _ in "ab")
    lines = ",\n ".join(map(str, a)), ",\n ".join(map(str, b))
    return smidgen.load_text(f'[model]\nname = "free_spins"\n[space]\nw = {{ sphere = "n"{space} }}\n[parameters]\nn = {n}\nomega = 2.0\na = {{ default = [{lines[0]}], size = "n" }}\nb = {{ default = [{lines[1]}], size = "n" }}\n'
                             f'[effects.own]\n{effect}\n[starts.random]\nrandom = 1\n')


def apart(spec, h=0.08, steps=12) -> float:
    """The largest distance of states by rows from those that Newton finds site by site, part of the largest component."""
    by_row, by_site = (smidgen.build(spec, solver=solver).start("random", h=h, t0=0.2).steps(steps).w.copy() for solver in ("auto", "newton"))
    return np.abs(by_row - by_site).max() / np.abs(by_site).max()


@pytest.mark.parametrize("kind", [pytest.param(k, marks=() if k in QUICK else pytest.mark.long) for k in MORE])
def test_states_are_those_from_site_to_site(kind):
    spec = free(MORE[kind])
    assert by_rows(spec) and not by_rows_if_asked_for_newton(spec)
    assert apart(spec) <= 1e-13


def by_rows_if_asked_for_newton(spec) -> bool:
    return "define SMG_BY_ROWS" in "".join(generate(spec, MIDPOINT, solver="newton").values())


@pytest.mark.parametrize("space", [pytest.param(s, marks=() if s == "radius" else pytest.mark.long) for s in SPACES])
def test_families(space):
    spec = free(f'{OWN}energy = "-0.5*w[i].z + 0.2*w[i].x^2*a[i]"' if space != "radius" else f'{OWN}energy = "-0.5*w[i].z + 0.2*w[i].x^2"', SPACES[space])
    assert by_rows(spec) and apart(spec) <= 1e-13


@pytest.mark.parametrize("method", [pytest.param(m, marks=() if m == "gauss-4" else pytest.mark.long) for m in METHODS])
def test_methods(method):
    """They converge to the flow, at the order of two or more: to what a composition of order 4 finds site by site in steps of 0.005."""
    spec = free(MORE["anisotropy"])
    assert by_rows(spec, method)
    model = smidgen.build(spec, method=method)
    flow = smidgen.build(spec, method="spherical-midpoint-4", solver="newton").start("random", h=0.005, t0=0.2).steps(80).w.copy()
    whole, half = (np.abs(model.start("random", h=0.1 / n, t0=0.2).steps(4 * n).w - flow).max() for n in (1, 4))
    assert half <= max(whole / 12, 1e-8) and whole <= 1e-3


def test_beyond_the_bound_each_site_is_solved_by_newton():
    """The same solution, on the same branch."""
    spec = free(MORE["anisotropy"])
    model = smidgen.build(spec).start("random", h=2.5)
    other = smidgen.build(spec, solver="newton").start("random", h=2.5)
    model.steps(3)
    assert np.abs(model.w - other.steps(3).w).max() <= 1e-13
    assert model.report()["iterations"] == other.report()["iterations"]


@pytest.mark.parametrize("n", [1, 7, 8, 9, 300])
def test_any_number_of_sites(n):
    assert apart(free(MORE["phases"], n=n)) <= 1e-13


def test_few_sites_go_one_by_one():
    """Fewer than lanes, by a number that is known when the C is written."""
    text = '[model]\nname = "few"\n[space]\nw = {{ sphere = {} }}\n[effects.own]\nover = "site(i) of w"\nenergy = "-w[i].z^2"\n[starts.random]\nrandom = 1\n'
    assert not by_rows(smidgen.load_text(text.format(7))) and by_rows(smidgen.load_text(text.format(8)))


def test_several_families_go_one_by_one():
    text = '[model]\nname = "two"\n[space]\nw = { sphere = 20 }\nv = { sphere = 20 }\n[effects.own]\nover = "site(i) of w"\nenergy = "-w[i].z^2"\n[starts.s.w]\nrandom = 1\n[starts.s.v]\nrandom = 2\n'
    assert not by_rows(smidgen.load_text(text))


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes, method=MIDPOINT, compiler="gcc"):
        monkeypatch.setenv("CC", f"{compiler} -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(free(MORE["both in one"]), method=method)
    assert same_in_lanes(built, (2, 4, 8)) and same_in_lanes(lambda lanes: built(lanes, "gauss-4"), (4,))
    if "clang" in COMPILERS:
        assert same_by_clang(built)


@pytest.mark.parametrize("method", [MIDPOINT, pytest.param("gauss-4", marks=pytest.mark.long)])
def test_restored_it_goes_on(method):
    model = smidgen.build(free(MORE["phases"]), method=method)
    assert restored(model) and one_by_one(model)


def test_the_tangent_map_is_that_from_site_to_site():
    spec = free(MORE["both in one"])
    pushed = []
    for how in ({}, {"solver": "newton"}):
        model = smidgen.build(spec, features=("tangent",), **how)
        pushed.append(tangent_of(model))
    assert np.abs(pushed[0] - pushed[1]).max() <= 1e-12


def tangent_of(model):
    """Of the last step, from a vector that is tangent before it."""
    w = model.start("random", h=0.08).w.copy()
    v = np.cross(w, [0.3, 0.0, 1.0])
    return model.steps(1).tangent(v).copy()


def test_noise_is_that_from_site_to_site():
    spec = free(f'{OWN}damping = "0.1"\nkT = 0.3\n[effects.field]\n{OWN}energy = "-0.5*w[i].z^2"')
    assert by_rows(spec)
    some = [smidgen.build(spec, **how).start("random", h=0.05).steps(20).w.copy() for how in ({}, {"solver": "newton"})]
    assert np.abs(some[0] - some[1]).max() <= 1e-13
