"""Comparators: order, what each keeps and what it gives up as the certificate measures it, the witness, clean C."""
import functools
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
from support.compositions import SPECS, STARTS, compile_model, run
from support.runtime_faults import Fault, plant
from support.triples import apart
from support.strict import COMMANDS, WARNINGS

COMPARED = ("cf4", "heun", "depondt-mertens", "isospectral-midpoint", "geodesic-midpoint", "exponential-midpoint", "rattle")
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
STEPS = {"body": 0.1, "vortices": 0.005, "mixture": 0.1}    # these vortices are close, and H off the spheres is taken by some of the methods


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
    exact = run(quad(spec, "spherical-midpoint-10"), start, 1 / 64, 64).w     # of order 10, beside orders 2 and 4
    errors = [apart(run(quad(spec, method), start, 1 / n, n).w, exact) for n in (steps, 2 * steps)]
    assert errors[1] > mpf(10)**-18
    assert abs(log(errors[0] / errors[1], 2) - METHODS[method].order) < 0.1


@pytest.mark.parametrize("name, method", [pytest.param(name, method, marks=pytest.mark.long if method == "rattle" and name in ("mixture", "vortices") else ())
                                          for method in COMPARED for name in MODELS])
def test_the_witness_takes_the_same_steps(name, method):
    report = smidgen.validate(MODELS[name], method=method, h=STEPS[name], steps=20)
    assert report.passed, [line for line in report.lines if not line.passed]


# method -> rows that say no on a body and on vortices; rows that say yes on vortices
CLAIMED = {"cf4": ({"symplectic", "reversible"}, {"order", "equivariant", "casimirs", "step"}),
           "heun": ({"symplectic", "reversible"}, {"order", "equivariant", "casimirs", "step"}),
           "depondt-mertens": ({"symplectic", "reversible"}, {"order", "equivariant", "casimirs", "step"}),
           "isospectral-midpoint": (set(), {"order", "symplectic", "reversible", "equivariant", "momentum", "casimirs", "step"}),
           "rattle": (set(), {"order", "symplectic", "reversible", "equivariant", "momentum", "casimirs", "step", "tolerance"}),
           "exponential-midpoint": (set(), {"order", "symplectic", "reversible", "equivariant", "momentum", "casimirs", "step", "tolerance"}),
           "geodesic-midpoint": ({"symplectic"}, {"order", "reversible", "equivariant", "casimirs", "step"})}


@pytest.mark.parametrize("method", [m if m == "rattle" else pytest.param(m, marks=pytest.mark.long) for m in COMPARED])
@pytest.mark.parametrize("name", ["vortices", pytest.param("body", marks=pytest.mark.long)])
@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate_measures_what_is_kept_and_what_is_given_up(name, method):
    rows = {row.name: row for row in smidgen.verify(MODELS[name], method=method, h=STEPS[name], tier="quick").rows}
    given_up, kept = CLAIMED[method]
    assert {row.name for row in rows.values() if row.verdict == "no"} == given_up
    for one in kept if name == "vortices" else kept - {"equivariant", "momentum"}:
        assert rows[one].verdict == "yes"
    if "symplectic" in given_up:
        assert rows["symplectic"].measured > 1e-8 and "not symplectic" in rows["symplectic"].note
    if "reversible" in given_up:
        assert "not symmetric" in rows["reversible"].note


# method -> is the momentum of a chain shown to be kept, the energy of the free body?
SHOWN = {**dict.fromkeys(("cf4", "heun", "depondt-mertens"), (False, False)), "isospectral-midpoint": (True, False), "geodesic-midpoint": (False, True), "exponential-midpoint": (True, False), "rattle": (True, False)}


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
    integrator = smidgen.build(MODELS[name], method=method)
    whole = integrator.start("a", h=STEPS[name]).steps(12).w.copy()
    saved = integrator.start("a", h=STEPS[name]).steps(5).save()
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
    integrator = smidgen.build(CONSTANT, method=method).start("a", h=0.3).steps(10**5)
    assert np.abs(np.linalg.norm(integrator.w, axis=1) - 1).max() < 5e-16


