"""What the spherical midpoint promises, tried on generated code: order, symmetry, invariants."""
import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import texts
from support.exact import rotation
from support.systems import CLASSICAL, QUICK, SPHERICAL, VESELOV, begin, load, model, on_leaf, tiers

import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.run.step.evaluated import kappas
from smidgen.check.witness import Witness

EPSILON = np.finfo(float).eps
seeds = st.integers(0, 2**32 - 1)
some = settings(max_examples=20, deadline=None, derandomize=True)


def sphere_points(seed, count):
    return on_leaf(np.random.default_rng(seed).standard_normal((count, 3)))


@functools.lru_cache
def model_of(name, method=SPHERICAL, **values):
    """The compiled system of a shipped spec, made once for all examples."""
    return model(begin(name, **values), method)


def largest(a):
    return float(np.abs(a).max())


# -- order --------------------------------------------------------------------------------------

def errors(case, method, start, end, counts, advance=None):
    """Distance from the witness's flow at `end`, with these numbers of steps."""
    exact = Witness(case.spec, case.values).flow(start, 0.0, [end])[0]
    advance = advance or (lambda m, h, n: m.start(start.copy(), h=h).steps(n).w)
    one = model(case, method)
    return [largest(advance(one, end / n, n) - exact) for n in counts]


def orders(found):
    return np.log2(np.array(found[:-1]) / np.array(found[1:]))


ORDERS = [("irreversible_rigid_body", 4.0), ("point_vortices", 6.0), ("nambu_a38", 1.0), ("product", 2.0)]


@pytest.mark.quick
@pytest.mark.parametrize("name, end, method", [("forced_rigid_body", 5.0, SPHERICAL), ("forced_rigid_body", 5.0, CLASSICAL), ("nambu_a34", 1.0, SPHERICAL), *(
    pytest.param(name, end, method, marks=pytest.mark.long) for name, end in ORDERS for method in (SPHERICAL, CLASSICAL))])
def test_order_two(name, end, method):
    case = begin(name)
    found = errors(case, method, case.w, end, (50, 100, 200))
    assert orders(found) == pytest.approx([2, 2], abs=0.05)


def frozen(start):
    """The mutant that takes time at the beginning of the step instead of its middle."""
    def advance(one, h, count):
        w = start.copy()
        for k in range(count):
            w = one.start(w, t0=k * h - h / 2, h=h).step().w.copy()
        return w
    return advance


@pytest.mark.quick
@pytest.mark.parametrize("name, values", [("forced_rigid_body", {"eps": 1.0}), pytest.param("test_particles", {"n": 5}, marks=pytest.mark.long)])
def test_time_is_taken_in_the_middle_of_the_step(name, values):
    """Order 2 in a field that depends on time; with time frozen at the step's beginning, order 1."""
    case = begin(name, **values)
    moving = errors(case, SPHERICAL, case.w, 3.0, (50, 100, 200))
    stopped = errors(case, SPHERICAL, case.w, 3.0, (50, 100, 200), frozen(case.w))
    assert orders(moving) == pytest.approx([2, 2], abs=0.05)
    assert orders(stopped) == pytest.approx([1, 1], abs=0.1)


# -- symmetry -----------------------------------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("name, method", [("free_rigid_body", VESELOV), *(
    pytest.param(name, method, marks=() if name in QUICK or (name, method) == ("point_vortices", SPHERICAL) else pytest.mark.long)
    for name in ("free_rigid_body", "forced_rigid_body", "two_bodies", "point_vortices", "product", "nambu_a34", "nambu_a39")
    for method in (SPHERICAL, CLASSICAL))])
def test_a_step_back_undoes_a_step(name, method):
    """phi_{-h} phi_h = 1: the step equation is the same with w and W exchanged."""
    case = begin(name, **({"eps": 0.7} if name == "forced_rigid_body" else {}))
    one, w, t, h = model(case, method), case.w, 0.3, 2 * case.h
    there = one.start(w.copy(), t0=t, h=h).steps(5).w.copy()
    back = one.start(there.copy(), t0=t + 5 * h, h=-h).steps(5).w
    assert largest(there - w) > 1e-3
    assert largest(back - w) < 40 * EPSILON * max(1, largest(w))


