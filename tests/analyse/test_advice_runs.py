"""Step advice for a whole run: with the advised h it completes; pulses of H are seen; the cause of a fold is named."""
import math
import random

import numpy as np
import pytest
from support.advice_specs import text
from support.systems import load

import smidgen
from smidgen.analyse.advice import advise
from smidgen.analyse.advice.along import TURN
from smidgen.analyse.advice.branch import follow
from smidgen.analyse.advice.cause import Fields, effect_of, shares
from smidgen.analyse.advice.equation import StepEquation
from smidgen.analyse.advice.rates import local_rate
from smidgen.analyse.advice.trial import first_failure
from smidgen.errors import RunError
from smidgen.read import load_text

PULSE = '''[model]
name = "pulse"
[space]
w = { sphere = 1 }
[parameters]
A = 60.0
at = 5.0
width = 0.5
[effects.field]
energy = "w.z"
[effects.pulse]
energy = "A*exp(-((t - at)/width)^2)*w.x"
[starts.first]
vectors = [[0.6, 0, 0.8]]
'''
VORTICES = '''[model]
name = "turning"
[space]
w = { sphere = 3, kappa = "g[i]" }
[parameters]
g = { default = [1, 1, 1], size = 3 }
a = 0.0
b = 0.0
c = 0.0
J = 1.0
K = 1.0
[effects.turn]
over = "site(i) of w"
energy = "g[i]*(a*w[i].x + b*w[i].y + c*w[i].z)"
[effects.interaction]
over = "pair(i, j) of w"
energy = "-g[i]*g[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"
[starts.first]
random = 1
'''
SPINS = '''[effects.exchange]
over = "pair(i, j) of w"
energy = "J*dot(w[i], w[j])"
[effects.anisotropy]
over = "site(i) of w"
energy = "K*w[i].z^2"
[starts.first]
random = 1
'''


def on_sphere(r, n):
    w = r.normal(size=(n, 3))
    return w / np.linalg.norm(w, axis=1)[:, None]


# -- chains ---------------------------------------------------------------------------------------

def chain_completes(n, seed, time):
    """The advice, and whether the run completes with its h and with each of three smaller ones."""
    spec, w = load("heisenberg_chain"), on_sphere(np.random.default_rng(seed), n)
    found = advise(spec, parameters={"n": n}, start=w, h=0.05, time=time)
    model = smidgen.build(spec, parameters={"n": n})
    steps = [math.ceil(time / (part * found.h)) for part in (1, 0.93, 0.6, 0.3)]
    done = [model.start(w.copy(), h=part * found.h).advance(k) for part, k in zip((1, 0.93, 0.6, 0.3), steps)]
    return found, [a == b for a, b in zip(done, steps)]


@pytest.mark.parametrize("n, seed", [(5, 1), pytest.param(9, 2, marks=pytest.mark.long)])
def test_random_chains_complete(n, seed):
    found, completes = chain_completes(n, seed, 40)
    assert all(completes) and found.completes and found.span == 40
    assert all(end >= 40 - 1e-9 for *_, end in found.orbits)


@pytest.mark.long
def test_many_random_chains_complete():
    runs = [chain_completes(random.Random(seed).choice((3, 5, 8, 12, 60)), seed, 60) for seed in range(30)]
    assert all(completes[0] for _, completes in runs)
    assert np.mean([completes[1:] for _, completes in runs]) > 0.97     # other ways, that were not looked at
    assert sum(found.t > 0 for found, _ in runs) > 10           # the start alone would not have told


def test_what_is_not_looked_at_is_said():
    """A long run of many sites: as far as the work allows, and said how far."""
    text_ = PULSE.replace("sphere = 1", "sphere = 5000").replace('energy = "w.z"', 'over = "site(i) of w"\nenergy = "w[i].z"')
    text_ = text_[:text_.index("[effects.pulse]")] + "[starts.first]\nrandom = 3\n"
    found = advise(load_text(text_), h=0.05, time=1e6)
    end = max(end for *_, end in found.orbits)
    assert found.span == 1e6 and end < 1e4
    assert all(count * 5000 <= 200_000 for _, count, _ in found.orbits)
    said = next(line for line in found.words() if line.startswith("Examined"))
    assert "the run over a time of 1e+06" in said and f"to t = {end:.6g}" in said


@pytest.mark.quick
def test_a_motion_that_ends_is_told():
    """On an open leaf this one leaves for infinity at t = 5.3: no step completes the run, and the advice says so."""
    found = advise(load_text(text(4)), time=200)
    assert not found.completes and 0 < found.failing < 200
    assert any("may not finish" in line for line in found.words())


