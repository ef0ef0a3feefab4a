"""Step advice: of a start alone never above the limit that bisection finds, and at least half of it; of a run an h with
which it completes; with its reason."""
import json
import math

import numpy as np
import pytest
from support.advice_specs import KINDS, text

import smidgen
from smidgen.analyse.advice import advice_for, advise
from smidgen.analyse.advice.equation import StepEquation
from smidgen.errors import RunError, UsageError
from smidgen.read import load_text
from smidgen.check.witness import Witness

GRID = 40           # first steps between a thousandth of the cap and the cap
HALVINGS = 16

PAIR = '''[model]
name = "pair"
[space]
w = { sphere = 2 }
[parameters]
a = 0.3
[effects.interaction]
energy = "-log(2 - 2*dot(w[0], w[1]))/(4*pi)"
[starts.first]
theta = "a"
phi = "pi*i"
'''
FIELD = '''[model]
name = "field"
[space]
w = { sphere = 1 }
[parameters]
B = 2.0
[effects.field]
energy = "B*w.z"
[starts.across]
vectors = [[1, 0, 0]]
[starts.tilted]
theta = 1.0
phi = 0.0
'''


def succeeds(model, w, h):
    """Does the first step of size h succeed?"""
    try:
        model.start(w.copy(), h=h).step()
    except RunError:
        return False
    return True


def bisected(model, w, cap):
    """The largest h up to the cap such that every smaller h tried gives a first step."""
    good = 0.0
    for h in np.geomspace(cap / 1000, cap, GRID):
        if not succeeds(model, w, h):
            break
        good = h
    else:
        return cap
    for _ in range(HALVINGS):
        middle = (good + h) / 2
        good, h = (middle, h) if succeeds(model, w, middle) else (good, middle)
    return good


def ratio(seed):
    """(advice / limit, Advice) of a random spec; where no step fails up to the cap, that is the limit."""
    spec = load_text(text(seed))
    advice, model = advise(spec, time=0), smidgen.build(spec)
    w = model.start("first", h=1.0).w.copy()
    return advice.h / bisected(model, w, advice.cap), advice


def test_never_above_the_limit_and_at_least_half_of_it():
    found = [ratio(seed)[0] for seed in range(3)]
    assert max(found) <= 1 and sum(r >= 0.5 for r in found) >= 2, found


@pytest.mark.long
def test_never_above_the_limit_and_at_least_half_of_it_of_every_kind():
    found = [ratio(seed)[0] for seed in range(len(KINDS))]
    assert max(found) <= 1 and sum(r >= 0.5 for r in found) >= 9, found


@pytest.mark.long
def test_never_above_the_limit_on_a_hundred_random_specs():
    found = [ratio(seed) for seed in range(100)]
    ratios = np.array([r for r, _ in found])
    assert np.max(ratios) <= 1, ratios
    assert np.mean(ratios >= 0.5) >= 0.9, ratios
    assert sum(a.kind != "open" for _, a in found) >= 40        # not all are limits of the cap alone


# Analytic limits

@pytest.mark.parametrize("a", [0.05, 0.3, 1.0])
def test_the_fold_of_a_vortex_pair(a):
    """Equal vortices at half-angle a: sin(phi) = h kappa/(4 pi sin a tan a), a fold at phi = pi/2."""
    advice, fold = advise(load_text(PAIR), parameters={"a": a}), 4 * math.pi * math.sin(a) * math.tan(a)
    assert advice.kind in ("fold", "centre") and abs(advice.limit / fold - 1) < 3e-3
    assert 0.8 * fold < advice.h < fold
    if advice.kind == "fold":
        assert advice.sites == (0, 1)
    assert advice.effect == "interaction"


