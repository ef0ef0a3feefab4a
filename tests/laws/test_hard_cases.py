"""Hard cases: what a step does at the edges of what it can do."""
import os
import subprocess
import sys
import numpy as np
import pytest
from support import texts
from support.systems import CLASSICAL, SPHERICAL, begin, load, model

import smidgen
from smidgen.errors import RunError
from smidgen.run.step.status import STATUS
from smidgen.check.witness import Witness

pytestmark = pytest.mark.quick
EPSILON = np.finfo(float).eps
NO_SOLUTION = 2


def largest(a):
    return float(np.abs(a).max())


# -- one spin in a field --------------------------------------------------------------------------

def spin(angle):
    """A spin at an angle from the field (0, 0, B), and the compiled step."""
    spec = smidgen.load_text(texts.FIELD.replace("vec(0.36, 0.48, 0.8)", "vec(0, 0, 1)"))
    return smidgen.build(spec), np.array([[np.sin(angle), 0, np.cos(angle)]])


def turn(w, after):
    """The angle about z from w to after, in (-pi, pi]."""
    return np.angle((after[0, 0] + 1j * after[0, 1]) / (w[0, 0] + 1j * w[0, 1]))


@pytest.mark.parametrize("rate", [1e-6, 0.1, 1.0, 1.9, 2.5, 30.0, 1e4])
@pytest.mark.parametrize("angle", [0.1, 0.7, 1.5])
def test_the_angle_of_a_spin_in_a_field(angle, rate):
    """sin^2(phi/2) = ((4+a) - sqrt((4+a)^2 - 16 r^2 a))/(8 r^2), a = (lambda h)^2, r = sin(angle)."""
    one, w = spin(angle)
    phi = turn(w, one.start(w.copy(), h=rate / 1.3).step().w)
    a, r2 = np.longdouble(one.h * 1.3)**2, np.sin(np.longdouble(angle))**2
    square = 2 * a / ((4 + a) + np.sqrt((4 + a)**2 - 16 * r2 * a))        # the same, no cancellation
    assert float(np.sin(abs(phi) / 2)**2 / square) == pytest.approx(1, rel=1e-12)
    assert one.w[0, 2] == pytest.approx(w[0, 2], abs=2 * EPSILON)
    assert phi < 0          # clockwise: w' = w x B


@pytest.mark.parametrize("rate", [0.1, 1.0, 1.99])
def test_perpendicular_to_the_field_up_to_two(rate):
    """cos(phi) = 1 - (lambda h)^2/2 there."""
    one, w = spin(np.pi / 2)
    w = np.array([[1.0, 0, 0]])
    phi = turn(w, one.start(w.copy(), h=rate / 1.3).step().w)
    assert 2 * np.sin(phi / 2)**2 == pytest.approx(rate**2 / 2, rel=1e-13)


def test_perpendicular_to_the_field_beyond_two():
    """|W - w| = lambda h > 2 is on no sphere: a typed error, the state as it was."""
    one, w = spin(np.pi / 2)[0], np.array([[1.0, 0, 0]])
    one.start(w.copy(), h=2.01 / 1.3)
    with pytest.raises(RunError) as failed:
        one.steps(3)
    assert failed.value.status == NO_SOLUTION and one.count == 0
    assert np.array_equal(one.w, w) and one.t == 0


# -- the unstable axis ----------------------------------------------------------------------------

def test_on_the_unstable_axis_nothing_moves():
    one = model(begin("free_rigid_body"))
    for w in ([0, 1, 0], [0, -1, 0], [1, 0, 0], [0, 0, 1]):
        assert np.array_equal(one.start(np.array([w], float), h=0.3).steps(1000).w, [w])


@pytest.mark.parametrize("off", [1e-6, 1e-12, 1e-100, 1e-300])
@pytest.mark.parametrize("h", [0.1, 1.0])
def test_off_the_unstable_axis_it_escapes_at_the_rate_of_the_cayley_map(off, h):
    """Every step multiplies what grows by (1 + h s/2)/(1 - h s/2), to six digits of its logarithm.

    I = (1, 2, 4), near the second axis: x' = -z/4, z' = -x/2, s = 1/sqrt(8), along (1, -sqrt(2)).
    """
    one, s = model(begin("free_rigid_body")), np.sqrt(0.125)
    e = np.array([1, 0, -np.sqrt(2)]) / np.sqrt(3)
    assert np.allclose([-e[2] / 4, 0, -e[0] / 2], s * e, rtol=1e-14)
    w = np.array([[0, 1.0, 0]]) + off * e
    rate = np.log((1 + h * s / 2) / (1 - h * s / 2))
    count = int(np.log(1e-4 / off) / rate)
    end = one.start(w.copy(), h=h).steps(count).w
    assert np.log(end[0, 0] / w[0, 0]) / count == pytest.approx(rate, rel=1e-6)
    assert np.log(end[0, 2] / w[0, 2]) / count == pytest.approx(rate, rel=1e-6)
    assert min(abs(one.step().w[0, 1]) for _ in range(int(15 / rate))) < 0.5      # and far away


# -- strengths over many decades ------------------------------------------------------------------

PAIR = """
[model]
name = "unequal_pair"
[space]
w = { sphere = 2, kappa = "k[i]" }
[parameters]
k = { default = [1.0, 1.0], size = 2 }
[effects.exchange]
over = "pair(i, j) of w"
energy = "k[i]*k[j]*dot(w[i], w[j])"
[starts.any]
random = 1
"""


