"""Fields whose terms cancel: h X(m) next to a vortex is off by far more than ulps of its products, and a step ends at that.

A tracer at the distance d of a vortex of strength 1 turns about it by h/(2 pi d^2). Rounding 2 - 2 w.w, which is d^2, by some ulps moves
u = h X(m) by as many times 2 ulp h/(2 pi d^2)/d.
"""
import numpy as np
import pytest

import smidgen
from smidgen.check.verify.case import EPS, Case
from smidgen.check.verify.sums import sums
from smidgen.check.verify.subject import emitted
from smidgen.check.witness import Witness
from smidgen.errors import RunError
from smidgen.run.settings import settle

VORTEX = """
[model]
name = "one_vortex"
[space]
w = { sphere = 1 }
[effects.vortex]
over = "site(i) of w"
energy = "-log(2 - 2*(0.6*w[i].x + 0.64*w[i].y + 0.48*w[i].z))/(4*pi)"
"""
JUMP = """
[model]
name = "jump"
[space]
w = { sphere = 1 }
[effects.field]
over = "site(i) of w"
energy = "w[i].x + 0.3*w[i].x*w[i].y"
[effects.jump]
over = "site(i) of w"
energy = "-SIZE*abs(w[i].z)"
"""
ROTATING = """
[model]
name = "rotating"
[space]
w = { sphere = 3, kappa = "gamma[i]" }
p = { sphere = "m", tracer = true }
[parameters]
m = { default = 20 }
gamma = { default = [1.0, -0.6, 0.8], size = 3, fixed = true }
omega = { default = 0.1 }
[effects.interaction]
over = "pair(i, j) of w"
energy = "-gamma[i]*gamma[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"
[effects.transport]
over = "each(i of p, j of w)"
energy = "-gamma[j]*log(2 - 2*dot(p[i], w[j]))/(4*pi)"
[effects.background]
over = "site(i) of w"
energy = "-omega*gamma[i]*w[i].z"
[effects.stream]
over = "site(i) of p"
energy = "-omega*p[i].z"
[starts.any.w]
random = 0
[starts.any.p]
random = 0
[starts.ring.w]
theta = [1.0, 1.4, 2.0]
phi = [0.0, 2.1, 4.0]
[starts.ring.p]
theta = "0.5 + 0.02*i"
phi = "2*pi*i/m"
[runs.demo]
start = "ring"
h = 0.1
steps = 1000
"""
FIXED = np.array([0.6, 0.64, 0.48])
METHODS = ("spherical-midpoint", "classical-midpoint", "spherical-midpoint-4")


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def beside(w, d, dice):
    """A point at the distance d of w."""
    return unit(np.cos(d) * w + np.sin(d) * unit(np.cross(w, dice.standard_normal(3))))


def step_of(angle, d):
    return angle * 2 * np.pi * d * d


@pytest.mark.quick
@pytest.mark.parametrize("method", METHODS)
def test_a_site_next_to_a_fixed_vortex(method):
    dice, one = np.random.default_rng(1), smidgen.build(smidgen.load_text(VORTEX), method=method)
    for d in (3e-2, 1e-3, 1e-5):
        for angle in (0.02, 0.2, 0.8):
            for _ in range(4):
                assert one.start(beside(FIXED, d, dice)[None], h=step_of(angle, d)).steps(20).count == 20


@pytest.mark.quick
def test_tracers_next_to_a_vortex():
    """Every step is taken, and its residual is the round-off of the field."""
    m, dice, spec = 24, np.random.default_rng(2), smidgen.load_text(ROTATING)
    top, witness = smidgen.build(spec, parameters={"m": m}), Witness(spec, {"m": m})
    for d in (3e-2, 1e-2, 1e-3, 1e-5):
        for angle in (0.02, 0.2, 0.8):
            vortices = unit(dice.standard_normal((3, 3)))
            w = np.concatenate([vortices, [beside(vortices[0], d, dice) for _ in range(m)]])
            top.start(w.copy(), h=step_of(angle, d)).step()
            left = witness.residuals(np.array([w, top.w]), 0.0, top.h, "spherical-midpoint")[0]
            assert np.abs(left).max() <= 4 * EPS * (1 + 2 * angle / d)
            assert top.steps(20).count == 21