@pytest.mark.quick
@pytest.mark.parametrize("method, h", [("cf4", 0.3), ("exponential-midpoint", 0.3), ("exponential-midpoint", 19.8)])
def test_a_constant_field_is_turned_about_exactly(method, h):
    integrator = smidgen.build(CONSTANT, method=method).start("a", h=h)
    before, axis, angle = integrator.w.copy(), np.array([0.1, 0, 0.3]) / np.hypot(0.1, 0.3), h * np.hypot(0.1, 0.3)
    along = np.outer(before @ axis, axis)
    assert np.abs(integrator.step().w - (along + np.cos(angle) * (before - along) + np.sin(angle) * np.cross(before, axis))).max() < 3e-16 * max(1, angle)


@pytest.mark.quick
@pytest.mark.parametrize("h", [19.9, -19.9, 1e100])
def test_the_exponential_map_serves_turns_below_two_pi(h):
    integrator = smidgen.build(CONSTANT, method="exponential-midpoint").start("a", h=h)
    before = integrator.w.copy()
    with pytest.raises(RunError) as refused:
        integrator.step()
    assert refused.value.status == 1 and np.array_equal(integrator.w, before)


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("h", [1e200, 1e100])
def test_a_step_that_is_no_number_leaves_the_state(name, method, h):
    """Explicit rotations exist at any h below the square root of the largest number."""
    integrator = smidgen.build(MODELS[name], method=method).start("a", h=h)
    before = integrator.w.copy()
    if METHODS[method].how[0] == "explicit" and h < 1e150:
        assert np.all(np.isfinite(integrator.step().w))
        return
    with pytest.raises(RunError):
        integrator.step()
    assert np.array_equal(integrator.w, before) and integrator.count == 0


@pytest.mark.quick
@pytest.mark.parametrize("method, error", [("geodesic-midpoint", 5.926e-6), ("isospectral-midpoint", 2.723e-4), ("cf4", 6.751e-10), ("moser-veselov", 1.325e-4),
                                           ("exponential-midpoint", 1.0486e-5), ("rattle", 8.065e-5)])
def test_the_errors_of_the_free_body_are_those_of_the_page(method, error):
    one, exact = (smidgen.build(FREE, method=m).start("paper", h=2**-5) for m in (method, "gauss-16"))
    assert max(np.linalg.norm(one.step().w - exact.step().w, axis=1).max() for _ in range(320)) == pytest.approx(error, rel=2e-3)


ONE = """
[model]
name = "one"
[space]
w = {{ sphere = 1 }}
[effects.h]
energy = "{}"
[starts.a]
theta = "pi/2 - 1.1"
phi = 0
"""
# H of one site -> largest component errors on [0, 10], h = 2^-5, by steps of these equations in another program
ERRORS = {"w[0].x^2/2 + w[0].y^2/4 + w[0].z^2/8": {"spherical-midpoint": 1.213e-5, "isospectral-midpoint": 2.710e-4, "exponential-midpoint": 8.209e-6, "rattle": 8.031e-5},
          "w[0].x^2/2 + 3*w[0].y^2/8 + w[0].z^2/4": {"spherical-midpoint": 3.879e-7, "isospectral-midpoint": 3.928e-4, "exponential-midpoint": 1.563e-5, "rattle": 4.561e-5},
          "(w[0].x^4 + w[0].y^4 + w[0].z^4)/4": {"spherical-midpoint": 6.501e-5, "isospectral-midpoint": 1.072e-3, "exponential-midpoint": 2.646e-5, "rattle": 1.115e-4},
          "w[0].x*w[0].y*w[0].z": {"spherical-midpoint": 1.281e-5, "isospectral-midpoint": 8.357e-6, "exponential-midpoint": 1.119e-5, "rattle": 2.089e-6}}


WITH_C_1 = (5.245e-4, 4.775e-4, 1.252e-3, 2.089e-6)       # of RATTLE


def assert_errors(H, errors):
    spec = smidgen.load_text(ONE.format(H))
    exact = smidgen.build(spec, method="gauss-16").start("a", h=2**-5)
    exact = [exact.step().w.copy() for _ in range(320)]
    for method, error in errors.items():
        one = smidgen.build(spec, method=method).start("a", h=2**-5)
        assert max(np.abs(one.step().w - w).max() for w in exact) == pytest.approx(error, rel=5e-4)


