"""Compiled code against the witness: every spec passes, every mutant is caught."""
import dataclasses
import json
from importlib import import_module

import numpy as np
import pytest
from support.systems import QUICK, tiers
from support.witness_models import body, precession, pulsed, sphere

import smidgen
from smidgen.errors import UsageError, ValidationError
from smidgen.language.expr import Num, Op, Spin, Time
from smidgen.run.settings import model_of
from smidgen.resources import folder
from smidgen.language.spec import FamilyStart, Run, Start
from smidgen.check.validate import Line, Report, validate

module = import_module("smidgen.check.validate")       # `smidgen.validate` is the function
SPECS = sorted(p.stem for p in folder("specs").glob("*.toml"))
W0 = ((np.cos(1.1), 0.0, np.sin(1.1)),)


def with_run(spec, h=0.1, vectors=W0, method="spherical-midpoint"):
    start = Start("a", (FamilyStart("w", "vectors", vectors),))
    return dataclasses.replace(spec, starts=(start,), runs=(Run("demo", "a", method, Num(h),
                                                                steps=Num(10)),))


def runs_of(name):
    return [r.name for r in smidgen.load(folder("specs") / f"{name}.toml").runs]


@pytest.mark.parametrize("name", tiers(SPECS, (), ("forced_rigid_body", "nambu_a34", "vortex_tracers")))
def test_every_spec_agrees_with_the_witness(name):
    report = validate(smidgen.load(folder("specs") / f"{name}.toml")).check()
    assert {"field", "energy", "values at the start", "100 steps", "order of convergence"} <= {
        line.check for line in report.lines}


@pytest.mark.parametrize("name, run", [pytest.param(n, r, marks=() if n in QUICK else pytest.mark.long)
                                       for n in SPECS for r in runs_of(n)[1:]])
def test_every_other_run_agrees_too(name, run):
    validate(smidgen.load(folder("specs") / f"{name}.toml"), run).check()


@pytest.mark.parametrize("method", ["spherical-midpoint", "classical-midpoint", "moser-veselov"])
@pytest.mark.quick
def test_methods(method):
    validate(with_run(body((1, 2, 4)), method=method)).check()


# -- mutants: the compiler is given another spec than the witness ------------------------------

def replace_nodes(e, change):
    """The tree with `change` applied to every node, from the leaves up."""
    if isinstance(e, Op):
        e = Op(e.op, tuple(replace_nodes(a, change) for a in e.args))
    return change(e)


def mutated(spec, change):
    return dataclasses.replace(spec, effects=tuple(
        dataclasses.replace(x, value=replace_nodes(x.value, change)) for x in spec.effects))


MUTANTS = {
    "wrong sign": lambda s: mutated(s, lambda e: Op("neg", (e,)) if e == Spin("w", 0) else e),
    "frozen time": lambda s: mutated(s, lambda e: Num(0.0) if e == Time() else e),
    "wrong coefficient": lambda s: mutated(s, lambda e: Num(3.0 + 1e-12) if e == Num(3) else e),
    "other orientation": lambda s: dataclasses.replace(s, orientation=-1),
    "wrong strength": lambda s: dataclasses.replace(s, families=(sphere(kappa=Num(1 + 1e-11)),)),
}


@pytest.mark.quick
@pytest.mark.parametrize("mutant", MUTANTS)
def test_mutants_are_caught(monkeypatch, mutant):
    spec = with_run(pulsed())
    monkeypatch.setattr(module, "model_of", lambda _, settings: model_of(MUTANTS[mutant](spec), settings))
    report = validate(spec)
    assert not report.passed
    with pytest.raises(ValidationError, match="disagree"):
        report.check()


@pytest.mark.quick
def test_another_method_is_caught(monkeypatch):
    """The classical midpoint has order 2 and the same field; only the steps tell."""
    spec = with_run(pulsed())
    monkeypatch.setattr(module, "model_of", lambda s, settings: model_of(s, dataclasses.replace(settings, method="classical-midpoint")))
    assert [x.check for x in validate(spec).lines if not x.passed] == ["100 steps"]


class Euler:
    """A method of order 1 in the place of the compiled one."""

    def __init__(self, model, witness):
        self.model, self.witness, self.columns = model, witness, model.columns
        self.field, self.energy, self.values, self.casimirs = model.field, model.energy, model.values, model.casimirs

    def start(self, w, h):
        self.model.start(np.array(w), h=h)
        self.w, self.h, self.t = np.array(w), h, 0.0
        return self

    def steps(self, count):
        for _ in range(count):
            self.step()
        return self

    def step(self):
        self.w = self.w + self.h * self.witness.vector_field(self.w, self.t)
        self.t += self.h


