"""Steps and fields of any size: a step is OK with a state of numbers, or refused with the state as it was, in every method and layout, and after a bounded number of evaluations."""
import numpy as np
import pytest
import smidgen
from smidgen.errors import RunError
from smidgen.methods import METHODS as METHODS_BY_NAME
from smidgen.run.step.saved import H
from support.runtime_faults import Fault, plant
from support.systems import tiers
from test_set_state import LATE, LAYOUTS, SOME, bits, spec_of, start_of

NO_CONVERGENCE, NOT_FINITE = 1, 4
SIZES = (1e3, -1e8, 1e30, 1e100, -1e155, 1e200, 1e300, 1.7e308, -1.7e308)
CHAIN = """
[model]
name = "strong_chain"
[space]
w = { sphere = "n" }
[parameters]
n = 10
J = 1.0
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-J*dot(w[i], w[j])"
[starts.a]
random = 4
"""
METHODS = ("spherical-midpoint", "spherical-midpoint-6", "classical-midpoint", "gauss-2", "gauss-8", "dop853", "dop853-projected", "axis-splitting", "sublattice-rotations", "sublattice-rotations-4",
           "pair-rotations", "pair-rotations-6", "cf4", "isospectral-midpoint", "geodesic-midpoint",
           "exponential-midpoint", "rattle", "extrapolation-12")

KINDS = {}      # (spec, family) -> what its sites are


def stepped(model, most=1000):
    """The status of one step. Is it what it must be? Iterative methods take `most` evaluations of all sites."""
    before, w, t, count = model.save(), model.w.copy(), model.t, model.count
    KINDS.update({(model.spec.name, f.name): f.kind for f in model.spec.families})
    try:
        model.step()
    except RunError as refused:
        assert bits(model.save()) == bits(before) and model.t == t and model.count == count
        assert refused.status != NO_CONVERGENCE or model.report()["iterations"] <= most
        return refused.status
    assert np.isfinite(model.save()).all() and model.count == count + 1
    size = np.linalg.norm(model.w, axis=1)
    for f, (first, sites) in model.families.items():
        if KINDS[model.spec.name, f] == "sphere" and METHODS_BY_NAME[model.method].keeps_leaf:
            here = slice(first, first + sites)
            assert np.abs(size[here] / np.linalg.norm(w[here], axis=1) - 1).max() < 1e-9
    return 0


@pytest.mark.parametrize("name", tiers(LAYOUTS, SOME, [n for n in LAYOUTS if n not in (*LATE, "blocks by site, in time")]))
def test_a_huge_step(name):
    """The first of a trajectory, and one after others, which begins with their history."""
    one, method, small = LAYOUTS[name]
    model, w = smidgen.build(spec_of(one), method=method), start_of(spec_of(one))
    found = set()
    for h in SIZES:
        found.add(stepped(model.start(w.copy(), h=h), 10_000 if "dop853" in method else 1000))
        saved = model.start(w.copy(), h=small).steps(3).save()
        saved[H] = h
        found.add(stepped(model.restore(saved), 10_000 if "dop853" in method else 1000))
    assert found - {0}


@pytest.mark.parametrize("method", [m if m in ("gauss-8", "spherical-midpoint") else pytest.param(m, marks=pytest.mark.long) for m in METHODS])
def test_a_huge_field(method):
    spec = smidgen.load_text(CHAIN)
    for J in (1e20, -1e100, 1e150):
        model = smidgen.build(spec, method=method, parameters={"J": J})
        for h in (0.1, 1e100, 1e160, 1.7e308):
            stepped(model.start("a", h=h), 10_000)


@pytest.mark.quick
def test_gauss_by_rows_where_nothing_is_finite():
    model = smidgen.build(smidgen.load_text(CHAIN), method="gauss-8").start("a", h=1.7e308)
    assert stepped(model) == NOT_FINITE and model.t == 0