@pytest.mark.parametrize("kappa", [(1.0, 1e-12), (1e-12, -1.0), (1e6, -1e-6), (1e12, 1e-12)])
def test_strengths_over_24_decades(kappa):
    """k1 dW1 + k2 dW2 = 0: the sum alone would hide a wrong light particle."""
    one = smidgen.build(smidgen.load_text(PAIR), parameters={"k": list(kappa)})
    light, heavy = np.argsort(np.abs(kappa))
    w = np.array([[0.6, 0, 0.8], [0, -0.28, 0.96]])
    h = 0.1 / max(map(abs, kappa))
    after = one.start(w.copy(), h=h).step().w
    moved = after - w
    assert largest(moved[light]) > 1e-2
    # what a heavy particle can move by is bounded below by the last bit of its place
    assert largest(kappa[0] * moved[0] + kappa[1] * moved[1]) <= max(
        1e-14 * largest(kappa[light] * moved[light]), EPSILON * abs(kappa[heavy]))
    exact = Witness(smidgen.load_text(PAIR), {"k": list(kappa)}).step(w, 0.0, h)
    assert largest(after - exact) < 4 * EPSILON


def test_no_strength_is_refused():
    with pytest.raises(smidgen.SmidgenError, match="kappa|strength|0"):
        smidgen.build(smidgen.load_text(PAIR), parameters={"k": [1.0, 0.0]}).start("any", h=0.1)


# -- collapse ---------------------------------------------------------------------------------------

@pytest.mark.parametrize("h", [0.002, 0.001])
def test_a_collapse_ends_in_a_typed_error(h):
    """On the way in the steps follow the flow; at the end no step exists, and the state is kept."""
    strengths, w = collapse_start()
    spec, values = load("point_vortices"), {"n": 3, "gamma": strengths}
    one = smidgen.build(spec, parameters=values).start(w.copy(), h=h)
    momentum = np.array(strengths) @ w
    gap = smallest(w)
    with pytest.raises(RunError) as failed:
        one.steps(int(100 / h))
    assert failed.value.status in STATUS and one.count > 10
    assert smallest(one.w) < 0.2 * gap
    assert largest(np.array(strengths) @ one.w - momentum) < 100 * EPSILON
    assert np.all(np.isfinite(one.w))
    half = one.count // 2
    flow = Witness(spec, values).flow(w, 0.0, [half * h])[0]
    assert largest(one.start(w.copy(), h=h).steps(half).w - flow) < h**2


def smallest(w):
    return min(np.linalg.norm(w[i] - w[j]) for i in range(3) for j in range(i))


def collapse_start():
    """Strengths (2, 2, -1), whose products of two sum to 0, and places with
    sum k_i k_j |w_i - w_j|^2 = 0, an integral: so all distances can vanish together; they shrink."""
    strengths = [2.0, 2.0, -1.0]
    a = 0.25
    w1 = np.array([np.sin(a), 0, np.cos(a)])
    w2 = np.array([-np.sin(a), 0, np.cos(a)])
    # 4|w1-w2|^2 = 2(|w1-w3|^2 + |w2-w3|^2), so that w3.(w1+w2) = 2 - |w1-w2|^2
    height = (2 - np.sum((w1 - w2)**2)) / (2 * np.cos(a))
    for sign in (1, -1):
        x = sign * 0.2
        w3 = np.array([x, np.sqrt(1 - height**2 - x**2), height])
        w = np.array([w1, w2, w3])
        rate = Witness(load("point_vortices"), {"n": 3, "gamma": strengths}).vector_field(w)
        if (w1 - w2) @ (rate[0] - rate[1]) < 0:
            return strengths, w
    raise AssertionError("neither orientation collapses")


# -- Nambu leaves -----------------------------------------------------------------------------------

def test_the_leaf_zero_is_refused():
    one = model(begin("nambu_a34"))
    with pytest.raises(RunError, match="off manifold"):
        one.start(np.array([[0.0, 1.0, 0.3]]), h=0.1)


def test_a_blow_up_ends_in_a_typed_error():
    """Lagrange's orbits reach infinity in finite time: an error before any Inf."""
    one = model(begin("lagrange")).start("inward", h=0.02)
    with pytest.raises(RunError) as failed:
        one.steps(100_000)
    assert failed.value.status in STATUS
    assert np.all(np.isfinite(one.w)) and np.all(np.isfinite(one.casimirs()))


# -- small things -----------------------------------------------------------------------------------

@pytest.mark.parametrize("method", [SPHERICAL, CLASSICAL])
def test_zero_components_and_zero_fields(method):
    """Spins on the axes, all parallel, in no field: nothing moves, nothing is NaN."""
    one = model(begin("heisenberg_chain", n=8), method)
    for axis in np.eye(3):
        w = np.tile(axis, (8, 1))
        assert np.array_equal(one.start(w.copy(), h=0.5).steps(20).w, w)
        w = np.where(np.arange(8)[:, None] % 2, axis, -axis)
        assert largest(one.start(w.copy(), h=0.3).steps(20).w - w) < 1e-13
    weak = model(begin("forced_rigid_body", eps=0.0), method)
    assert np.array_equal(weak.start(np.array([[0.0, 0, -1]]), h=0.3).steps(20).w, [[0, 0, -1]])


@pytest.mark.quick
def test_make_hard_finds_all_that_it_imports(root):
    """With no other path than the one it gets from the Makefile."""
    subprocess.run([sys.executable, "-c", "import hard.table"], cwd=root, env={**os.environ, "PYTHONPATH": "tests"}, check=True)
