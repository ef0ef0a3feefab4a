"""A tolerance of a step: iterations end there, step control aims at it, and it is recorded."""
import numpy as np
import pytest

import smidgen
from smidgen.errors import UsageError
from smidgen.methods import METHODS
from smidgen.run.step.saved import HISTORY, TOLERANCE

ITERATED = [("heisenberg_chain", "spherical-midpoint", "newton"), ("heisenberg_chain", "spherical-midpoint", "auto"), ("point_vortices", "spherical-midpoint", "auto"),
            ("point_vortices", "spherical-midpoint", "rotation"), ("two_bodies", "classical-midpoint", "auto"), ("nambu_a31", "spherical-midpoint", "auto"),
            ("point_vortices", "gauss-6", "auto"), ("irreversible_rigid_body", "gauss-8", "auto"), ("point_vortices", "isospectral-midpoint", "auto"),
            ("irreversible_rigid_body", "geodesic-midpoint", "auto"), ("irreversible_rigid_body", "exponential-midpoint", "auto"),
            ("irreversible_rigid_body", "rattle", "auto"), ("point_vortices", "spherical-midpoint-4", "auto")]


def stepped(name, method, solver, tolerance, steps=40, h=0.1):
    spec = smidgen.load(name)
    model = smidgen.build(spec, method=method, solver=solver)
    iterations = 0
    model.start(spec.runs[0].start, h=h, tolerance=tolerance)
    for _ in range(steps):
        iterations += model.step().report()["iterations"]
    return model.state(), iterations, model


@pytest.mark.parametrize("name, method, solver", ITERATED)
def test_iterations_end_at_the_tolerance(name, method, solver):
    exact, all_of_them, _ = stepped(name, method, solver, None)
    for tolerance in (1e-4, 1e-8):
        found, fewer, model = stepped(name, method, solver, tolerance)
        assert fewer < all_of_them
        if METHODS[method].of_midpoints:        # Gauss looks ahead: what the last change leaves
            assert model.report()["residual"] <= tolerance * np.abs(model.w).max()
        assert np.abs(found - exact).max() < 300 * tolerance
    assert not np.array_equal(found, exact)


@pytest.mark.parametrize("name, h", [("point_vortices", 0.3), ("irreversible_rigid_body", 0.1)])
@pytest.mark.parametrize("method", ["isospectral-midpoint", "geodesic-midpoint", "exponential-midpoint", "rattle"])
def test_slopes_leave_a_few_tolerances_at_most(name, h, method):
    """Also where a change is small because changes alternate between large and small: with the slopes of steps before, and from rest."""
    spec = smidgen.load(name)
    model, exact = (smidgen.build(spec, method=method).start(spec.runs[0].start, h=h) for _ in range(2))
    for _ in range(12):
        exact.step()
        before, after = exact.save(), exact.step().state()
        for tolerance in 10.0 ** -np.arange(3, 11, 0.5):
            asked = model.start(exact.w.copy(), h=h, tolerance=tolerance).save()[TOLERANCE]
            for history in (before[HISTORY], 0):
                saved = before.copy()
                saved[TOLERANCE], saved[HISTORY] = asked, history
                left = np.abs(model.restore(saved).step().w - after).max()
                assert left <= 4 * tolerance * np.abs(after).max()


def test_step_control_aims_at_it():
    exact = stepped("point_vortices", "gauss-16", "auto", None, steps=80, h=0.5)[0]
    errors = [np.abs(stepped("point_vortices", "dop853", "auto", tolerance, steps=1, h=40.0)[0] - exact).max() for tolerance in (1e-4, 1e-7, 1e-10)]
    assert errors[0] < 1e-4 and errors[1] < errors[0] / 30 and errors[2] < errors[1] / 30, errors


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("h", [0.2, 0.5, 0.8])
def test_every_step_by_rows_leaves_less_than_the_tolerance(tolerance, h):
    """W - w = h X(m), m the midpoint on its sphere, as the new state itself leaves it; and what the step says."""
    spec = smidgen.load("heisenberg_chain")
    model = smidgen.build(spec, parameters={"n": 64}).start("random", h=h, tolerance=tolerance)
    for _ in range(40):
        w = model.state()
        W = model.step().state()
        m = (w + W) / np.linalg.norm(w + W, axis=1)[:, None]
        left = np.abs(W - w - h * spec.orientation * np.cross(m, np.roll(m, 1, 0) + np.roll(m, -1, 0))).max()
        assert left <= tolerance * np.abs(w).max() and model.report()["residual"] <= tolerance


@pytest.mark.quick
@pytest.mark.parametrize("method", ["spherical-midpoint", "gauss-6", "dop853", "spherical-midpoint-6"])
def test_a_saved_state_goes_on_with_its_tolerance(method):
    whole = stepped("point_vortices", method, "auto", 1e-6, steps=12)[0]
    model = stepped("point_vortices", method, "auto", 1e-6, steps=5)[2]
    saved = model.save()
    model.start(smidgen.load("point_vortices").runs[0].start, h=0.3)
    assert np.array_equal(model.restore(saved).steps(7).w, whole)


def test_no_tolerance_in_a_saved_state_is_that_of_the_method():
    """As 0 is for set_tolerance(); an explicit method would take any step as right."""
    model = smidgen.build(smidgen.load("irreversible_rigid_body"), method="dop853")
    model.start([[0.6, 0.8, 0]], h=3.0)
    saved = model.save()
    whole = model.steps(3).w.copy()
    assert saved[10] == 1e-12
    saved[10] = 0
    assert np.array_equal(model.restore(saved).steps(3).w, whole)


@pytest.mark.quick
@pytest.mark.parametrize("wrong", [0, -1e-6, 0.5, float("nan"), float("inf"), "1e-6"])
def test_what_is_no_tolerance_is_refused(wrong):
    with pytest.raises(UsageError, match="tolerance"):
        smidgen.build(smidgen.load("free_rigid_body")).start("paper", h=0.1, tolerance=wrong)


@pytest.mark.quick
def test_it_is_recorded_and_repeated(tmp_path, command):
    out = command("run", "point_vortices", "--steps", "20", "--tolerance", "1e-7", "--out", "a.npz")
    assert out.returncode == 0 and smidgen.load_result(tmp_path / "a.npz").meta["tolerance"] == 1e-7
    assert command("run", "--repeat", "a.npz", "--out", "b.npz").returncode == 0
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert command("run", "point_vortices", "--tolerance", "2").returncode == 2
    assert smidgen.load_result(tmp_path / "a.npz").final is not None


@pytest.mark.quick
def test_a_run_of_a_spec_may_have_one(tmp_path):
    text = (smidgen.load("free_rigid_body").sources[0][1]).rstrip() + '\n\n[runs.loose]\nstart = "paper"\nh = 0.1\nsteps = 10\nmethod = "gauss-6"\ntolerance = VALUE\n'
    assert smidgen.run(smidgen.load_text(text.replace("VALUE", "1e-5")), "loose").meta["tolerance"] == 1e-5
    for wrong in ("0", "-1e-3", "0.5", '"1e-5"', "nan"):
        with pytest.raises(smidgen.SpecError):
            smidgen.load_text(text.replace("VALUE", wrong))
