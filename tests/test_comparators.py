"""Comparators: order, what each keeps and what it gives up as the certificate measures it, the witness, clean C."""
import json
import subprocess

import numpy as np
import pytest
import smidgen
from mpmath import log, mpf
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError, SpecError, UsageError
from smidgen.methods import METHODS
from smidgen.resources import include_flags
from support.compositions import SPECS, STARTS, apart, compile_model, run
from support.strict import WARNINGS

COMPARED = ("cf4",)
BODY, VORTICES, FREE = SPECS["irreversible body"], SPECS["vortices"], smidgen.load("free_rigid_body")
CHAIN = smidgen.load("heisenberg_chain")
# a drive, R^3 beside spheres of another radius, strengths of both signs, the other orientation, tracers
MIX = smidgen.load_text("""
[model]
name = "mixture"
orientation = -1
[space]
s = { sphere = 3, kappa = [1.0, -0.7, 2.5], radius = 2 }
b = { r3 = 1, kappa = -0.5 }
p = { sphere = 2, tracer = true }
[effects.pairs]
over = "pair(i, j) of s"
energy = "-0.4*log(9 - dot(s[i], s[j]))"
[effects.body]
over = "site(k) of b"
energy = "b[k].x^2/2 + b[k].y^2/4 + 0.1*b[k].z^3"
[effects.join]
over = "each(i of s, k of b)"
energy = "0.2*dot(s[i], b[k])*cos(t)"
[effects.carried]
over = "each(i of p, j of s)"
energy = "0.3*exp(dot(p[i], s[j])/2)*sin(t)"
[starts.a.s]
random = 1
[starts.a.b]
vectors = [[0.3, -0.8, 0.5]]
[starts.a.p]
random = 2
[runs.r]
start = "a"
h = 0.1
steps = 20
""")
MODELS = {"body": BODY, "vortices": VORTICES, "mixture": MIX}


@pytest.fixture(scope="session")
def quad(tmp_path_factory):
    to, known = tmp_path_factory.mktemp("compared"), {}

    def made(spec, method):
        if (spec.name, method) not in known:
            known[spec.name, method] = compile_model(to / f"{spec.name}-{method}", spec, method)
        return known[spec.name, method]
    return made


@pytest.mark.parametrize("name, steps", [("irreversible body", 16), ("driven body", 16), ("vortices", 64)])
@pytest.mark.parametrize("method", COMPARED)
def test_the_order_in_quadruple_precision(quad, name, steps, method):
    spec, start = SPECS[name], STARTS[name]
    exact = run(quad(spec, "spherical-midpoint-10"), start, 1 / 256, 256).w
    errors = [apart(run(quad(spec, method), start, 1 / n, n).w, exact) for n in (steps, 2 * steps)]
    assert errors[1] > mpf(10)**-18
    assert abs(log(errors[0] / errors[1], 2) - METHODS[method].order) < 0.1


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("method", COMPARED)
def test_the_witness_takes_the_same_steps(name, method):
    report = smidgen.validate(MODELS[name], method=method, h=0.05, steps=20)
    assert report.passed, [line for line in report.lines if not line.passed]


# method -> rows that say no on a body and on vortices; rows that say yes on vortices
CLAIMED = {"cf4": ({"symplectic", "reversible"}, {"order", "equivariant", "casimirs", "step"})}


@pytest.mark.parametrize("method", COMPARED)
@pytest.mark.parametrize("name", ["body", "vortices"])
def test_the_certificate_measures_what_is_kept_and_what_is_given_up(name, method):
    rows = {row.name: row for row in smidgen.verify(MODELS[name], method=method, tier="quick").rows}
    given_up, kept = CLAIMED[method]
    assert {row.name for row in rows.values() if row.verdict == "no"} == given_up
    for one in kept if name == "vortices" else kept - {"equivariant", "momentum"}:
        assert rows[one].verdict == "yes"
    if "symplectic" in given_up:
        assert rows["symplectic"].measured > 1e-8 and "not symplectic" in rows["symplectic"].note
    if "reversible" in given_up:
        assert "not symmetric" in rows["reversible"].note