def test_a_spin_across_its_field():
    """A perpendicular spin turns by 2 asin(h B/2): its midpoint is at the centre at h B = 2."""
    spec = load_text(FIELD)
    advice = advise(spec, start="across")
    assert advice.kind == "centre" and abs(advice.limit - 1) < 3e-3 and advice.sites == (0,)
    assert "reaches the centre" in advice.words()[0]
    tilted = advise(spec, start="tilted")
    assert tilted.kind == "open" and tilted.limit is None and abs(tilted.cap - math.pi) < 1e-9
    assert abs(tilted.rate - 2) < 1e-6 and "accuracy is the limit" in tilted.words()[0]


def test_the_sites_of_the_closest_pair_are_named():
    text_ = PAIR.replace("sphere = 2", "sphere = 4").replace(
        'energy = "-log(2 - 2*dot(w[0], w[1]))/(4*pi)"',
        'over = "pair(i, j) of w"\nenergy = "-log(2 - 2*dot(w[i], w[j]))/(4*pi)"').replace(
        'theta = "a"\nphi = "pi*i"', "theta = [0.3, 2.0, 1.2, 2.08]\nphi = [0.0, 1.0, 3.0, 1.0]")
    advice = advise(load_text(text_))
    assert advice.kind == "fold" and advice.sites == (1, 3) and "caused by w[1] and w[3]" in advice.reason


# The parts

def test_the_equation_is_the_witness_s():
    spec = load_text(text(5))
    model = smidgen.build(spec).start("first", h=0.1)
    w, h = model.w.copy(), 0.1
    equation, after = StepEquation(model, w, 0.0), Witness(spec).step(w, 0.0, h)
    assert np.max(np.abs(equation.residual(after - w, h))) < 1e-13
    j, d = equation.jacobian(after - w, h), 1e-6 * np.ones_like(w)
    change = (equation.residual(after - w + d, h) - equation.residual(after - w - d, h)) / 2
    assert np.max(np.abs(j @ d.ravel() - change)) < 1e-13


MOVED = """[model]
name = "moved"
orientation = -1
[space]
w = {{ {space} }}
[effects.exchange]
over = "bond(i, j) of chain(4, open)"
energy = "-dot(w[i], w[j]) - 0.3*w[i].x*w[j].z^2"
[effects.bath]
over = "site(i) of w"
damping = "0.2 + 0.1*i"
form = "{form}"
[effects.current]
over = "bond(i, j) of chain(4, open)"
torque = "cos(t)*cross(w[j], cross(w[j], w[i]) + vec(0, 3, 0.4))"
on = "w[j]"
[effects.held]
over = "site(i) of w"
{held} = "i == 2"
[starts.any]
random = 2
"""


@pytest.mark.parametrize("space, form, held", [('sphere = 4, kappa = "1 - 3*mod(i, 2)", radius = "1 + i/4"', "gilbert", "pinned"),
                                               ("sphere = 4, kappa = -2, radius = 1.5", "ll", "absent"), ("r3 = 4, kappa = 0.7", "ll", "pinned")], ids=["gilbert", "ll", "r3"])
def test_dampings_torques_and_sites_that_do_not_move_are_in_the_equation(space, form, held):
    spec = load_text(MOVED.format(space=space, form=form, held=held))
    model, one = smidgen.build(spec).start("any", h=0.1), Witness(spec)
    w, h = model.w.copy(), 0.1
    equation, after = StepEquation(model, w, 0.0), one.step(w, 0.0, h)
    assert np.max(np.abs(equation.rate(w, 0.0) - one.vector_field(w, 0.0))) < 1e-13
    assert np.max(np.abs(equation.residual(after - w, h))) < 1e-13
    assert (after[2] == w[2]).all() and np.max(np.abs(after - w)) > 0.1