@pytest.mark.quick
def test_step_control_ends_where_it_sees_no_end():
    """308 steps within h = 100 of a body are few; where 10,000 do not do it is given up after some hundred."""
    body = smidgen.build(smidgen.load("free_rigid_body"), method="dop853").start(h=100.0)
    assert stepped(body) == 0 and 250 < body.report()["iterations"] < 350
    for h in (1e5, 1e8):
        assert stepped(body.start(h=h)) == NO_CONVERGENCE and body.report()["iterations"] <= 128
    chain = smidgen.build(smidgen.load_text(CHAIN), method="dop853", parameters={"n": 64}).start("a", h=1e6)
    assert stepped(chain) == NO_CONVERGENCE and chain.report()["iterations"] <= 128


@pytest.mark.parametrize("method", ["dop853", "dop853-projected", "spherical-midpoint", "extrapolation-12"])
def test_members_in_lanes_end_where_they_end_alone(method):
    """Of members of one ensemble some have a step and some have none."""
    spec, rng = smidgen.load("free_rigid_body"), np.random.default_rng(2)
    w, own = rng.standard_normal((13, 1, 3)), {"I1": 10.0 ** rng.uniform(-2, 5, 13)}
    w /= np.linalg.norm(w, axis=2)[..., None]
    for h in (300.0, 1e150, 1.7e308):
        found = smidgen.ensemble(spec, start=w, parameters=own, h=h, steps=2, method=method)
        for k in range(13):
            alone = smidgen.build(spec, method=method, parameters={"I1": own["I1"][k]}).start(w[k].copy(), h=h)
            done = alone.advance(2)
            assert found.steps[k] == done and bits(found.w[k]) == bits(alone.state())
        assert np.isfinite(found.w).all() and (h != 300 or method != "dop853" or 0 < np.count_nonzero(found.status) < 13)


# -- evaluations of all sites, counted: sweeps, midpoints, products with Newton's matrix; not those of the curve of solutions

COUNTED = Fault("", "smg_small.h", "/* The smaller and the larger;", "static int smg_evaluated, smg_evaluations = 1;\n/* The smaller and the larger;", (), more=(
    ("smg_matrix_free.h", "  smg_hessian_vector(s);\n", "  smg_evaluated += smg_evaluations;\n  smg_hessian_vector(s);\n"),
    ("smg_coupled.h", "  smg_project_all(s);\n", "  smg_evaluated += smg_evaluations;\n  smg_project_all(s);\n"),
    ("smg_row_settle.h", "  smg_take_pass(s, pass, &moved, sweep);", "  smg_evaluated += smg_evaluations * (pass.colour == 0);\n  smg_take_pass(s, pass, &moved, sweep);"),
    ("smg_row_beyond.h", "  a->slope = slope;", "  smg_evaluated += smg_evaluations;\n  a->slope = slope;"),
    ("smg_step.h", "  const smg_status followed = smg_follow_branch(s, h);", "  smg_evaluations = 0;\n  const smg_status followed = smg_follow_branch(s, h);\n  smg_evaluations = 1;"),
    ("smg_step.h", "  s->report.status = smg_solve_step(s, h);", "  smg_evaluated = 0;\n  s->report.status = smg_solve_step(s, h);\n  s->report.iterations = smg_evaluated;")))
SQUARE = """
[model]
name = "square_in_field"
[space]
w = { sphere = "n*n" }
[parameters]
n = 12
[effects.exchange]
over = "bond(i, j) of square(n, n, periodic, periodic)"
energy = "-dot(w[i], w[j])"
[effects.cubic]
over = "site(i) of w"
energy = "w[i].x^3"
[starts.a]
random = 4
"""


@pytest.mark.parametrize("method", ["spherical-midpoint", pytest.param("classical-midpoint", marks=pytest.mark.long)])
@pytest.mark.usefixtures("optimised_here")
def test_iterations_end_after_fifteen_hundred_evaluations(method, monkeypatch, tmp_path):
    """Sweeps, two tries of Newton with GMRES, and the ends of steps together, near the largest steps that there are: without a bound up to 3249 of them."""
    plant(monkeypatch, tmp_path, COUNTED)
    model, found = smidgen.build(smidgen.load_text(SQUARE), method=method), []
    for h in (0.7, 0.8, 0.9):
        for seed in range(9 if method == "classical-midpoint" else 3):
            model.start("a", h=h, seed=seed)
            stepped(model)
            found.append(model.report()["iterations"])
    assert 600 < max(found) <= 1500, found