@pytest.mark.quick
def test_a_method_of_order_one_is_caught(monkeypatch):
    spec = with_run(pulsed())
    monkeypatch.setattr(module, "model_of", lambda *given: Euler(model_of(*given), module.Witness(spec)))
    failed = {x.check for x in validate(spec).lines if not x.passed}
    assert failed == {"100 steps", "order of convergence"}


# -- cases that need care ------------------------------------------------------------------------

@pytest.mark.quick
def test_a_start_at_rest_is_moved():
    report = validate(with_run(body((1, 2, 4)), vectors=((0.0, 0.0, 1.0),))).check()
    assert report.lines[-2].measured == pytest.approx(2, abs=0.2)


@pytest.mark.quick
def test_a_large_step_is_halved_for_the_order():
    report = validate(with_run(precession(1.0), h=1.9)).check()
    assert "halved" in report.lines[-2].note


@pytest.mark.quick
def test_a_tiny_step_is_given_a_longer_time():
    report = validate(with_run(body((1, 2, 4)), h=1e-5)).check()
    assert "doubled" in report.lines[-2].note


@pytest.mark.quick
def test_a_step_without_solution_is_a_line_that_failed():
    report = validate(with_run(precession(1.0), h=2.5, vectors=((1.0, 0.0, 0.0),)))
    line = next(x for x in report.lines if x.check == "100 steps")
    assert not line.passed and ("no solution" in line.note or "not converge" in line.note)


@pytest.mark.quick
def test_growth_is_measured_and_allowed_for():
    spec = smidgen.load(folder("specs") / "irreversible_rigid_body.toml")
    report = validate(spec).check()
    assert report.growth > 10 and "allowed for" in report.lines[3].note
    assert float(report.lines[3].bound) == pytest.approx(1e-13 * report.growth, rel=0.05)


def test_many_sites_are_checked_by_residuals():
    spec = smidgen.load(folder("specs") / "heisenberg_chain.toml")
    report = validate(spec, parameters={"n": 1000}, steps=20).check()
    assert "residual of 20 steps" in {x.check for x in report.lines}


@pytest.mark.quick
def test_no_steps_is_a_usage_error():
    with pytest.raises(UsageError):
        validate(with_run(precession(1.0)), steps=0)


@pytest.mark.quick
def test_reports_as_json_and_text():
    lines = (Line("a", 1e-14, "1e-13", True), Line("b", float("nan"), "a result", False, "why"))
    report = Report("s", "demo", "spherical-midpoint", 0.1, 1, 100, 1.0, lines)
    facts = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert facts["passed"] is False and facts["lines"][1]["measured"] is None
    assert "round-off" in facts["not_seen"] and "Hessian" in facts["not_seen"]
    assert "FAILED" in report.text() and "why" in report.text()
    with pytest.raises(ValidationError, match="b: nan, bound a result why"):
        report.check()


# -- bounds are relative -----------------------------------------------------------------------------

SMALL = """
[model]
name = "small"
[space]
w = {{ sphere = 2, radius = 1e-13, kappa = 1e-13 }}
[effects.field]
over = "site(i) of w"
energy = "w[i].x^2 + {}*w[i].y^2"
[effects.coupling]
energy = "dot(w[0], w[1])"
[starts.any]
w = {{ random = 3 }}
[runs.demo]
start = "any"
h = 0.1
steps = 10
"""


@pytest.mark.quick
@pytest.mark.parametrize("h", [-0.1, 0.1])
def test_steps_in_both_directions_of_time(h):
    assert validate(smidgen.load("forced_rigid_body"), h=h, steps=10).passed


@pytest.mark.quick
def test_short_vectors_are_compared_in_units_of_their_length(monkeypatch):
    right, wrong = (smidgen.load_text(SMALL.format(a)) for a in (0.3, 0.5))
    validate(right).check()
    monkeypatch.setattr(module, "model_of", lambda spec, *settings: model_of(wrong, *settings))
    assert {x.check for x in validate(right).lines if not x.passed} == {
        "field", "energy", "values at the start", "100 steps", "order of convergence"}


@pytest.mark.quick
def test_times_are_those_of_the_run():
    """At t = 10 the phase of such a field has an error of 0.01."""
    w = Spin("w", 0)
    value = Op("*", (Op("cos", (Op("*", (Num(2e13), Time())),)), Op("x", (w,))))
    spec = dataclasses.replace(pulsed(), effects=(dataclasses.replace(pulsed().effects[0], value=Op("*", (Num(1e13), value))),))
    validate(with_run(spec, h=1e-15)).check()


@pytest.mark.quick
def test_a_chaotic_orbit_is_compared_as_far_as_growth_can_be_measured():
    spec = with_run(smidgen.load(folder("specs") / "forced_rigid_body.toml"), h=np.pi / 10, vectors=((np.sin(0.02), np.cos(0.02), 0.0),))
    report = validate(spec, parameters={"eps": 0.07}, steps=4000).check()
    assert "compared for" in report.lines[3].note and report.growth <= module.LINEAR