def test_a_step_resolves_torques_and_not_the_fields_of_sites_that_do_not_move():
    """A torque of rate 30 turns a spin that has no field; a spin of rate 1 beside a pinned one in a field of 100."""
    text_ = FIELD[:FIELD.index("[starts")].replace("sphere = 1", "sphere = 2").replace('energy = "B*w.z"', 'over = "pair(i, j) of w"\nenergy = "-dot(w[i], w[j])"') + '''[effects.strong]
over = "site(i) of w"
energy = "-if(i == 0, 100, 0)*w[i].x"
[effects.held]
over = "site(i) of w"
pinned = "i == 0"
[effects.push]
over = "site(i) of w"
torque = "cos(3*t)*cross(w[i], vec(0, 0, 30))"
'''
    spec, w = load_text(text_), np.array([[0.6, 0, 0.8], [0, 0.6, 0.8]])
    assert advise(spec, start=w, h=0.1, time=5, effects=("field", "strong", "held")).rate == pytest.approx(1, rel=1e-6)
    pushed = advise(spec, start=w, h=0.1, time=5, effects=("push",))
    assert pushed.rate == pytest.approx(30, rel=1e-3) and pushed.change == pytest.approx(3, rel=0.2) and "nothing moves" not in " ".join(pushed.words())


def test_backward_is_the_reversed_problem():
    spec = load_text(PAIR)
    forward, backward = advise(spec, h=0.1), advise(spec, h=-0.1)
    assert backward.h < 0 and abs(backward.h + forward.h) < 1e-6 * forward.h
    assert forward.run_h == 0.1 and "does not exceed the largest safe step" in forward.words()[-1]
    assert "exceeds the largest safe step" in advise(spec, h=10.0).words()[-1]
    forward, backward = (" ".join(advise("forced_rigid_body", h=h).words()) for h in (0.1, -0.1))
    for said in (" ".join(advise(spec, h=-0.1).words()), backward):
        assert said.count(" h = ") == said.count(" h = -") > 0
    assert forward.count(" h = ") == backward.count(" h = ") and " h = -" not in forward


@pytest.mark.parametrize("bisect", [False, pytest.param(True, marks=pytest.mark.long)])
def test_large_systems_are_tried(bisect):
    text_ = PAIR.replace("sphere = 2", "sphere = 60").replace("w[0], w[1]", "w[i], w[j]").replace(
        "energy", 'over = "bond(i, j) of chain(60, open)"\nenergy').replace(
        'theta = "a"\nphi = "pi*i"', 'theta = "0.4 + 0.03*i"\nphi = "2.4*i"')
    spec = load_text(text_)
    advice, model = advise(spec, time=0), smidgen.build(spec)
    w = model.start("first", h=1.0).w.copy()
    assert advice.kind == "trial" and succeeds(model, w, advice.h) and not succeeds(model, w, 2 * advice.h)
    assert not bisect or 0.5 <= advice.h / bisected(model, w, advice.cap) <= 1
    assert "a step of h = " in advice.reason and " fails: " in advice.reason


def test_nothing_moves():
    advice = advise(load_text(FIELD + "[starts.up]\nvectors = [[0, 0, 1]]\n"), start="up", parameters={"B": 0.0})
    assert advice.rate == 0 and "nothing moves" in advice.words()[1]


def test_a_start_without_a_field_is_refused_in_words():
    with pytest.raises(RunError, match="not finite"):
        advise(load_text(PAIR), parameters={"a": 0.0})
    with pytest.raises(UsageError):
        advise(load_text(PAIR), start="none")


def test_advice_on_the_way():
    """From a state of a run, not only from a start."""
    spec = load_text(PAIR)
    model = smidgen.build(spec).start(h=0.1)
    w = model.steps(20).w.copy()
    there, here = advice_for(model, w, 2.0, 0.1), advise(spec)
    assert abs(there.h / here.h - 1) < 0.02         # the pair turns rigidly


@pytest.mark.quick
def test_command(command, tmp_path):
    (tmp_path / "pair.toml").write_text(PAIR)
    out = command("advise", "pair.toml", "--set", "a=0.3")
    assert out.returncode == 0 and "fold" in out.stdout and not out.stderr
    data = json.loads(command("advise", "pair.toml", "--h=-0.1", "--json").stdout)
    assert data["h"] < 0 and data["run_h"] == -0.1
    assert command("advise", "pair.toml", "--start", "no").returncode == 2
