"""Lattices by rows whose effects depend on time: the step that the equation has, at the time of each stage."""
import math
import operator
import re

import numpy as np
import pytest
import smidgen
import sympy as sp
from smidgen.check.witness import Witness
from smidgen.compile.assemble.extent import extent
from smidgen.compile.assemble.model import Model
from smidgen.compile.emit.emit import generate
from smidgen.compile.plan.plan import choose
from support.going_on import one_by_one, restored
from test_rows import DM, EXCHANGE, HONEY, SKEW, lattice

MIDPOINT, TURNS, PAIRS = "spherical-midpoint", "sublattice-rotations", "pair-rotations"


def field(energy, name="field"):
    return f'[effects.{name}]\nover = "site(i) of w"\nenergy = "{energy}"\n'


WAVE = field("-0.5*cos(2*t + 0.3)*w[i].z + 0.2*sin(t)*w[i].x")
ROUND = field("-0.6*(cos(3*t)*w[i].x + sin(3*t)*w[i].y)")
STAIRS = field("-0.1*(1 + abs(mod(floor(t/0.13), 8) - 4) + mod(t, 0.7))*w[i].z")
PULSE = field("-0.8*exp(-(t - 0.4)^2)*w[i].y + 0.3*w[i].z^2*if(mod(t, 1) < 0.5, 1, -1)")
BENT = EXCHANGE.replace("-0.7", "-0.5*(1 + 0.4*sin(5*t))")
TWISTED = DM.replace("0.2*", "0.2*cos(4*t)*")
DAMPING = '[effects.loss]\nover = "site(i) of w"\ndamping = 0.2\n'
SPECS = {
    "ring": lattice("ring", "chain(n, periodic)", 17, "n", EXCHANGE + WAVE),
    "even ring": lattice("even_ring", "chain(n, periodic)", 34, "n", EXCHANGE + WAVE + DM),
    "open square": lattice("open_square", "square(n, 5, open)", 9, "5*n", BENT + ROUND),
    "blocks": lattice("blocks", "cubic(n, n, 4, periodic)", 8, "4*n*n", EXCHANGE + PULSE),
    "honeycomb": lattice("honeycomb", "honey.all", 5, "6*n", EXCHANGE + TWISTED + ROUND, HONEY),
    "three colours": lattice("skew", "skew.near", 13, "4*n", BENT + TWISTED + WAVE, SKEW),
    "stairs": lattice("stairs", "square(n, 6, periodic)", 6, "6*n", EXCHANGE + STAIRS),
    "damped": lattice("damped", "square(n, 6, periodic)", 6, "6*n", EXCHANGE + WAVE + DAMPING),
    "other spheres": lattice("spheres", "chain(n, periodic)", 20, "n", EXCHANGE + PULSE, more=", radius = 1.7, kappa = -0.6"),
}
LINEAR = ("ring", "even ring", "open square", "honeycomb", "three colours")
CASES = [*((n, m) for n in SPECS for m in (MIDPOINT, "gauss-4") if (n, m) != ("damped", "gauss-4")), *((n, f"{TURNS}{more}") for n in LINEAR for more in ("", "-4"))]
QUICK = {("blocks", MIDPOINT), ("three colours", MIDPOINT), ("even ring", TURNS), ("open square", f"{TURNS}-4")}


def text(spec, method=MIDPOINT, **how) -> str:
    return generate(spec, method=method, **how)[f"{spec.name}.c"]


def by_rows(spec, method=MIDPOINT) -> bool:
    return re.search("define (SMG_BY_ROWS|SMG_ROW_STAGES|SMG_ROW_FIELDS)", text(spec, method)) is not None


@pytest.mark.parametrize("name, method", [pytest.param(*case, marks=() if case in QUICK else pytest.mark.long) for case in CASES])
def test_rows_solve_the_step_at_its_time(name, method):
    """Against the witness, which knows no rows, from a time that is not 0."""
    spec = SPECS[name]
    assert by_rows(spec, method)
    model = smidgen.build(spec, method=method).start("random", h=0.1, t0=0.37)
    w = model.w.copy()
    found = Witness(spec).steps(w, 0.37, 0.1, 5, method)
    assert np.abs(model.steps(5).w - (found if np.ndim(found) == 2 else found[-1])).max() <= 2e-14 * np.abs(w).max()


