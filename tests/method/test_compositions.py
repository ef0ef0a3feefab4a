"""Symmetric compositions: coefficients, order in quadruple precision, the wrong scheme that only some systems tell, a failed stage,
restart, the predictor, and the way through command, witness and certificate."""
import functools
import json
import subprocess

import numpy as np
import pytest
import smidgen
from mpmath import findroot, log, mpf, workdps
from smidgen.check.witness.compositions import HALVES
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from smidgen.methods import METHODS, SCHEMES
from smidgen.run.step.saved import DEGREE
from smidgen.resources import folder, include_flags
from support.compositions import HOST, SPECS, STARTS, coefficients, compile_model, run
from support.strict import COMMANDS, WARNINGS
from support.triples import apart

PLAIN = ("4", "6", "8", "10")
END = 2
FREE = smidgen.load("free_rigid_body")
FREE_AT_10 = (-0.4503635330766926960600452, -0.09362899305780025785077625, 0.8879224626810953221192839)     # by elliptic functions
OK = 0


def table(scheme):
    """The scheme of tests/coefficients/compositions.py that a suffix of the registry names."""
    return SCHEMES[scheme][2][4:-2]


# ---- coefficients -----------------------------------------------------------------------------

@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_header_is_what_the_script_writes(scheme):
    assert (folder("runtime") / "method" / "tables" / SCHEMES[scheme][2]).read_text() == coefficients.header(table(scheme))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_coefficients_satisfy_the_order_conditions(scheme):
    """To 40 digits; those of the next order they do not; and the registry says the order and the stages that they have."""
    half = list(coefficients.coefficients(table(scheme)))
    order, stages, _, _ = SCHEMES[scheme]
    assert coefficients.SCHEMES[table(scheme)][0] == order and 2 * len(half) + 1 == stages
    with workdps(60):
        assert max(abs(x) for x in coefficients.defects(half, order)) < mpf(10)**-40
        assert max(abs(x) for x in coefficients.defects(half, order + 2)) > mpf(10)**-7
        assert abs(sum(x**3 for x in coefficients.palindrome(half))) < mpf(10)**-38


@pytest.mark.quick
@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_witness_has_the_same_scheme(scheme):
    given = coefficients.SCHEMES[table(scheme)][2].split()
    assert np.allclose(HALVES[scheme], [float(x) for x in given], rtol=0, atol=1e-15)


# ---- order ------------------------------------------------------------------------------------

@pytest.fixture(scope="session")
def quad(tmp_path_factory):
    """quad(system, method, half): the compiled filter in quadruple precision."""
    to, known = tmp_path_factory.mktemp("composed"), {}

    def made(system, method, half=None):
        key = (system, method, None if half is None else tuple(half))
        if key not in known:
            known[key] = compile_model(to / str(len(known)), SPECS[system], method, "quad", half)
        return known[key]
    return made


@pytest.fixture(scope="session")
def solution(quad):
    """solution(system): the state at END, to 1e-23 and better."""
    known = {}

    def of(system):
        if system not in known:
            known[system] = run(quad(system, "spherical-midpoint-10"), STARTS[system], END / 64, 64).w
        return known[system]
    return of


def observed(program, system, exact, steps):
    """Order between a number of steps and twice as many."""
    errors = []
    for n in (steps, 2 * steps):
        found = run(program, STARTS[system], END / n, n)
        assert (found.status, found.count) == (OK, n)
        errors.append(apart(found.w, exact))
    assert errors[1] > mpf(10)**-23
    return log(errors[0] / errors[1], 2)


@pytest.mark.parametrize("scheme, system", [pytest.param(scheme, system, marks=pytest.mark.long if scheme not in PLAIN or (system == "driven body") != (scheme == "4") else ())
                                            for scheme in SCHEMES for system in ("irreversible body", "vortices", "driven body")])
def test_order(quad, solution, system, scheme):
    found = observed(quad(system, f"spherical-midpoint-{scheme}"), system, solution(system), 8 if scheme == "10" else 16)
    assert abs(found - SCHEMES[scheme][0]) < 0.1


@pytest.mark.long
@pytest.mark.parametrize("system", ["irreversible body", "vortices", "driven body"])
@pytest.mark.parametrize("scheme", PLAIN)
def test_order_of_the_classical_midpoint(quad, solution, system, scheme):
    found = observed(quad(system, f"classical-midpoint-{scheme}"), system, solution(system), 8 if scheme == "10" else 16)
    assert abs(found - SCHEMES[scheme][0]) < 0.1


def trap():
    """A scheme of 7 stages that meets sum gamma^3 = sum gamma^5 = 0 but not the condition of the word 113."""
    def sums(a, b):
        every = coefficients.palindrome([a, b, mpf(2) / 5])
        return sum(x**3 for x in every), sum(x**5 for x in every)
    a, b = findroot(sums, (mpf("0.464"), mpf("-0.84")))
    return [a, b, mpf(2) / 5]