# -- H that depends on time -----------------------------------------------------------------------

def end_state(model, h, time):
    steps = math.ceil(time / h)
    return model.start(h=time / steps).steps(steps).w.copy()


@pytest.mark.parametrize("seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 6))])
def test_a_pulse_is_seen_wherever_it_is(seed):
    """Rate, cap and accuracy are those of the pulse: the h that is called fine keeps the phase to a part in a thousand."""
    r, sign = random.Random(seed), 1 - 2 * (seed % 2)
    spec, strength = load_text(PULSE), r.choice((-1, 1)) * math.exp(r.uniform(math.log(3), math.log(300)))
    values = {"A": strength, "at": sign * r.uniform(0.5, 9.5), "width": math.exp(r.uniform(math.log(0.01), 0))}
    found = advise(spec, parameters=values, h=sign * 0.05, time=10)
    assert found.spacing < values["width"] and f"every {found.spacing:.3g} of t" in " ".join(found.words())
    assert found.rate == pytest.approx(math.hypot(1, strength), rel=0.05)
    assert found.rate_t == pytest.approx(values["at"], abs=values["width"] / 3)
    assert abs(found.h) <= 2.05 * math.pi / found.rate
    fine = found.fine
    assert fine <= math.sqrt(0.012) / found.rate and f"with h = {sign * fine:.3g} its phase is accurate to 0.1 %" in " ".join(found.words())
    model, whole = smidgen.build(spec, parameters=values), 10 + abs(strength) * values["width"] * math.sqrt(math.pi)
    error = np.abs(end_state(model, sign * fine, sign * 10) - end_state(model, sign * fine / 8, sign * 10)).max()
    assert error < 1e-3 * whole


def test_a_pulse_that_limits_a_step():
    """Across the pulse, and nothing else: W = -w at h A = 2, whenever it comes; steps pass it by, the advice does not."""
    spec = load_text(PULSE.replace('"w.z"', '"0.01*w.x"').replace("[[0.6, 0, 0.8]]", "[[0, 0.6, 0.8]]"))
    for at in (1.37, 6.2):
        found = advise(spec, parameters={"at": at, "width": 0.02}, time=10, h=1.0)
        assert 0.5 * 2 / 60 < found.h < 2 / 60 and found.t == pytest.approx(at, abs=found.cap)
        assert found.words()[-1].startswith("The run's h = 1 exceeds the largest safe step, 0.0")


@pytest.mark.quick
def test_a_field_that_does_not_depend_on_time_has_no_samples():
    found = advise(load_text(PULSE.replace("exp(-((t - at)/width)^2)", "0.1")), parameters={"A": 1.0}, time=10)
    assert found.spacing is None and found.change == 0


MODULATED = '''[model]
name = "modulated"
[space]
w = { r3 = 1 }
[parameters]
eps = 0.05
Omega = 2.0
[effects.body]
energy = "w.x^2/2 + w.y^2/3.4 + w.z^2/(5.8*(1 + eps*cos(Omega*t)))"
[starts.first]
vectors = [[0.05, 1.2, 0.1]]
'''


@pytest.mark.parametrize("period, time", [(0.15, 50), (0.15, 5000), (2.5, 50)])
def test_a_weak_fast_modulation_is_resolved(period, time):
    """Its frequency is not that of how much H changes, and the samples of a long run are further apart than its period."""
    spec, values = load_text(MODULATED), {"Omega": math.tau / period}
    found = advise(spec, parameters=values, h=0.05, time=time)
    assert found.change == pytest.approx(math.tau / period, rel=0.15) and not found.abrupt and found.fine < period / 8
    assert f"a period of about {math.tau / found.change:.2g}" in " ".join(found.words())
    model = smidgen.build(spec, parameters=values)
    assert np.abs(end_state(model, found.fine, 20) - end_state(model, found.fine / 8, 20)).max() < 1e-3


@pytest.mark.quick
@pytest.mark.parametrize("law, change, abrupt", [("0.5*sin(t) + 0.01*cos(40*t)", 40, False), ("exp(-t/3)", 1 / 3, False), ("t/50", 0, False), ("1e-7*t^2", 0, False),
                                                 ("if(mod(t, 5) < 2.5, 1, 0)", 0, True), ("1e-3*cos(300*t) + t", 300, False)])
def test_the_frequency_of_a_field(law, change, abrupt):
    found = advise(load_text(MODULATED.replace("w.x^2/2 +", f"w.x*({law}) +")), parameters={"eps": 0}, h=0.05, time=50)
    assert found.change == pytest.approx(change, rel=0.05) and found.abrupt is abrupt
    assert any("as if it jumped" in line for line in found.words()) is abrupt


# -- the cause ------------------------------------------------------------------------------------

def turning(seed, low, high):
    """Random strengths and a random uniform rotation, and a random start of three sites."""
    r = random.Random(seed)
    turn = np.array([r.gauss(0, 1) for _ in range(3)]) * math.exp(r.uniform(low, high))
    values = dict(zip("abc", turn), g=[r.choice((-1, 1)) * r.uniform(0.3, 2) for _ in range(3)])
    return {**values, "J": r.uniform(-2, 2), "K": r.uniform(-2, 2)}, on_sphere(np.random.default_rng(seed), 3)


@pytest.mark.parametrize("of_spins, of_vortices, folds", [((63,), (0, 1), 1), pytest.param(
    (63, 101, 130, 179, 267, 295, 310), range(4), 8, marks=pytest.mark.long)])
def test_a_uniform_rotation_is_never_the_cause_of_a_fold(of_spins, of_vortices, folds):
    """H = B . sum kappa w of any strength and direction, beside spins with an easy axis, and vortices."""
    spins, vortices = load_text(VORTICES[:VORTICES.index("[effects.interaction]")] + SPINS), load_text(VORTICES)
    causes = []
    for seed in of_spins:
        values, w = turning(seed, -1, 1.5)
        causes.append(advise(spins, parameters=values, start=w, time=0))
    for seed in of_vortices:
        values, w = turning(seed, -3, 3)
        causes.append(advise(vortices, parameters=values, start=w, time=0))
    assert sum(a.kind == "fold" for a in causes) >= folds
    assert all(a.effect in ("exchange", "anisotropy", "interaction") for a in causes if a.kind == "fold")


@pytest.mark.quick
def test_the_shares_of_the_effects_in_a_fold_are_all_of_it():
    """J v = 0 and J = 1 - (h/2) sum D(X_e P): their sum is 1 as near as the branch was followed to its fold."""
    spec = load_text(VORTICES[:VORTICES.index("[effects.interaction]")] + SPINS)
    for seed in (43, 130, 179, 267):
        values, w = turning(seed, -1, 1.5)
        model = smidgen.build(spec, parameters=values).start(w.copy(), h=0.1)
        equation = StepEquation(model, w, 0.0)
        branch = follow(equation, TURN / local_rate(equation))
        parts = shares(Fields(model, equation, branch.h / 2), w + branch.u / 2, branch)
        assert branch.kind == "fold" and sum(parts.values()) == pytest.approx(1, abs=0.1)
        assert effect_of(model, equation, branch) == max(sorted(set(parts) - {"turn"}), key=parts.get)


# -- steps that fail below others that do not ---------------------------------------------------------

class Hole:
    """A model of one site with steps of every size but those in an interval."""
    real, sites = float, 1

    def __init__(self, low, high):
        self.low, self.high = low, high

    def start(self, w, t0, h):
        self.h = h
        return self

    def step(self):
        if self.low < abs(self.h) < self.high:
            raise RunError("step 1: no", 3)


@pytest.mark.quick
def test_a_hole_is_found():
    """Of a quarter of a hundredth of h or more, wherever it is."""
    for seed in range(50):
        r = random.Random(seed)
        h, place = math.exp(r.uniform(-5, 5)), r.uniform(0.07, 0.99)
        bad = first_failure(Hole(h * place, h * (place + 0.0025)), np.zeros((1, 3)), 0.0, h)
        assert bad is not None and bad.limit < h * place
    assert first_failure(Hole(2.0, 3.0), np.zeros((1, 3)), 0.0, 1.0) is None


# -- the words ---------------------------------------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("h, side", [(1e-3, "does not exceed"), (0.01, "does not exceed"), (50.0, "exceeds")])
def test_the_step_of_the_run_is_compared_with_the_one_that_is_named(h, side):
    found = advise(load_text(PULSE), h=h, time=10)
    largest = "the largest step examined" if found.kind == "open" else "the largest safe step"
    assert f"The run's h = {h:.6g} {side} {largest}, {found.h:.6g}" in found.words()[-1]


def test_the_length_of_the_run():
    """Steps of the run's h, a duration that need not be a multiple of it, or steps of the advised h."""
    spec = load_text(PULSE)
    assert advise(spec, h=0.3, steps=10).span == pytest.approx(3.0)
    assert advise(spec, h=0.3, time=1.0).span == 1.0
    one, ten = advise(spec, steps=1), advise(spec, steps=10)
    assert 10 * one.span == pytest.approx(ten.span)
    assert "Only this state was examined" in " ".join(advise(spec, time=0).words())