def test_a_pulse_beside_another_effect_on_the_same_bonds_is_bounded():
    """In their sum exp(-(t - 1)^2) stays whole: multiplied out it has a factor exp(2 t), which grows."""
    pulsed = EXCHANGE + '[effects.pulse]\nover = "bond(i, j) of {over}"\nenergy = "-0.7*exp(-(t - 1)^2)*w[i].x*w[j].x"\n'
    assert by_rows(lattice("pulsed", "square(n, 4, periodic)", 6, "4*n", pulsed), TURNS)


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n == "even ring" else pytest.mark.long) for n in LINEAR])
def test_turns_have_the_bits_of_those_from_site_to_site(name):
    """Where sites of a colour do not meet; a build for ensembles goes from site to site."""
    for method in (TURNS, f"{TURNS}-4"):
        ends = [smidgen.build(SPECS[name], method=method, features=features).start("random", h=0.2, t0=0.1).steps(8).save() for features in ((), ("ensemble",))]
        assert np.array_equal(*ends)


def test_pairs_in_time():
    spec = lattice("pairs", "square(n, 6, periodic)", 8, "6*n", BENT + EXCHANGE.replace("exchange", "more").replace("-0.7*dot(w[i], w[j])", "0.1*cos(t)*dot(w[i], w[j])^2"))
    for method in (PAIRS, f"{PAIRS}-4"):
        assert by_rows(spec, method)
        ends = [smidgen.build(spec, method=method, features=features).start("random", h=0.2, t0=0.1).steps(8).save() for features in ((), ("ensemble",))]
        assert np.array_equal(*ends)


@pytest.mark.parametrize("method, order", [(MIDPOINT, 2), (TURNS, 2), (f"{TURNS}-4", 4), (PAIRS, 2), pytest.param(f"{PAIRS}-4", 4, marks=pytest.mark.long)])
def test_order(method, order):
    """Of steps against those half as long, and of these against half of them again: a time that is off by h would leave order 1."""
    spec, ends = lattice("bent", "square(n, 6, periodic)", 4, "6*n", BENT + (WAVE if method[:5] != "pair-" else "")), []
    for n in (32, 64, 128):
        ends.append(smidgen.build(spec, method=method).start("random", h=1 / n, t0=0.2).steps(n).w.copy())
    ratio = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max()
    assert abs(np.log2(ratio) - order) < 0.25


@pytest.mark.parametrize("name, method", [("blocks", MIDPOINT), ("even ring", f"{TURNS}-4"), ("ring", "gauss-4")])
def test_restored_it_goes_on_at_its_time(name, method):
    model = smidgen.build(SPECS[name], method=method)
    assert restored(model) and one_by_one(model)


def test_threads_have_the_same_bits(monkeypatch):
    monkeypatch.setenv("OMP_WAIT_POLICY", "passive")
    wanted = smidgen.build(SPECS["blocks"]).start("random", h=0.1).steps(9).save()
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    assert np.array_equal(smidgen.build(SPECS["blocks"], threads=2).start("random", h=0.1).steps(9).save(), wanted)


def test_the_way_of_a_state_is_the_same_at_all_times():
    """A field that is strong now and then: no step goes by rows."""
    spec = lattice("now_and_then", "chain(n, periodic)", 16, "n", EXCHANGE + field("-60*cos(t)*w[i].z"))
    assert by_rows(spec)
    for t0 in (0.0, np.pi / 2):
        model = smidgen.build(spec).start("random", h=0.05, t0=t0)
        w = model.w.copy()
        found = Witness(spec).steps(w, t0, 0.05, 2)
        assert np.abs(model.steps(2).w - (found if np.ndim(found) == 2 else found[-1])).max() <= 1e-13


