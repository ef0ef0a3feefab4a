"""Round-off walks at random: over 1e5, 1e6 and more steps it grows like sqrt(N), not like N."""
import numpy as np
import pytest
from support.measure import casimirs, energy, scatter, start_points
from support.systems import CLASSICAL, VESELOV, begin, model

EPSILON = np.finfo(float).eps


@pytest.mark.quick
def test_round_off_does_not_drift():
    """Ten times the steps: sqrt(10) times the error of a random walk, 10 times that of a drift."""
    one, orbits = model(begin("free_rigid_body")), start_points(12)
    for quantity in (energy, casimirs):
        early, late = scatter(one, orbits, 0.1, (100_000, 1_000_000), quantity)
        print(f"rms {quantity.__name__} error after 1e5, 1e6 steps: {early:.1e}, {late:.1e}")
        assert late < 6 * max(early, EPSILON / 2)
        assert late < 60 * EPSILON


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
