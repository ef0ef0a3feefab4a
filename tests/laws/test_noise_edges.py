"""Thermal steps that fail, and states with noise that cannot be: the state stays as it was, and the error says why."""
import ctypes

import numpy as np
import pytest
import smidgen
from smidgen.build.binary import build_library
from smidgen.compile.select import select
from smidgen.run.step.integrator import build
from smidgen.run.step.saved import H, HEAD
from test_noise import CUBE, PAIRS, SPIN, spec_of

SEED_HIGH, SEED_LOW, MEMBER, HALVED = range(HEAD, HEAD + 4)
WALL = """[effects.wall]
over = "site(i) of w"
energy = "1e-140*1e-140*exp(1300*w[i].x)"
"""


@pytest.mark.parametrize("place, values", [(H, [-0.1]), (SEED_HIGH, [-1, 0.5, 2.0**32]), (SEED_LOW, [-1, 0.5, 2.0**32]), (MEMBER, [-1, 0.5, 2.0**32]),
                                           (HALVED, [-1, 0.5, 2.0**49])])
def test_what_cannot_be_a_state_with_noise_is_refused(place, values):
    one = build(spec_of(SPIN)).start("a", h=0.1, seed=3, member=2).steps(3)
    before = one.save()
    for value in values:
        wrong = before.copy()
        wrong[place] = value
        with pytest.raises(smidgen.RunError, match="not a saved state"):
            one.restore(wrong)
        np.testing.assert_array_equal(one.save(), before)


@pytest.mark.parametrize("effects, h, why", [(PAIRS, 40.0, "no solution|converge|branch"), (WALL, 0.1, "finite")])
def test_a_step_that_fails_leaves_the_state_as_it_was(effects, h, why):
    """Two halves of a step that is far too large fail as well; what is no number is not tried again. No turn of the noise is left behind."""
    one, other = (build(spec_of(effects, 4)).start("a", h=h, seed=1) for _ in range(2))
    with pytest.raises(smidgen.RunError, match=why):
        one.steps(100)
    other.steps(one.count)
    assert one.halved == 0 and one.count < 100
    np.testing.assert_array_equal(one.w, other.w)


@pytest.mark.parametrize("kT, wrong", [("kT", -0.5), ("kT", float("inf")), ("kT*1e150*(1 + k)", 1e160)])
def test_a_temperature_that_cannot_be_is_refused_in_c(kT, wrong):
    """Where programs hand it over, whom nobody else warns."""
    make = ctypes.CDLL(str(build_library(select(spec_of(SPIN, 2, kT=kT), None)).binary)).warm_abi_new
    make.restype = ctypes.c_void_p
    w, status = (ctypes.c_double * 6)(*([0.6, 0.0, 0.8] * 2)), ctypes.c_int()
    for value in (wrong, 1e-3):
        state = make((ctypes.c_double * 2)(value, 0.5), None, w, ctypes.c_double(0), ctypes.c_double(0.1), ctypes.byref(status))
        assert (state is None) == (status.value != 0) == (value == wrong)


@pytest.mark.parametrize("sites", [1, 2])
@pytest.mark.parametrize("up", [1, -1])
def test_a_damped_spin_at_rest_on_the_top_has_no_long_step(up, sites):
    """(h/2) alpha |b| = 1 takes w to P: from there on the spin could as well be at the other end. At the bottom every step is one."""
    spec = spec_of(f"""[effects.field]
over = "site(i) of w"
energy = "{up}*w[i].z"
""", sites, form="ll").calm
    one, top = build(spec), np.tile([0.0, 0.0, up], (sites, 1))
    one.start(top.copy(), h=3.999).step()
    np.testing.assert_array_equal(one.w, top)
    for h in (4.0, 6.0):
        with pytest.raises(smidgen.RunError, match="steps exist up to .h. = 4:"):
            one.start(top.copy(), h=h).step()
        np.testing.assert_array_equal(one.w, top)
        np.testing.assert_array_equal(one.start(-top, h=h).step().w, -top)


@pytest.mark.parametrize("effects, solver", [(SPIN, "auto"), (PAIRS, "rotation")])
def test_a_vector_of_no_length_stays_where_it_is(effects, solver):
    spec = spec_of(effects, 2, "ll", space="r3 = {sites}").calm
    start = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.4]])
    one = build(spec, solver=solver).start(start.copy(), h=0.1).steps(3)
    assert not one.w[0].any() and abs(np.sqrt((one.w[1]**2).sum()) - 0.5) < 1e-15


SADDLE = """[effects.saddle]
over = "site(i) of w"
energy = "(w[i].x^2 - w[i].y^2)/2"
"""


@pytest.mark.parametrize("form, h, sites", [("ll", 1.6, 1), ("gilbert", 2.5, 2)])
def test_where_a_matrix_is_singular_two_halves_are_taken(form, h, sites):
    """(h/2)^2 (f^2 + q^2) = 1 at the pole, which heat of 1e-60 does not leave."""
    spec, pole = spec_of(SADDLE, sites, form, values="n = 6\nkT = 1e-60\nalpha = 0.75"), np.tile([0.0, 0.0, 1.0], (sites, 1))
    with pytest.raises(smidgen.RunError, match="singular"):
        build(spec.calm).start(pole.copy(), h=h).step()
    one = build(spec).start(pole.copy(), h=h, seed=1).step()
    assert one.halved == 1 and np.abs(one.w - pole).max() < 1e-25


def test_stages_of_two_halves_have_their_size():
    """A single sphere prepares its stages once for each h. Beside it a sphere that does nothing but be hot: the same path, by other code."""
    strong = """[effects.own]
over = "site(i) of w"
energy = "if(i == 0, 1, 0)*(1.5*w[i].x^2 + w[i].x*w[i].z + w[i].y)"
"""
    one, two = (build(spec_of(strong, sites, values="n = 6\nkT = 2.0\nalpha = 0.05"), method="spherical-midpoint-4") for sites in (1, 2))
    halved = 0
    for seed in range(40):
        for model in (one, two):
            model.start(np.tile([0.6, 0.0, 0.8], (model.sites, 1)), h=2.0, seed=seed).advance(4)
        assert one.count == two.count and one.halved == two.halved and np.abs(one.w[0] - two.w[0]).max() < 1e-9
        halved += one.halved
    assert halved > 0


@pytest.mark.parametrize("h", [0.05, 0.5])
def test_stages_by_rows_lie_between_the_same_noise(h):
    """Where sweeps are known to converge, and beyond; beside steps from site to site."""
    spec = spec_of(CUBE, 216, space='sphere = "n*n*n"', values="n = 6\nkT = 0.5\nalpha = 0.1")
    rows, sites = (build(spec, method="spherical-midpoint-4", solver=solver).start("a", h=h, seed=3).steps(2) for solver in ("auto", "plain"))
    assert np.abs(rows.w - sites.w).max() < 1e-11
