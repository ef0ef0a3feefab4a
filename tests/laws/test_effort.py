"""How many iterations a step takes: Newton squares its error, and a smooth orbit is predicted to round-off.

Counts, not seconds. A Newton matrix that lacks a term still converges, but only linearly, and a wrong
weight of the predictor only makes the first iterate worse: nothing but the count shows either.
"""
import numpy as np
import pytest
from support import texts
from support.systems import CLASSICAL, SPHERICAL, VESELOV, begin, model


def case_of(name, folder):
    """A shipped spec (chains of 20 sites), or one of tests/support/texts.py."""
    if name in ("GLASS", "MIXED", "OPEN_CHAIN", "CORNERS", "PULSE"):
        return begin(texts.read(getattr(texts, name), folder))
    return begin(name, **({"n": 20} if "chain" in name else {}))


def iterations(case, h, count, method=SPHERICAL, solver="auto"):
    """Of each of `count` steps of h from the spec's start."""
    one = model(case, method, solver=solver).start(case.w.copy(), h=h)
    return np.array([one.step().report()["iterations"] for _ in range(count)])


# The first step begins at rest, so with an error of h |X|/2. Squared four times 0.3 is 1e-8, and
# five times 1e-17: one or two more iterations confirm it.
NEWTON = [("point_vortices", SPHERICAL, "newton", 0.4), ("point_vortices", CLASSICAL, "auto", 0.4),
          ("product", SPHERICAL, "auto", 0.2), ("product", CLASSICAL, "auto", 0.2),
          ("heisenberg_chain", SPHERICAL, "newton", 0.4), ("heisenberg_chain", CLASSICAL, "newton", 0.4),
          ("j1j2_chain", SPHERICAL, "newton", 0.2), ("OPEN_CHAIN", SPHERICAL, "newton", 0.3),
          ("GLASS", SPHERICAL, "newton", 0.2), ("GLASS", CLASSICAL, "newton", 0.4), ("MIXED", SPHERICAL, "auto", 0.2),
          ("CORNERS", SPHERICAL, "auto", 0.05), ("two_bodies", SPHERICAL, "auto", 0.5),
          ("nambu_a38", SPHERICAL, "auto", 0.2), ("nambu_a39", SPHERICAL, "auto", 0.2),
          ("free_rigid_body", SPHERICAL, "auto", 0.5), ("free_rigid_body", CLASSICAL, "auto", 1.25),
          ("free_rigid_body", VESELOV, "auto", 1.25), ("forced_rigid_body", SPHERICAL, "auto", 0.6),
          ("PULSE", SPHERICAL, "auto", 0.2), ("test_particles", SPHERICAL, "newton", 0.5)]


FEW = ("point_vortices", "product", "heisenberg_chain", "GLASS", "CORNERS", "two_bodies", "free_rigid_body", "forced_rigid_body")


@pytest.mark.parametrize("name, method, solver, h", [pytest.param(*one, marks=() if one[0] in FEW and one[1] != CLASSICAL else pytest.mark.long)
                                                     for one in NEWTON])
def test_newton_squares_its_error(name, method, solver, h, tmp_path):
    found = iterations(case_of(name, tmp_path), h, 1, method, solver)[0]
    print(f"{name} {method} {solver} h = {h}: {found}")
    assert 2 <= found <= 5


def test_a_linear_iteration_would_show():
    """Sweeps at a fraction of the step where Newton takes five."""
    assert iterations(begin("heisenberg_chain", n=20), 0.1, 1, solver="rotation")[0] > 7


SMOOTH = [("point_vortices", "newton", 0.025), ("two_bodies", "auto", 0.0125), ("product", "auto", 0.0125),
          ("nambu_a39", "auto", 0.0125), ("free_rigid_body", "auto", 0.03), ("forced_rigid_body", "auto", 0.03),
          ("irreversible_rigid_body", "auto", 0.025), ("heisenberg_chain", "auto", 0.0025),
          ("heisenberg_chain", "plain", 0.0025), ("GLASS", "newton", 0.005)]


@pytest.mark.parametrize("name, solver, h", [pytest.param(*one, marks=() if one[0] in FEW else pytest.mark.long) for one in SMOOTH])
def test_small_steps_are_predicted_to_round_off(name, solver, h, tmp_path):
    """From some steps on a single iteration confirms the prediction, for as long as one likes; sweeps by rows of a lattice see it by a second."""
    found = iterations(case_of(name, tmp_path), h, 200, solver=solver)[30:]
    print(f"{name} {solver} h = {h}: {found.mean():.3f}")
    assert found.mean() <= (2 if (name, solver) == ("heisenberg_chain", "auto") else 1.1)


def test_the_degree_of_the_predictor_rises():
    """Ten times the step: a constant prediction would leave the first iterate ten thousand times worse."""
    early, late = iterations(begin("nambu_a39"), 0.05, 1)[0], iterations(begin("nambu_a39"), 0.05, 60)[-20:]
    assert early >= 3 and late.max() <= 1
