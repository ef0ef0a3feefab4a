"""Sites that do more than precess: every layout and method takes the step that the equation says, or refuses it when it is generated."""
from importlib import import_module

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.responses import Law, files_of, integrator, library, midpoint

import smidgen
from smidgen.compile.plan.contributions import contributions_of
from smidgen.compile.plan.plan import choose
from smidgen.effects.motion import Contribution
from smidgen.errors import RunError, UsageError
from smidgen.methods import METHODS

LAW = Law(0.8, 0.3, (0.1, -0.2, 0.05), (-0.1, 0.02, 0.2))
LL = Law(q=0.3)
B, Z, A = np.array([0.3, -0.7, 0.4]), np.array([0, 0, 1]), np.array([1, 0.5, 0.25])
FIELD = """[effects.field]
over = "site(i) of w"
energy = "0.7*w[i].y - 0.3*w[i].x - 0.4*w[i].z"
"""
AXIS = """[effects.axis]
over = "site(i) of w"
energy = "-0.3*w[i].z^2"
"""
PAIRS = """[effects.pairs]
over = "pair(i, j) of w"
energy = "dot(w[i], w[j])"
"""
CHAIN = """[effects.bonds]
over = "bond(i, j) of chain(n, periodic)"
energy = "-dot(w[i], w[j])"
"""
BODY = """[effects.body]
over = "site(i) of w"
energy = "w[i].x^2/2 + w[i].y^2/4 + w[i].z^2/8"
"""


def neighbours(m):
    return np.roll(m, 1, 0) + np.roll(m, -1, 0)


# name -> (factor of the space, kappa, effects, dH/dw)
CASES = {
    "body": ("sphere = 1", 1.5, BODY, lambda m: m * A),
    "fields": ("sphere = 3, radius = 2", 1.7, FIELD, lambda m: 0 * m - B),
    "few": ("sphere = 4", 1, PAIRS + AXIS + FIELD, lambda m: m.sum(0) - m - 0.6 * m * Z - B),
    "chain": ("sphere = 'n', radius = 1.3", 0.9, CHAIN + AXIS + FIELD, lambda m: -neighbours(m) - 0.6 * m * Z - B),
    "bonds": ("sphere = 'n'", 1, CHAIN, lambda m: -neighbours(m)),
    "r3": ("r3 = 3", 1, PAIRS + AXIS, lambda m: m.sum(0) - m - 0.6 * m * Z),
}
quick = pytest.mark.quick


def spec_of(name):
    factor, kappa, effects, _ = CASES[name]
    sizes = "[parameters]\nn = 40\n" if "n" in factor.split("=")[1] else ""
    return smidgen.load_text(f'[model]\nname = "{name}"\n[space]\nw = {{ {factor}, kappa = {kappa} }}\n{sizes}{effects}[starts.a]\nrandom = 1\n')


def lengths(w):
    return np.sqrt((w * w).sum(-1))


@pytest.mark.parametrize("name, solver", [
    pytest.param("body", "auto", marks=quick), pytest.param("fields", "auto", marks=quick), pytest.param("few", "auto", marks=quick), ("few", "newton"),
    ("few", "rotation"), ("few", "plain"), ("chain", "auto"), ("chain", "newton"), ("chain", "rotation"), ("chain", "plain"), ("bonds", "auto"),
    ("bonds", "rotation"), ("r3", "newton"), ("r3", "rotation")])
@pytest.mark.parametrize("h", [0.1, 0.3])
def test_a_step_is_that_of_the_equation(name, solver, h):
    """To round-off, and the lengths stay through 300 steps."""
    _, kappa, _, gradient = CASES[name]
    one = integrator(spec_of(name), LAW, solver=solver).start("a", h=h)
    first = one.w.copy()
    expected = midpoint(first, h, kappa, gradient, LAW)
    one.step()
    assert np.abs(one.w - expected).max() < 1e-15
    one.steps(300)
    assert np.abs(lengths(one.w) / lengths(first) - 1).max() < 1e-15


@pytest.mark.parametrize("name, lanes", [("few", True), ("chain", True), ("bonds", True), ("r3", False)])
@pytest.mark.quick
def test_few_sites_and_rows_go_in_lanes(name, lanes):
    assert files_of(spec_of(name), LAW.response()).notes["lanes"] == lanes


def test_damped_precession():
    """In a field along z: the state at t = 10 by 100 steps, worked out apart from this program; off the closed form by h^2."""
    spec = smidgen.load_text('[model]\nname = "spin"\n[space]\nw = { sphere = 1 }\n[effects.field]\nover = "site(i) of w"\nenergy = "-w[i].z"\n'
                             '[starts.a]\ntheta = 1\nphi = 0\n')
    one = integrator(spec, Law(q=0.1)).start("a", h=0.1).steps(100)
    assert np.abs(one.w - [-0.32533220334546, -0.20938603546176, 0.92212604649256]).max() < 1e-13
    height = np.tanh(1 + np.arctanh(np.cos(1)))
    phase = np.sqrt(1 - height**2) * np.array([np.cos(10), np.sin(10)])
    assert np.abs(one.w - [*phase, height]).max() < 2e-3


