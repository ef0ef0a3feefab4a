"""Round-off walks at random: over 1e5, 1e6 and more steps it grows like sqrt(N), not like N."""
import numpy as np
import pytest
from support.measure import casimirs, energy, scatter, start_points
from support.systems import CLASSICAL, VESELOV, begin, model

EPSILON = np.finfo(float).eps


def changes(one, starts, h, count, quantity):
    """Change of a quantity of one site over `count` steps of h, for every start."""
    found = []
    for w in starts:
        before = np.ravel(quantity(one.start(w.copy(), h=h)))[0]
        found.append(np.ravel(quantity(one.steps(count)))[0] - before)
    return np.array(found)


def unbiased(found) -> bool:
    """Is the mean what a random walk of so many orbits may have, three and a half deviations?"""
    return abs(np.mean(found)) < 3.5 / np.sqrt(len(found)) * np.sqrt(np.mean(found**2))


@pytest.mark.quick
def test_a_bias_would_show():
    dice = np.random.default_rng(2).standard_normal(24)
    assert unbiased(dice) and not unbiased(dice + 1.2)


@pytest.mark.parametrize("h", [0.05, 0.0877, pytest.param(0.125, marks=pytest.mark.quick), 0.4])
def test_round_off_takes_no_side(h):
    """24 orbits of the free body: what each has lost or won has no common sign."""
    one = model(begin("free_rigid_body"))
    for quantity in (energy, casimirs):
        found = changes(one, start_points(24), h, 1_000_000, quantity)
        rms = np.sqrt(np.mean(found**2))
        print(f"h = {h}: {quantity.__name__} after 1e6 steps: rms {rms:.1e}, mean {found.mean():.1e}")
        assert unbiased(found) or rms < EPSILON
        assert rms < 60 * EPSILON


def test_round_off_of_large_steps():
    """At h = 1 a side is taken, but |w|^2 is no worse than the random walk of steps w += h X at
    h = 0.1 without a carry: 5.2e-14 after 1e6 steps."""
    found = changes(model(begin("free_rigid_body")), start_points(24), 1.0, 1_000_000, casimirs)
    assert np.sqrt(np.mean(found**2)) < 5.2e-14


@pytest.mark.parametrize("name, values", [("nambu_a39", {}), ("two_bodies", {}), ("point_vortices", {}),
                                          ("heisenberg_chain", {"n": 6})])
def test_casimirs_do_not_drift(name, values):
    case = begin(name, **values)
    early, late = scatter(model(case), [case.w], case.h, (100_000, 1_000_000), casimirs)
    print(f"{name}: rms casimir error after 1e5, 1e6 steps: {early:.1e}, {late:.1e}")
    assert late < 6 * max(early, 4 * EPSILON)        # few sites: below some ulps the law is noise
    assert late < 40 * EPSILON


@pytest.mark.parametrize("method", [CLASSICAL, VESELOV])
def test_comparators_do_not_drift(method):
    """A comparison of methods must not compare their round-off."""
    one = model(begin("free_rigid_body"), method)
    early, late = scatter(one, start_points(6), 0.1, (100_000, 1_000_000), energy)
    assert late < 6 * max(early, EPSILON / 2) and late < 20 * EPSILON


@pytest.mark.long
def test_round_off_does_not_drift_for_long():
    one, orbits = model(begin("free_rigid_body")), start_points(16)
    found = scatter(one, orbits, 0.1, (100_000, 1_000_000, 10_000_000), energy)
    print("rms energy error after 1e5, 1e6, 1e7 steps:", *(f"{e:.1e}" for e in found))
    assert found[2] < 6 * found[1] and found[2] < 2e-14