@pytest.mark.quick
@pytest.mark.parametrize("H", ERRORS)
def test_errors_of_four_hamiltonians(H):
    assert_errors(H, ERRORS[H])


def test_rattle_depends_on_the_extension(monkeypatch, tmp_path):
    """But for xyz, where s and sigma are nearly nothing."""
    plant(monkeypatch, tmp_path, Fault("", "smg_rattle.h", "(smg_real)0.25 /* c */", "(smg_real)1 /* c */", ()))
    for H, error in zip(ERRORS, WITH_C_1):
        assert_errors(H, {"rattle": error})


SCALED = """
[model]
name = "scaled"
orientation = {orientation}
[space]
w = {{ sphere = 1, radius = {radius}, kappa = {kappa} }}
[parameters]
a = {factor}
r = {radius}
[effects.h]
energy = "a*((w[0].x/r)^4/4 + w[0].y*w[0].z/r^2 + 0.3*w[0].x/r)"
[starts.a]
theta = 0.7
phi = 0.4
"""


@pytest.mark.quick
@pytest.mark.parametrize("method", [m for m in COMPARED if METHODS[m].how[0] != "explicit"])
@pytest.mark.parametrize("radius, kappa, orientation", [(3.0, -2.5, 1), (0.25, 4.0, -1)])
def test_a_step_depends_on_the_motion_alone(method, radius, kappa, orientation):
    """X/r as a function of w/r is the same, and so is W/r: whatever r, kappa and the orientation."""
    models = [smidgen.build(smidgen.load_text(SCALED.format(radius=r, kappa=k, orientation=o, factor=r * k * o)), method=method)
              for r, k, o in ((1.0, 1.0, 1), (radius, kappa, orientation))]
    one, other = (model.start("a", h=0.2).steps(10).w for model in models)
    assert np.abs(one - other / radius).max() < 1e-14


@pytest.mark.quick
@pytest.mark.parametrize("method", [m for m in COMPARED if METHODS[m].symmetric])
@pytest.mark.parametrize("name", MODELS)
def test_a_step_of_minus_h_undoes_a_step(name, method):
    model = smidgen.build(MODELS[name], method=method).start("a", h=STEPS[name])
    w = model.w.copy()
    after = model.step().state()
    back = model.start(after.copy(), h=-STEPS[name], t0=STEPS[name]).step()
    assert np.abs(after - w).max() > 1e-3 and np.abs(back.w - w).max() < 4e-15


@pytest.mark.parametrize("method, at, low, high", [("geodesic-midpoint", 1e5, 0.04, 0.06), ("cf4", 5000, -0.02, -0.01), ("isospectral-midpoint", 2e4, -5e-3, 3.5e-3),
                                                     ("exponential-midpoint", 2e4, -2e-3, 1.8e-3), ("rattle", 2e4, -1e-3, 1.2e-3)])
def test_the_energy_drifts_where_the_method_is_not_symplectic(method, at, low, high):
    spec = smidgen.load("irreversible_rigid_body")
    integrator = smidgen.build(spec, method=method).start(spec.runs[0].start, h=0.5)
    first, found = integrator.values()[0], []
    for _ in range(40):
        found.append(integrator.steps(round(at / 20)).values()[0] - first)
    assert low < found[-1] < high
    if METHODS[method].symplectic:
        assert low < min(found) and max(found) < high


@pytest.mark.parametrize("method, errors", [("geodesic-midpoint", (-4.02e-4, 3.561e-3)), ("cf4", (-5.457e-3, -4.561e-2))])
def test_energy_errors_of_the_irreversible_body_are_those_of_the_page(method, errors):
    """At t = 2000 and 20000."""
    spec = smidgen.load("irreversible_rigid_body")
    integrator = smidgen.build(spec, method=method).start(spec.runs[0].start, h=0.5)
    first = integrator.values()[0]
    assert [integrator.steps(n).values()[0] - first for n in (4000, 36000)] == pytest.approx(errors, rel=2e-3)


# ---- RATTLE for the free rigid body: discrete Moser-Veselov ---------------------------------------------