@pytest.mark.parametrize("solver", ["auto", "newton"])
def test_pairs_of_vortices(solver):
    top = smidgen.build(smidgen.load("point_vortices"), solver=solver)
    for seed in range(60):
        dice, d, angle = np.random.default_rng(seed), (1e-4, 1e-5)[seed % 2], (0.5, 0.8)[seed // 2 % 2]
        w = unit(dice.standard_normal((4, 3)))
        w[1] = beside(w[0], d, dice)
        assert top.start(w, h=step_of(angle, d) / 4).steps(50).count == 50


@pytest.mark.quick
def test_a_field_without_digits_is_refused():
    """At d = 1e-7 d^2 is known to 2 %: hardly a step is taken, by chance; 3 digits are enough."""
    taken, dice, one = {}, np.random.default_rng(3), smidgen.build(smidgen.load_text(VORTEX))
    for d in (3e-6, 1e-7):
        for _ in range(40):
            try:
                one.start(beside(FIXED, d, dice)[None], h=step_of(0.9, d)).step()
            except RunError as error:
                assert "no convergence" in str(error)
            else:
                taken[d] = taken.get(d, 0) + 1
    assert taken[3e-6] == 40 and taken.get(1e-7, 0) < 10


@pytest.mark.quick
@pytest.mark.parametrize("size", [0.1, 1e-10])
def test_a_jump_is_no_round_off(size):
    """Where the field jumps at the midpoint there may be no step, and none is made up."""
    spec, refused = smidgen.load_text(JUMP.replace("SIZE", str(size))), 0
    one, witness = smidgen.build(spec), Witness(spec)
    for z in edges(one):
        for ulps in (0, *(sign * 4**k for k in range(24) for sign in (-1, 1))):
            w = at_height(z + ulps * EPS)
            try:
                one.start(w.copy(), h=0.5).step()
            except RunError:
                refused += 1
                continue
            assert np.abs(witness.residuals(np.array([w, one.w]), 0.0, 0.5, "spherical-midpoint")).max() <= 16 * EPS
    assert refused > 10


def at_height(z):
    return np.array([[0.6 * np.sqrt(1 - z * z), 0.8 * np.sqrt(1 - z * z), z]])


def side(one, z):
    """Above or below z = 0 is the midpoint of the step; 0 where there is none."""
    try:
        return np.sign(z + one.start(at_height(z), h=0.5).step().w[0, 2])
    except RunError:
        return 0


def halved(low, high, is_low):
    """The last of both, where is_low changes."""
    while high - low > 2 * EPS:
        middle = (low + high) / 2
        low, high = (middle, high) if is_low(middle) else (low, middle)
    return low, high


def edges(one):
    """From the lowest to the highest z from which there is no step: both."""
    low, middle, high = 0.1, 0.25, 0.4
    while found := side(one, middle):
        assert high - low > 4 * EPS
        low, high = (middle, high) if found < 0 else (low, middle)
        middle = (low + high) / 2
    return halved(low, middle, lambda z: side(one, z) < 0)[1], halved(middle, high, lambda z: side(one, z) == 0)[0]


def test_no_tracer_of_a_hundred_ends_a_run():
    """One came near a vortex after 1905 steps."""
    top = smidgen.build(smidgen.load_text(ROTATING), parameters={"m": 100})
    assert top.start("ring", h=0.1).steps(4000).count == 4000


@pytest.mark.parametrize("start, seed, m", [("ring", None, 100), *(("any", seed, 20) for seed in range(4))])
def test_sums_of_tracers_near_vortices(start, seed, m):
    """The round-off of their field, which is of one sign from step to step, is not taken for a lost compensation; that is seen."""
    settings = settle(spec := smidgen.load_text(ROTATING), "demo", start=start, seed=seed, parameters={"m": m})
    for features, least, most in (((), 0.03, 0.1), (("plain-sums",), 0.4, np.inf)):
        (row,) = sums(Case(spec, settings, 4), emitted(spec, settings, features))
        assert least < row.measured < most