@some
@given(seed=seeds, axis=seeds, angle=st.floats(0.1, 3), h=st.floats(0.01, 0.3))
def test_a_turned_start_gives_the_turned_end(seed, axis, angle, h):
    """Isotropic systems: phi_h R = R phi_h for every rotation R, to round-off."""
    turn = np.asarray(rotation(sphere_points(axis, 1)[0], angle), float).T
    for name, w in (("heisenberg_chain", sphere_points(seed, 6)), ("point_vortices", FOUR)):
        one = model_of(name, n=len(w))
        straight = one.start(w.copy(), h=h).steps(10).w.copy()
        turned = one.start(on_leaf(w @ turn), h=h).steps(10).w
        assert largest(turned - straight @ turn) < 200 * EPSILON


FOUR = on_leaf(np.array([[1, 0.1, 0.3], [-0.2, 1, 0.5], [-0.7, -0.6, 0.2], [0.1, 0.2, -1]]))


@pytest.mark.quick
@some
@given(seed=seeds)
def test_the_free_body_keeps_its_symmetric_planes(seed):
    """H even in w_x: the reflection diag(-1, 1, 1) with time reversed maps steps to steps."""
    one, w = model_of("free_rigid_body"), sphere_points(seed, 1)
    mirror = np.array([-1.0, 1, 1])
    after = one.start(w.copy(), h=0.4).steps(7).w.copy()
    assert largest(one.start(w * mirror, h=-0.4).steps(7).w - after * mirror) == 0


# -- invariants ---------------------------------------------------------------------------------

@some
@given(seed=seeds, h=st.floats(-0.3, 0.3).filter(lambda h: abs(h) > 0.01))
def test_momentum_of_a_chain(seed, h):
    """sum w, an integral of the isotropic chain, is kept to round-off; so is every norm."""
    w = sphere_points(seed, 12)
    one = model_of("heisenberg_chain", n=12).start(w.copy(), h=h).steps(200)
    assert largest(one.w.sum(axis=0) - w.sum(axis=0)) < 30 * EPSILON
    assert largest(np.sum(one.w**2, axis=1) - np.sum(w**2, axis=1)) < 30 * EPSILON


@pytest.mark.parametrize("strengths", [(1, 1, 1, 1), (1, -0.6, 2, 0.3), (1e-6, 1, -1e3, 1e6)])
def test_momentum_of_vortices(strengths):
    """sum kappa w, relative to the largest strength, for strengths of both signs and many sizes."""
    case = begin("point_vortices", gamma=list(map(float, strengths)))
    kappa = kappas(case.spec, case.values)[:, None]
    one = model(case).start(FOUR.copy(), h=0.01 / max(map(abs, strengths))).steps(1000)
    assert largest(one.w - FOUR) > 1e-3
    assert largest(np.sum(kappa * (one.w - FOUR), axis=0)) < 30 * EPSILON * np.abs(kappa).max()


@pytest.mark.quick
@some
@given(seed=seeds, moments=st.tuples(*[st.floats(0.5, 5)] * 3), h=st.floats(0.01, 1))
def test_the_energy_of_a_free_body(seed, moments, h):
    """A homogeneous quadratic integral of one spin is kept at any step, by all three methods."""
    w = sphere_points(seed, 1)
    for method in (SPHERICAL, CLASSICAL, VESELOV):
        h = min(h, 0.4) if method == VESELOV else h     # |h I^-1 w| <= 1 is its own limit
        one = model_of("free_rigid_body", method, **{f"I{k + 1}": m for k, m in enumerate(moments)})
        start = one.start(w.copy(), h=h).energy()
        assert abs(one.steps(300).energy() - start) < 60 * EPSILON