def hat(a):
    """x -> a x x."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def rattle_step(w, inertia, h):
    """w after one step of RATTLE (Andersen 1983) for R in SO(3), embedded in the matrices with L = tr(R' D R'^T)/2, D_i = (I_j + I_k - I_i)/2:

        P = P_0 - (h/2) R_0 M,  R_1 = R_0 + h P D^-1,  R_1^T R_1 = 1,  P_1 = P - (h/2) R_1 N,  R_1^T P_1 D^-1 skew,

    from R_0 = 1, P_0 = (I^-1 w)^ D with the symmetric multipliers M and N; w^ = R^T P - (R^T P)^T."""
    D = np.diag(inertia.sum() / 2 - inertia)
    back, basis = np.linalg.inv(D), [np.eye(3)[[i]].T @ np.eye(3)[[j]] for i in range(3) for j in range(i, 3)]
    basis = [e + e.T for e in basis]

    def solved(residual, change):
        """Multipliers sum x_k basis_k with residual(x) = 0, symmetric, by Newton."""
        x = np.zeros(6)
        for _ in range(12):
            matrix = np.array([change(x, e)[np.triu_indices(3)] for e in basis]).T
            x = x - np.linalg.solve(matrix, residual(x)[np.triu_indices(3)])
        return sum(a * e for a, e in zip(x, basis))

    def moved(x):
        return np.eye(3) + h * (P0 - h / 2 * sum(a * e for a, e in zip(x, basis))) @ back

    def changed(x, e):
        d = -h * h / 2 * e @ back
        return d.T @ moved(x) + moved(x).T @ d
    P0 = hat(w / inertia) @ D
    P = P0 - h / 2 * solved(lambda x: moved(x).T @ moved(x) - np.eye(3), changed)
    R = np.eye(3) + h * P @ back

    def hidden(x):
        v = R.T @ (P - h / 2 * R @ sum(a * e for a, e in zip(x, basis))) @ back
        return v + v.T
    N = solved(hidden, lambda x, e: -h / 2 * (e @ back + (e @ back).T))
    found = R.T @ (P - h / 2 * R @ N)
    found = found - found.T
    return np.array([found[2, 1], found[0, 2], found[1, 0]])


@pytest.mark.quick
@pytest.mark.parametrize("inertia", [(1.0, 2.0, 4.0), (1.0, 4 / 3, 2.0), (1.0, 1.5, 1.7)])
@pytest.mark.parametrize("h", [0.1, 0.5])
def test_rattle_for_the_free_body_is_discrete_moser_veselov(inertia, h):
    """McLachlan and Zanna, The discrete Moser-Veselov algorithm for the free rigid body, revisited (2005): so the registry has it once."""
    integrator = smidgen.build(FREE, method="moser-veselov", parameters=dict(zip(("I1", "I2", "I3"), inertia))).start("paper", h=h)
    w = integrator.w[0].copy()
    for _ in range(20):
        w = rattle_step(w, np.array(inertia), h)
        assert np.abs(integrator.step().w[0] - w).max() < 1e-13


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
def test_other_spaces_and_features_are_refused(method):
    with pytest.raises((SpecError, UsageError), match="Nambu"):
        smidgen.build(smidgen.load("nambu_a31"), method=method)
    with pytest.raises(UsageError, match="no feature 'tangent'"):
        smidgen.build(FREE, method=method, features=["tangent"])
    with pytest.raises(UsageError, match="midpoint"):
        smidgen.advise(FREE, method=method)


@pytest.mark.quick
@pytest.mark.parametrize("method", COMPARED)
def test_the_command(command, method):
    said = command("run", "irreversible_rigid_body", "--method", method, "--h", "0.25", "--steps", "20", "--json")
    assert said.returncode == 0 and json.loads(said.stdout)


@functools.cache
def files_of(name, method, amalgamate):
    return generate(MODELS[name], method=method, amalgamate=amalgamate)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("method", COMPARED)
@pytest.mark.parametrize("compiler", COMMANDS[:4])
@pytest.mark.parametrize("amalgamate", [pytest.param(False, marks=pytest.mark.long), True])
def test_clean_c(tmp_path, name, method, compiler, amalgamate):
    spec = MODELS[name]
    for file, text in files_of(name, method, amalgamate).items():
        (tmp_path / file).write_text(text)
    subprocess.run([*compiler, *WARNINGS, *include_flags(), "-I.", "-fsyntax-only", f"{spec.name}.c"], cwd=tmp_path, check=True)