@pytest.mark.parametrize("law, height, part", [(Law(), 0.0, 0.5), (Law(q=0.1), -0.15, 0.75)])
def test_a_spin_without_a_step_says_up_to_which_part_of_h_there_is_one(law, height, part):
    """|h F| = 4: across F it has none from |h F| = 2 on. With Q it has none from where w - P is across G and no longer than G, G = (h/2) F and P = (h/2) Q:
    P = 0.1 G, w.G = 0.3 and |G| = 2 at h, so at 0.3/(0.1 |G|^2) = 3/4 of it."""
    spec = smidgen.load_text('[model]\nname = "across"\n[space]\nw = { sphere = 1 }\n[effects.field]\nover = "site(i) of w"\nenergy = "-w[i].z"\n'
                             '[starts.a]\nrandom = 1\n')
    first = np.array([[np.sqrt(1 - height**2), 0, height]])
    one = integrator(spec, law)
    with pytest.raises(RunError, match="no solution"):
        one.start(first.copy(), h=4.0).step()
    assert abs(one.report()["reached"] - part) < 1e-12 and np.array_equal(one.w, first)
    one.start(first.copy(), h=4 * part - 0.01).step()
    assert np.abs(lengths(one.w) - 1).max() < 1e-15


def end_of(name, first, time, law):
    _, kappa, _, gradient = CASES[name]

    def slope(t, w):
        w = w.reshape(-1, 3)
        return (law.torque(w, gradient(w)) / kappa).ravel()
    return solve_ivp(slope, (0, time), first.ravel(), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1].reshape(-1, 3)


RESPONDING = [m for m in METHODS if METHODS[m].responds and (METHODS[m].stages == 1 or m in ("spherical-midpoint-4", "spherical-midpoint-6", "classical-midpoint-4"))]
SOME = ("spherical-midpoint", "cf4", "gauss-4")


@pytest.mark.parametrize("name", ["body", "few"])
@pytest.mark.parametrize("method", [pytest.param(m, marks=() if m in SOME else pytest.mark.long) for m in RESPONDING])
def test_every_method_goes_to_the_same_end_at_its_order(method, name):
    """At the time 2 beside a library's integrator, which is right to some 1e-13; the error falls as the order says until it meets that."""
    one, errors = integrator(spec_of(name), LAW, method), []
    for steps in (20, 40):
        one.start("a", h=2 / steps)
        first = one.w.copy()
        one.steps(steps)
        errors.append(np.abs(one.w - end_of(name, first, 2, LAW)).max())
        assert np.abs(lengths(one.w) - lengths(first)).max() < (1e-15 if METHODS[method].keeps_leaf else 1e-12)
    assert errors[1] < 3e-13 or np.log2(errors[0] / errors[1]) > METHODS[method].order - 0.2


@pytest.mark.parametrize("method", [m for m in METHODS if not METHODS[m].responds and METHODS[m].stages == 1])
@pytest.mark.quick
def test_methods_without_such_a_step_refuse_it(method):
    spec = spec_of("body")
    with pytest.raises(UsageError, match=r"does not support damping \(effect 'stub'\); use spherical-midpoint or|'stub' does not derive from an energy"):
        files_of(spec, LL.response(), method)


@pytest.mark.quick
def test_what_else_is_refused():
    """Extended precision, Nambu leaves, and two laws for one family."""
    with pytest.raises(UsageError, match="feature extended requires sites that only precess"):
        files_of(spec_of("body"), LL.response(), features=("extended",))
    with pytest.raises(UsageError, match="but 'w' is a Nambu factor"):
        files_of(smidgen.load("nambu_a31"), LL.response())
    twice = [Contribution(name, (("w", "i"),), conservative=False, response=LL.response()) for name in ("one", "two")]
    with pytest.raises(UsageError, match="'two' is a second law of motion for 'w'"):
        choose(spec_of("body"), "spherical-midpoint", "auto", (*contributions_of(spec_of("body")), *twice))


def pushed(one, first, h, v):
    one.start(first.copy(), h=h).step()
    return one.tangent(v[None].copy())[0], one.w.copy()


@pytest.mark.parametrize("name, solver", [("body", "auto"), ("fields", "auto"), ("few", "auto"), ("chain", "auto"), ("chain", "rotation"), ("r3", "auto")])
def test_the_tangent_map_is_the_derivative_of_the_step(name, solver):
    """By central differences in extended precision, along directions tangent to the spheres."""
    one, step = integrator(spec_of(name), LAW, solver=solver, real="long double", features=("tangent",)), np.longdouble(1e-5)
    first = one.start("a", h=0.2).w.copy()
    v = np.random.default_rng(5).normal(size=first.shape).astype(np.longdouble)
    radius = np.sqrt((first * first).sum(1, keepdims=True))
    v -= first * (first * v).sum(1, keepdims=True) / radius**2
    found, _ = pushed(one, first, 0.2, v)
    ends = []
    for sign in (1, -1):
        w = first + sign * step * v
        w *= radius / np.sqrt((w * w).sum(1, keepdims=True))
        ends.append(pushed(one, w, 0.2, v)[1])
    assert np.abs((ends[0] - ends[1]) / (2 * step) - found).max() < 1e-9 * np.abs(found).max()


@pytest.mark.parametrize("name, method", [("body", "spherical-midpoint"), ("body", "dop853"), ("body", "extrapolation-12"), ("few", "spherical-midpoint")])
def test_members_of_an_ensemble_have_the_bits_that_they_have_alone(name, method, monkeypatch):
    """Those of a single sphere in lanes."""
    spec = spec_of(name)
    monkeypatch.setattr(import_module("smidgen.run.many.ensemble"), "build_library", lambda scene, method, solver, real, native, features, plan, fast=False: library(scene, LAW.response(), method, solver, real, native, features))
    sites, rng = (1 if name == "body" else 4), np.random.default_rng(2)
    starts = rng.normal(size=(20, sites, 3))
    starts /= lengths(starts)[..., None]
    found = smidgen.ensemble(spec, start=starts, h=0.2, steps=50, method=method)
    one = integrator(spec, LAW, method)
    assert not found.failures and (found.lanes > 1) == (name == "body")
    for k, w in enumerate(starts):
        assert np.array_equal(one.start(w.copy(), h=0.2).steps(50).w, found.w[k])