@pytest.mark.parametrize("energy", ["-0.1*t*w[i].z", "-exp(t)*w[i].x", "-1/t*w[i].x"])
def test_what_has_no_bound_at_all_times(energy):
    """It has one at the time of each step."""
    spec = lattice("unbounded", "chain(n, periodic)", 16, "n", EXCHANGE + field(energy))
    assert by_rows(spec) and by_rows(spec, TURNS) and by_rows(spec, "gauss-4")


def test_a_long_strength_leaves_the_term_whole():
    """What has no vectors is not differentiated, however long it is."""
    steps = field("-0.3*(1 + abs(mod(floor(t/0.07 + 0.3*sin(t)^2), 8) - 4) + cos(mod(t, 3))*exp(-mod(t + 0.2, 1)^2))*w[i].z")
    assert by_rows(lattice("stairs", "square(n, 6, periodic)", 8, "6*n", EXCHANGE + steps))


FORMULAS = ["cos(t)", "-2*sin(3*t)^3", "1 - a*cos(t)", "a*b*cos(t)*sin(t)", "exp(-(t - a)^2/b^2)", "1/(a^2 + 1 + t^2)", "b/(2 + sin(t))", "-1/(1 + exp(-t))", "tanh(t - a)*b", "min(max(t/3, 0), b)",
            "max(a, -abs(b*sin(t)))", "if(t < a, b, a*cos(t))", "atan(t)*a", "sqrt(2 + a*a + cos(t))", "floor(3*cos(t)) - a", "acos(sin(t))", "cosh(cos(t) - a)", "(a - cos(t))^2 - (b + sin(t))^3", "abs(b)*exp(sin(t))", "log(2 + cos(t))",
            "asin(sin(t)/2)*a", "atan2(cos(t), sin(t))", "(1 + a*sin(t))*(b - cos(t))*(a + exp(-abs(t)))", "1/(cos(t) - 3)",
            "mod(t, 2)", "mod(t/3, a)*b", "abs(mod(floor(t/0.7), 8) - 4) - a", "(t - floor(t))*sin(t)", "a + mod(b*t^2, 3)"]


@pytest.mark.parametrize("formula", FORMULAS)
def test_ends_hold_all_values(formula):
    """At many times, and for parameters of both signs."""
    spec = smidgen.load_text(f'[model]\nname = "one"\n[space]\nw = {{ sphere = 2 }}\n[parameters]\na = 1.0\nb = 1.0\n[effects.all]\nover = "site(i) of w"\nenergy = "({formula})*w[i].z"\n[starts.up]\nrandom = 1\n')
    model = Model(spec, choose(spec, MIDPOINT, "auto"))
    low, e = model.low, model.energies[0].derived.gradient[0][2]
    nodes = {type(low.leaves[s.name]).__name__ + getattr(low.leaves[s.name], "name", ""): s for s in e.free_symbols}
    ends = extent(low, e)
    assert None not in ends
    for a, b in ((0.4, 0.9), (-1.3, 0.2), (2.5, -1.7), (-0.3, -3.1)):
        values = {nodes[key]: value for key, value in (("Para", a), ("Parb", b)) if key in nodes}
        lowest, highest = (number(end, values) for end in ends)
        t = np.concatenate([np.linspace(-12, 12, 61), np.linspace(0, 3, 61)])
        found = np.array([number(e, {**values, nodes["Time"]: float(x)}) for x in t])
        assert lowest - 1e-12 <= found.min() and found.max() <= highest + 1e-12


PLAIN = {"lesser": lambda a, b, *_: min(a, b), "greater": lambda a, b, *_: max(a, b), "chosen": lambda c, a, b: a if c else b, "absolute": lambda x, *_: abs(x), "floor_": math.floor,
         "plus": operator.add, "minus": operator.sub, "times": operator.mul, "over": operator.truediv, "negative": operator.neg}


def number(e, values) -> float:
    return float(sp.lambdify([], sp.sympify(e).xreplace({s: sp.Float(x) for s, x in values.items()}), modules=[PLAIN, "math"])())