def test_linear_and_quadratic_integrals_of_a_lone_spin():
    """In a field along e: w.e stays. On Lagrange's leaf: C and H, both quadratic, stay."""
    axis, one = np.array([0.36, 0.48, 0.8]), model(begin(texts.read(texts.FIELD)))
    start = one.start("first", h=0.9).w[0] @ axis
    assert abs(one.steps(1000).w[0] @ axis - start) < 20 * EPSILON
    case = begin("lagrange")
    one = model(case).start(case.w.copy(), h=case.h)
    energy, casimir = one.energy(), one.casimirs()
    one.steps(60)
    size = largest(one.w)**2
    assert abs(one.energy() - energy) < 20 * EPSILON * size
    assert largest(one.casimirs() - casimir) < 20 * EPSILON * size


@pytest.mark.parametrize("name", tiers(["two_bodies", "product", "nambu_a31", "nambu_a34", "nambu_a36",
                                        "nambu_a38", "nambu_a39", "forced_rigid_body"], ()))
def test_casimirs(name):
    """|w| of spheres and of R^3, C of the Nambu factors: over 2000 steps, to round-off."""
    case = begin(name)
    one = model(case).start(case.w.copy(), h=case.h)
    start = one.casimirs()
    one.steps(2000)
    assert largest(one.casimirs() - start) < 60 * EPSILON * max(1, largest(one.w)**2)


# -- runs ---------------------------------------------------------------------------------------

@pytest.mark.parametrize("name", ["forced_rigid_body", "point_vortices", "two_bodies"])
def test_restart_from_a_saved_state(name):
    """A state and a time are all a run needs: on from there it is the same run to round-off."""
    case = begin(name)
    one = model(case)
    whole = one.start(case.w.copy(), t0=0.2, h=case.h).steps(60).w.copy()
    half, t = one.start(case.w.copy(), t0=0.2, h=case.h).steps(30).w.copy(), one.t
    assert t == 0.2 + 30 * case.h
    rest = one.start(half, t0=t, h=case.h).steps(30).w
    assert largest(rest - whole) < 200 * EPSILON * max(1, largest(whole))


@pytest.mark.parametrize("name", ["forced_rigid_body", "point_vortices", "product"])
def test_the_same_start_gives_the_same_bits(name):
    """One long run, many short calls, a second model: no hidden state."""
    case = begin(name)
    one, other = model(case), model(case)
    whole = one.start(case.w.copy(), h=case.h).steps(50).w.copy()
    other.start(case.w.copy(), h=case.h)
    for count in (1, 7, 0, 42):
        other.steps(count)
    assert np.array_equal(other.w, whole)
    assert np.array_equal(one.start(case.w.copy(), h=case.h).steps(50).w, whole)


WITHOUT = """
[model]
name = "product"
title = "A sphere coupled to a Nambu factor"
[space]
w = { sphere = 1 }
v = { nambu = 1, C = "v.x^2 + v.y^2" }
[effects.spin]
energy = "(w.x^2 + w.y^2/2 + w.z^2/4)/2"
[effects.pendulum]
energy = "v.z^2/2 + v.x"
"""


def text(spec):
    """Generated C, but for the line with the digest of the spec."""
    return {name: [line for line in lines.splitlines() if "Generated by smidgen" not in line]
            for name, lines in generate(spec).items()}


@pytest.mark.quick
def test_an_effect_not_asked_for_leaves_nothing():
    """Byte for byte the text of a spec that never had it, its parameter gone too."""
    assert text(select(load("product"), ("spin", "pendulum"))) == text(smidgen.load_text(WITHOUT))


@pytest.mark.quick
def test_the_order_of_effects_changes_nothing():
    names = [e.name for e in load("product").effects]
    assert text(select(load("product"), names[::-1])) == text(select(load("product"), names))


def test_effects_add_up():
    """The field of all effects is the sum of the fields of each alone."""
    case = begin("product")
    alone = [smidgen.build(case.spec, effects=(e.name,)).start(case.w, h=0.1) for e in case.spec.effects]
    whole = model(case).start(case.w, h=0.1)
    assert largest(whole.field() - sum(one.field() for one in alone)) < 8 * EPSILON
    assert abs(whole.energy() - sum(one.energy() for one in alone)) < 8 * EPSILON
    assert whole.values()[1:4] == pytest.approx([one.energy() for one in alone], abs=4 * EPSILON)