# method -> is the momentum of a chain shown to be kept, the energy of the free body?
SHOWN = {"cf4": (False, False)}


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
def test_explain_claims_no_more(method):
    chain, body = ({i.kind: i for i in smidgen.explain(spec, method=method).integrals} for spec in (CHAIN, FREE))
    assert (chain["linear"].kept, body["energy"].kept) == SHOWN[method]
    assert chain["linear"].kept or "classical" not in chain["linear"].why
    assert chain["casimir"].kept and body["casimir"].kept


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
@pytest.mark.parametrize("name", MODELS)
def test_restored_it_goes_on_with_the_same_bits(name, method):
    integrator = smidgen.build(MODELS[name], method)
    whole = integrator.start("a", h=0.1).steps(12).w.copy()
    saved = integrator.start("a", h=0.1).steps(5).save()
    assert np.array_equal(integrator.start("a", h=0.2).restore(saved).steps(7).w, whole)


CONSTANT = smidgen.load_text("""
[model]
name = "constant"
[space]
w = { sphere = 2 }
[effects.field]
over = "site(i)"
energy = "0.3*w[i].z + 0.1*w[i].x"
[starts.a]
random = 1
[runs.r]
start = "a"
h = 0.3
steps = 20
""")


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
def test_a_constant_field_does_not_wear_a_sphere_down(method):
    integrator = smidgen.build(CONSTANT, method).start("a", h=0.3).steps(10**5)
    assert np.abs(np.linalg.norm(integrator.w, axis=1) - 1).max() < 5e-16


@pytest.mark.quick
def test_a_constant_field_is_turned_about_exactly():
    integrator = smidgen.build(CONSTANT, "cf4").start("a", h=0.3)
    before, axis, angle = integrator.w.copy(), np.array([0.1, 0, 0.3]) / np.hypot(0.1, 0.3), 0.3 * np.hypot(0.1, 0.3)
    along = np.outer(before @ axis, axis)
    assert np.abs(integrator.step().w - (along + np.cos(angle) * (before - along) + np.sin(angle) * np.cross(before, axis))).max() < 3e-16


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
@pytest.mark.parametrize("name", MODELS)
def test_a_step_that_is_no_number_leaves_the_state(name, method):
    integrator = smidgen.build(MODELS[name], method).start("a", h=1e200)
    before = integrator.w.copy()
    with pytest.raises(RunError):
        integrator.step()
    assert np.array_equal(integrator.w, before) and integrator.count == 0


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
def test_other_spaces_and_features_are_refused(method):
    with pytest.raises((SpecError, UsageError), match="Nambu"):
        smidgen.build(smidgen.load("nambu_a31"), method)
    with pytest.raises(UsageError, match="no feature 'tangent'"):
        smidgen.build(FREE, method, features=["tangent"])
    with pytest.raises(UsageError, match="midpoint"):
        smidgen.advise(FREE, method=method)


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
def test_the_command(command, method):
    said = command("run", "irreversible_rigid_body", "--method", method, "--h", "0.25", "--steps", "20", "--json")
    assert said.returncode == 0 and json.loads(said.stdout)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("method", COMPARED)
@pytest.mark.parametrize("compiler", [["gcc", "-std=c11"], ["clang", "-std=c11"], ["g++", "-x", "c++", "-std=c++17"], ["gcc", "-std=c11", "-DSMG_LONG_DOUBLE"]],
                         ids=lambda c: "-".join(c[::2]))
@pytest.mark.parametrize("amalgamate", [pytest.param(False, marks=pytest.mark.long), True])
def test_clean_c(tmp_path, name, method, compiler, amalgamate):
    spec = MODELS[name]
    for file, text in generate(spec, method=method, amalgamate=amalgamate).items():
        (tmp_path / file).write_text(text)
    subprocess.run([*compiler, *WARNINGS, *include_flags(), "-I.", "-fsyntax-only", f"{spec.name}.c"], cwd=tmp_path, check=True)