def test_a_scheme_of_order_6_on_the_free_body_alone_is_caught(quad, solution):
    """The steps of the free body are shifts along its orbits, which commute: there two conditions do for order 6, elsewhere not."""
    half = trap()
    left = dict(zip(coefficients.conditions(6), coefficients.defects(half, 6)))
    assert abs(left[3,]) < mpf(10)**-30 and abs(left[5,]) < mpf(10)**-30 and abs(left[1, 1, 3]) > 0.01
    orders = {system: observed(quad(system, HOST[0], half), system, solution(system), 32) for system in ("free body", "irreversible body", "vortices")}
    assert abs(orders["free body"] - 6) < 0.1
    assert abs(orders["irreversible body"] - 4) < 0.1 and abs(orders["vortices"] - 4) < 0.1


@pytest.mark.parametrize("system", ["irreversible body", "vortices"])
def test_one_stage_is_the_base_method(quad, system):
    """Bit for bit, without a history: every step begins anew."""
    one, base = quad(system, HOST[0], []), quad(system, "spherical-midpoint")
    w = STARTS[system]
    for h in (0.1, -0.3, 0.2):
        found, wanted = run(one, w, h, 1), run(base, w, h, 1)
        assert found == wanted and found.status == OK
        w = found.w


# ---- a failed stage, restart --------------------------------------------------------------------

def failing(spec, method, start, hs, most):
    """A trajectory whose next step fails after some that do not, and what is saved of it."""
    for h in hs:
        model = smidgen.build(spec, method=method).start(start, h=float(h))
        saved = model.save()
        for done in range(most):
            try:
                model.step()
            except smidgen.RunError:
                if done > 2:
                    return model, saved
                break
            saved = model.save()
    raise AssertionError("no step failed")


def numbers(system):
    return np.array([[float(x) for x in v] for v in STARTS[system]])


@pytest.mark.quick
@pytest.mark.parametrize("system, hs", [("vortices", (1.4,)), ("irreversible body", (8, 10))])
def test_a_failed_stage_leaves_the_state_as_before_the_whole_step(system, hs):
    """The failure is one of a later stage: the first one, taken alone, does not fail."""
    model, saved = failing(SPECS[system], "spherical-midpoint-8", numbers(system), hs, 60)
    count, report, w = model.count, model.report(), model.w.copy()
    first = float(coefficients.coefficients("ss21")[0])
    smidgen.build(SPECS[system]).start(w, h=first * model.h).step()
    assert np.array_equal(model.save(), saved)
    with pytest.raises(smidgen.RunError):
        model.step()
    assert np.array_equal(model.save(), saved) and model.count == count
    assert report["site"] >= 0 and report["reached"] == model.report()["reached"]


@pytest.mark.quick
@pytest.mark.parametrize("method", ["spherical-midpoint-4", "spherical-midpoint-10", "moser-veselov-6"])
def test_restored_it_goes_on_with_the_same_bits(method):
    model = smidgen.build(FREE, method=method)
    whole = model.start("paper", h=0.3).steps(40).w.copy()
    saved = model.start("paper", h=0.3).steps(19).save()
    assert np.array_equal(model.start("paper", h=0.1).steps(2).restore(saved).steps(21).w, whole)      # what has h in it is made anew


@pytest.mark.quick
def test_there_and_back():
    spec = smidgen.load("point_vortices")
    model = smidgen.build(spec, method="spherical-midpoint-6").start(spec.runs[0].start, h=0.3)
    before = model.w.copy()
    end = model.steps(20).w.copy()
    assert np.abs(end - before).max() > 0.1
    assert np.abs(model.start(end, h=-0.3).steps(20).w - before).max() < 1e-13


# ---- the predictor ----------------------------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("system, h", [("irreversible body", 0.25), ("vortices", 0.25)])
def test_the_predictor_cuts_the_iterations(system, h):
    """Iterations a stage, beside those of a stage of the usual size that begins at rest."""
    model = smidgen.build(SPECS[system], method="spherical-midpoint-8").start(numbers(system), h=h).steps(20)
    warm = model.step().report()["iterations"] / 21
    cold = smidgen.build(SPECS[system], method="spherical-midpoint").start(model.w.copy(), h=0.12 * h).step().report()["iterations"]
    assert warm <= cold - 0.9


@pytest.mark.quick
@pytest.mark.parametrize("name, start, fine, rough", [("heisenberg_chain", "random", 0.3, 1.5), ("irreversible_rigid_body", None, 0.3, 3.0)])
def test_the_level_of_the_predictor_follows_the_orbit(name, start, fine, rough):
    """Steps that are small beside it look far back, large ones do not."""
    model = smidgen.build(smidgen.load(name), method="spherical-midpoint-4")
    found = [model.start(start, h=h).steps(60).save()[DEGREE] for h in (fine, rough)]
    assert found[0] == 3 and found[1] <= 1


