"""Faults planted in generated C, for a family of models: each gets its no, or the certificate says what it left out."""
import functools
from importlib import import_module

import numpy as np
import pytest
from support.planted import Planted
from support.systems import load

from smidgen.run.settings import settle
from smidgen.check.verify.along import along
from smidgen.check.verify.branch import branch
from smidgen.check.verify.case import Case
from smidgen.check.verify.certificate import certify
from smidgen.check.verify.integrals import integrals, known_integrals
from smidgen.check.verify.leaves import lengths
from smidgen.check.verify.outputs import outputs
from smidgen.check.verify.round_off import round_off
from smidgen.check.verify.row import NO, YES
from smidgen.check.verify.sums import sums
from smidgen.check.verify.whole_space import GRID, directions, whole_space

validation = import_module("smidgen.check.validate")         # its name in the package is the function's

# name -> values, solver: alone, R^3, Nambu, dense Newton, sweeps and band, sweeps alone, tracers
MODELS = {"free_rigid_body": ({}, "auto"), "irreversible_rigid_body": ({}, "auto"), "two_bodies": ({}, "auto"),
          "product": ({}, "auto"), "nambu_a38": ({}, "auto"), "point_vortices": ({}, "auto"),
          "heisenberg_chain": ({"n": 10}, "auto"), "cubic_lattice": ({"nx": 2, "ny": 2, "nz": 2}, "rotation"),
          "vortex_tracers": ({"m": 4}, "auto")}
FEW = ("heisenberg_chain", "cubic_lattice", "vortex_tracers")   # Newton from rest seldom ends on another branch there
SLOW = ("product", "cubic_lattice", "vortex_tracers")           # their tests take longer to compile and to run
every = pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) if name in SLOW else name for name in MODELS])


@functools.lru_cache(maxsize=None)
def made(name):
    values, solver = MODELS[name]
    return Planted(load(name), values, solver)


def looked(name, fault=None, tier="quick", **more):
    """(case, subject) with the fault switched on."""
    values, _ = MODELS[name]
    case = Case(load(name), settle(load(name), None, parameters=values), 2, tier=tier)
    return case, made(name).switch(fault, **more)


def verdicts(rows):
    for row in rows:
        print(row)
    return {row.name: row.verdict for row in rows}


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) if k % 2 else name for k, name in enumerate(MODELS)])
def test_nothing_planted_nothing_found(name):
    """The same libraries with all faults off: at other seeds of the checks too."""
    case, subject = looked(name)
    rows = [*along(case, subject), *whole_space(case, subject), *sums(case, subject), *branch(case, subject),
            *outputs(case, subject)]
    assert set(verdicts(rows).values()) == {YES}
    case.dice = np.random.default_rng(1)
    assert set(verdicts([*whole_space(case, subject), *sums(case, subject)]).values()) == {YES}


@every
def test_a_state_turned_on_the_way(name):
    """By 1e-9, at any step that is looked at; on their spheres, where the Casimirs cannot tell."""
    case, subject = looked(name)
    count = int(along(case, subject)[0].measured)
    for step in {1, count, *(int(x) for x in np.random.default_rng(len(name)).integers(1, count + 1, 4))}:
        case, subject = looked(name, "turned", step=step)
        assert verdicts(along(case, subject))["run"] == NO, step
    case, subject = looked(name, "turned", step=count + 1)
    assert verdicts(along(case, subject))["run"] == YES
    assert case.unseen[0].startswith(f"steps after the first {count}")


def test_a_state_turned_after_the_run():
    """What the integrals of other, longer runs tell: their size, not its growth."""
    for step, steps in ((50, 1000), (150, 1000), (5000, 10**4)):
        case, subject = looked("free_rigid_body", "turned", tier=steps, step=step)
        found = verdicts(round_off(case, subject, known_integrals(case)))
        assert found["round-off size"] == NO
    case, subject = looked("free_rigid_body", tier=10**4)
    assert set(verdicts(round_off(case, subject, known_integrals(case))).values()) == {YES}


def test_integrals_along_the_run():
    case, subject = looked("heisenberg_chain", "turned", step=700)
    case.find_states(subject)
    known = known_integrals(case)
    along(case, subject)
    assert verdicts(integrals(case, subject, known))["momentum"] == NO


@every
def test_no_compensation(name):
    """Thirty times the round-off with the same exponent: the residuals of a run do not cancel."""
    case, subject = looked(name, "no compensation")
    (row,) = sums(case, subject)
    assert row.verdict == NO and 0.7 < row.measured < 1.3
    case, subject = looked(name)
    assert sums(case, subject)[0].measured < 0.2


@every
def test_no_branch_check(name):
    case, subject = looked(name, "no branch check")
    found, said = verdicts(branch(case, subject))["branch"], case.unseen[0]
    assert said.startswith("whether steps other than ")
    assert found == NO or name in FEW


@every
def test_an_increment_that_is_wrong_in_a_cap(name):
    """5 % of the sphere, where the run comes least; on single sites it does not come there at all."""
    case, subject = looked(name)
    along(case, subject)
    seen = (case.path / np.maximum(lengths(case.path), 1e-300)[..., None]).reshape(-1, 3)
    axis = directions(GRID)[np.argmin((directions(GRID) @ seen.T).max(axis=1))]
    for where in (axis, *np.random.default_rng(2).standard_normal((2, 3))):
        case, subject = looked(name, "cap", axis=where)
        assert verdicts(whole_space(case, subject))["whole space"] == NO
        assert "the largest cap without" in case.unseen[0]
    case, subject = looked(name, "cap", axis=axis)
    if name in ("free_rigid_body", "nambu_a38"):
        assert verdicts(along(case, subject))["run"] == YES


@every
def test_outputs_that_are_wrong(name):
    """Momentum, Casimirs, every energy and observable, one at a time."""
    faults = made(name).outputs_faults()
    if name != "vortex_tracers":            # all strengths are 1 elsewhere
        faults.remove("momentum without kappa")
    assert len(faults) >= 3
    for fault in faults:
        case, subject = looked(name, fault)
        assert verdicts(outputs(case, subject))["outputs"] == NO, fault


@pytest.mark.parametrize("name", ["free_rigid_body", "nambu_a38"])
def test_validate_sees_wrong_casimirs(monkeypatch, name):
    for fault, verdict in ((None, True), ("casimirs", False), ("momentum's sign", False)):
        monkeypatch.setattr(validation, "model_of", lambda *_, f=fault: made(name).switch(f).double)
        line = {x.check: x for x in validation.validate(load(name), steps=2, points=1).lines}["values at the start"]
        assert line.passed == verdict, line


def test_the_certificate_says_what_it_did_not_look_at():
    certificate = certify(load("free_rigid_body"), tier=1000, subject=made("free_rigid_body").switch("turned", step=50))
    rows = {row.name: row.verdict for row in certificate.rows}
    assert {rows[x] for x in ("run", "quadratic integrals", "round-off size")} == {NO}
    assert {rows[x] for x in ("whole space", "residual", "casimirs", "outputs", "symplectic", "branch")} == {YES}
    left_out = certificate.as_dict()["not_looked_at"]
    assert len(left_out) >= 4 and all(words in certificate.text().replace("\n", " ") for words in ("Not measured:", "steps after the first 80"))