# ---- through everything -------------------------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("scheme, h, error", [("4", 1 / 4, 1e-7), ("6", 1 / 2, 1e-9), ("8", 1.0, 1e-12), ("10", 1.0, 2e-14)])
@pytest.mark.parametrize("base", ["spherical-midpoint", "moser-veselov"])
def test_the_free_body_is_where_theory_has_it(base, scheme, h, error):
    end = smidgen.build(FREE, method=f"{base}-{scheme}").start("paper", h=h).steps(round(10 / h)).w[0]
    assert np.abs(end - FREE_AT_10).max() < (1 if base == "spherical-midpoint" else 3000) * error


@pytest.mark.parametrize("name, scheme", [("forced_rigid_body", "6"),
                                          *(pytest.param(name, scheme, marks=pytest.mark.long) for name in ("point_vortices", "forced_rigid_body") for scheme in SCHEMES)])
@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate(name, scheme):
    rows = {row.name: row for row in smidgen.verify(smidgen.load(name), method=f"spherical-midpoint-{scheme}", tier="quick").rows}
    for name in ("order", "symplectic", "tangent map", "tangent symplectic", "reversible", "casimirs", "step"):
        assert rows[name].verdict == "yes", rows[name]
    assert rows["residual"].verdict == "does not apply"
    assert not [name for name, row in rows.items() if row.verdict == "no"]


@pytest.mark.quick
def test_the_tangent_map_is_that_of_the_last_step():
    spec = smidgen.load("point_vortices")
    model = smidgen.build(spec, method="spherical-midpoint-4", features=["tangent"]).start(spec.runs[0].start, h=0.1).steps(3)
    saved, v = model.save(), np.zeros((1, len(model.w), 3))
    v[0, 0] = np.cross(model.w[0], (0, 0, 1))
    model.tangent(v)
    assert np.array_equal(model.save(), saved)
    with pytest.raises(smidgen.RunError):
        model.restore(saved).tangent(v)


@pytest.mark.quick
def test_explain_knows_what_it_keeps():
    report = smidgen.explain(FREE, method="spherical-midpoint-8")
    assert all(i.kept for i in report.integrals if i.kind in ("quadratic", "energy", "casimir"))
    assert "composed to order 8" in " ".join(report.words())


@pytest.mark.quick
def test_what_it_does_not_have_is_refused():
    with pytest.raises(UsageError, match="no feature 'extended'"):
        smidgen.build(FREE, method="spherical-midpoint-8", features=["extended"])
    with pytest.raises(UsageError, match="single body"):
        smidgen.build(smidgen.load("point_vortices"), method="moser-veselov-4")
    with pytest.raises(UsageError, match="midpoint"):
        smidgen.advise(FREE, method="spherical-midpoint-4")


@pytest.mark.quick
def test_the_command(command):
    said = command("run", "free_rigid_body", "--method", "spherical-midpoint-8", "--h", "0.5", "--steps", "20", "--json")
    assert said.returncode == 0 and json.loads(said.stdout)
    assert command("gen", "free_rigid_body", "--method", "spherical-midpoint-8", "--out", "c").returncode == 0


@functools.lru_cache
def files_of(name, method, amalgamate, features):
    """Generated once for all compilers."""
    spec = SPECS["irreversible body"] if name == "irreversible" else smidgen.load(name)
    return generate(spec, method=method, amalgamate=amalgamate, features=features)


@pytest.mark.parametrize("name, method", [("vortex_tracers", "spherical-midpoint-4"), ("irreversible", "spherical-midpoint-10"),
                                          ("heisenberg_chain", "classical-midpoint-6"), ("nambu_a31", "spherical-midpoint-8")])
@pytest.mark.parametrize("compiler", COMMANDS)
@pytest.mark.parametrize("amalgamate", [pytest.param(False, marks=pytest.mark.long), True])
def test_clean_c(tmp_path, name, method, compiler, amalgamate):
    for features in ((), ("tangent",)):
        for file, text in files_of(name, method, amalgamate, features).items():
            (tmp_path / file).write_text(text)
        subprocess.run([*compiler, *WARNINGS, *include_flags(), "-I.", "-fsyntax-only", f"{name}.c"], cwd=tmp_path, check=True)


@pytest.mark.quick
def test_every_midpoint_method_has_every_scheme():
    for base in ("spherical-midpoint", "classical-midpoint", "moser-veselov"):
        for scheme, (order, stages, _, _) in SCHEMES.items():
            method = METHODS[f"{base}-{scheme}"]
            assert (method.order, method.stages, method.symplectic) == (order, stages, METHODS[base].symplectic)
