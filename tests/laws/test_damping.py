"""Damping: the motion is that of the law, at the order of the method, on the spheres, and absent where a scene does not call for it.

    Gilbert             w' = o w x b + o s (alpha/r) w x w'
    Landau, Lifshitz    w' = o w x b + s (alpha/r) w x (w x b),   b = (1/kappa) dH/dw, s the sign of kappa
"""
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.strict import COMPILERS, OPTIMISED, READ, REALS, compile_all

import smidgen
from smidgen.build.binary import write_files
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.errors import UsageError
from smidgen.methods import METHODS
from smidgen.run.step.integrator import build

quick = pytest.mark.quick
PAIRS = """[effects.pairs]
over = "pair(i, j) of w"
energy = "0.7*dot(w[i], w[j])"
"""
AXIS = """[effects.axis]
over = "site(i) of w"
energy = "-0.3*w[i].z^2 + 0.2*w[i].x"
"""
CHAIN = """[effects.bonds]
over = "bond(i, j) of chain(n, periodic)"
energy = "-0.9*dot(w[i], w[j])"
"""
Z, X = np.array([0, 0, 1]), np.array([1, 0, 0])


def neighbours(m):
    return np.roll(m, 1, 0) + np.roll(m, -1, 0)


# name -> (sites, effects, dH/dw)
SYSTEMS = {"axis": (1, AXIS, lambda w: -0.6 * w * Z + 0.2 * X),
           "pairs": (4, PAIRS + AXIS, lambda w: 0.7 * (w.sum(0) - w) - 0.6 * w * Z + 0.2 * X),
           "chain": (16, CHAIN + AXIS, lambda w: -0.9 * neighbours(w) - 0.6 * w * Z + 0.2 * X)}


def spec_of(name, form="gilbert", orientation=1, kappa=1.0, radius=1.0, alpha="alpha", more=""):
    sites, effects, _ = SYSTEMS[name]
    return smidgen.load_text(f"""[model]
name = "damped_{name}"
orientation = {orientation}
[space]
w = {{ sphere = "n", kappa = {kappa}, radius = {radius} }}
[parameters]
n = {sites}
alpha = 0.3
{effects}[effects.bath]
over = "site(k) of w"
damping = "{alpha}"
form = "{form}"
[starts.a]
random = 5
{more}""")


def slope(name, form, o, kappa, radius, alpha, w):
    """w' by the law itself; Gilbert's is solved for w', site by site."""
    gradient = SYSTEMS[name][2]
    b, c = gradient(w) / kappa, np.sign(kappa) * alpha / radius
    precession = o * np.cross(w, b)
    if form == "ll":
        return precession + c * np.cross(w, np.cross(w, b))

    def solved(wi, ti):
        cross = np.array([[0, -wi[2], wi[1]], [wi[2], 0, -wi[0]], [-wi[1], wi[0], 0]])
        return np.linalg.solve(np.eye(3) - o * c * cross, ti)

    return np.array([solved(wi, ti) for wi, ti in zip(w, precession)])


def flow(time, first, *law):
    def rate(t, y):
        return slope(*law, y.reshape(-1, 3)).ravel()
    return solve_ivp(rate, (0, time), first.ravel(), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1].reshape(-1, 3)


def lengths(w):
    return np.sqrt((w * w).sum(-1))


LAWS = [(form, o, kappa, radius) for form in ("gilbert", "ll") for o, kappa, radius in ((1, 1.0, 1.0), (-1, 1.4, 2.0), (1, -0.8, 0.5), (-1, -1.0, 1.0))]


@pytest.mark.parametrize("name", [pytest.param("axis", marks=quick), pytest.param("pairs", marks=quick), "chain"])
@pytest.mark.parametrize("form, o, kappa, radius", LAWS)
def test_order_two_on_the_spheres_to_the_flow_of_the_law(name, form, o, kappa, radius):
    """Three systems, both orientations, both signs of kappa, three radii; the energy has fallen."""
    one = build(spec_of(name, form, o, kappa, radius))
    errors = []
    for steps in (40, 80):
        one.start("a", h=1.5 / steps)
        first, before = one.w.copy(), one.energy()
        one.steps(steps)
        errors.append(np.abs(one.w - flow(1.5, first, name, form, o, kappa, radius, 0.3)).max())
        assert one.energy() < before
        assert np.abs(lengths(one.w) / radius - 1).max() < 2e-15
    assert 1.9 < np.log2(errors[0] / errors[1]) < 2.1


@pytest.mark.parametrize("method", [pytest.param(m, marks=() if m in ("cf4", "gauss-4", "dop853", "spherical-midpoint-4") else pytest.mark.long)
                                    for m in METHODS if METHODS[m].responds and not METHODS[m].variant])
def test_every_method_that_takes_damping_goes_to_the_same_end(method):
    one, errors = build(spec_of("pairs"), method=method), []
    for steps in (20, 40):
        one.start("a", h=2 / steps)
        first = one.w.copy()
        one.steps(steps)
        errors.append(np.abs(one.w - flow(2, first, "pairs", "gilbert", 1, 1.0, 1.0, 0.3)).max())
    assert errors[1] < 3e-13 or np.log2(errors[0] / errors[1]) > METHODS[method].order - 0.25


@quick
@pytest.mark.parametrize("method", [m for m in METHODS if not METHODS[m].responds and METHODS[m].stages == 1])
def test_other_methods_refuse_it_and_name_some_that_do_not(method):
    with pytest.raises(UsageError, match=r"does not support damping \(effect 'bath'\); use spherical-midpoint or|'bath' does not derive from an energy"):
        build(spec_of("axis"), method=method)


@quick
@pytest.mark.parametrize("form, end", [("ll", (-.324168918411657, -.210178428177899, .922355430766515)), ("gilbert", None)])
def test_damped_precession_in_closed_form(form, end):
    """One spin in a field along z: w_z = tanh(alpha g t + atanh w_z0), phi = g t, g = 1 or 1/(1 + alpha^2); at t = 10 from theta = 1."""
    spec = smidgen.load_text('[model]\nname = "spin"\n[space]\nw = { sphere = 1 }\n[effects.field]\nover = "site(i) of w"\nenergy = "-w[i].z"\n'
                             f'[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\nform = "{form}"\n[starts.a]\ntheta = 1\nphi = 0\n')
    g = 1 if form == "ll" else 1 / 1.01
    height = np.tanh(0.1 * g * 10 + np.arctanh(np.cos(1)))
    exact = np.array([*np.sqrt(1 - height**2) * np.array([np.cos(10 * g), np.sin(10 * g)]), height])
    if end:
        assert np.abs(exact - end).max() < 1e-14
    errors = [np.abs(build(spec).start("a", h=h).steps(round(10 / h)).w - exact).max() for h in (0.1, 0.05)]
    assert errors[1] < 1e-3 and 1.95 < np.log2(errors[0] / errors[1]) < 2.05
    if form == "ll":
        assert np.abs(build(spec).start("a", h=0.1).steps(100).w - [-.32533220334546, -.20938603546176, .92212604649256]).max() < 1e-13


def test_large_steps_of_a_single_sphere_are_those_of_one_beside_another():
    """What it has in closed form is found as all else is; where a step is none, both say so."""
    own = """[effects.own]
over = "site(i) of w"
energy = "0.7*w[i].x^2 - w[i].y^2/2 + 0.3*w[i].x*w[i].z^2 + 0.4*w[i].z"
"""
    text, dice, counts = spec_of("axis", "ll").sources[0][1].replace(AXIS, own), np.random.default_rng(1), {True: 0, False: 0}
    one, two = (build(smidgen.load_text(text.replace("\nn = 1", f"\nn = {n}"))) for n in (1, 2))
    for case in range(450):
        w, h = dice.normal(size=(1, 3)), dice.uniform(0.3, 5)
        for model in (one, two):
            model.set_parameters({"alpha": (0.3, 1.0, 3.0)[case % 3]}).start(np.repeat(w / np.linalg.norm(w), model.sites, 0), h=h).advance(1)
        assert one.count == two.count and np.abs(one.w[0] - two.w[0]).max() < 1e-12
        counts[one.count == 1] += 1
    assert min(counts.values()) > 4


@quick
@pytest.mark.parametrize("method", ["spherical-midpoint", "classical-midpoint", "gauss-4", "dop853"])
def test_a_body_in_r3_ends_about_its_axis_of_least_energy(method):
    """Double bracket dissipation, w' = w x b + alpha w x (w x b): |w| stays, H falls; after a short time it is where the law has brought it."""
    spec = smidgen.load_text('[model]\nname = "satellite"\n[space]\nw = { r3 = 1 }\n[effects.body]\nenergy = "w.x^2/2 + w.y^2/4 + w.z^2/8"\n'
                             '[effects.slosh]\nover = "site(i) of w"\ndamping = 0.2\n[starts.a]\nvectors = [[1.0, 2.0, 0.5]]\n')
    one, axes = build(spec, method=method).start("a", h=0.01), np.array([1, 1 / 2, 1 / 4])
    first, energies = one.w.copy(), [one.energy()]

    def rate(t, w):
        across = np.cross(w, axes * w)
        return across + 0.2 * np.cross(w, across)
    exact = solve_ivp(rate, (0, 2), first[0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    one.steps(200)
    assert np.abs(one.w[0] - exact).max() < (2e-3 if METHODS[method].order == 2 else 1e-7)
    for _ in range(20):
        energies.append(one.steps(200).energy())
    assert np.all(np.diff(energies)[:8] < 0) and np.diff(energies).max() < 1e-12 and abs(energies[-1] - (first**2).sum() / 8) < 1e-3
    assert np.abs(lengths(one.w) / lengths(first) - 1).max() < (1e-14 if METHODS[method].keeps_leaf else 1e-10)


@quick
def test_a_damping_by_site_acts_at_its_site():
    """alpha(k) = 0.1 k: the spin without damping keeps its height in the field."""
    text = ('[model]\nname = "row"\n[space]\nw = { sphere = 3 }\n[effects.field]\nover = "site(i) of w"\nenergy = "-w[i].z"\n'
            '[effects.bath]\nover = "site(k) of w"\ndamping = "0.1*k"\nform = "ll"\n[starts.a]\ntheta = "1"\nphi = "0.3*i"\n')
    exact = np.tanh(0.1 * np.arange(3) * 5 + np.arctanh(np.cos(1)))
    errors = [np.abs(build(smidgen.load_text(text)).start("a", h=5 / steps).steps(steps).w[:, 2] - exact) for steps in (250, 500)]
    assert errors[0][0] < 1e-14 and np.abs(errors[0][1:] / errors[1][1:] - 4).max() < 0.01 and errors[1].max() < 1e-5


@quick
def test_the_witness_has_the_same_law():
    """Its vector field beside the one of this file, and its derivative beside differences."""
    for form, o, kappa, radius in LAWS:
        one = Witness(spec_of("pairs", form, o, kappa, radius))
        w = np.random.default_rng(3).normal(size=(4, 3))
        w *= radius / lengths(w)[:, None]
        assert np.abs(one.vector_field(w) - slope("pairs", form, o, kappa, radius, 0.3, w)).max() < 1e-14
        matrix, _ = one.jacobian(w)
        v = np.random.default_rng(4).normal(size=w.shape)
        gap = (one.vector_field(w + 1e-5 * v) - one.vector_field(w - 1e-5 * v)) / 2e-5
        assert np.abs(matrix @ v.ravel() - gap.ravel()).max() < 1e-8


@quick
@pytest.mark.parametrize("name, method", [("pairs", "spherical-midpoint"), ("chain", "spherical-midpoint"), ("pairs", "gauss-4")])
def test_what_a_scene_does_not_call_for_leaves_nothing(name, method):
    """Left out by name, it gives the C of a spec that never had it, byte for byte but for the spec's own digest."""
    with_it = spec_of(name)
    text = with_it.sources[0][1]
    without = smidgen.load_text(text[:text.index("[effects.bath]")] + text[text.index("[starts.a]"):])
    one, other = (replace(select(spec, [e.name for e in without.effects]), digest="") for spec in (with_it, without))
    assert generate(one, method) == generate(other, method) != generate(with_it, method)


@quick
def test_a_scene_of_damping_alone_is_refused():
    spec = spec_of("axis")
    with pytest.raises(UsageError, match="damping alone moves nothing: add an energy, such as axis"):
        build(spec, effects=["bath"])
    with pytest.raises(UsageError, match="no effect `bat`"):
        build(spec, effects=["axis", "bat"])


@quick
def test_a_restart_has_the_bits_of_the_unbroken_run():
    one, other = build(spec_of("chain")).start("a", h=0.1), build(spec_of("chain"))
    one.steps(7)
    saved = one.save()
    other.start("a", h=0.1).restore(saved)
    assert np.array_equal(one.steps(50).w, other.steps(50).w)


@pytest.mark.parametrize("name", ["axis", "pairs"])
def test_members_of_an_ensemble_have_their_own_damping_and_the_bits_that_they_have_alone(name):
    spec, alphas = spec_of(name), np.array([0.0, 0.1, 0.4, 1.0, 0.05, 0.2, 0.3, 0.7, 0.9])
    found = smidgen.ensemble(spec, start="a", h=0.1, steps=30, parameters={"alpha": alphas})
    for k, alpha in enumerate(alphas):
        assert np.array_equal(build(spec, parameters={"alpha": float(alpha)}).start("a", h=0.1).steps(30).w, found.w[k])


def test_threads_and_single_rows_give_the_same_bits():
    """A cubic lattice by rows, on one thread and on two; and the same motion from site to site to round-off."""
    text = """[model]
name = "cube"
[space]
w = { sphere = "n*n*n" }
[parameters]
n = 12
alpha = 0.2
[effects.exchange]
over = "bond(i, j) of cubic(n, n, n, periodic)"
energy = "-dot(w[i], w[j])"
[effects.bath]
over = "site(i) of w"
damping = "alpha"
[starts.a]
random = 2
"""
    spec = smidgen.load_text(text)
    by_rows = build(spec).start("a", h=0.05).steps(30).w
    assert np.array_equal(by_rows, build(spec, threads=2).start("a", h=0.05).steps(30).w)
    by_sites = build(smidgen.load_text(text.replace('"alpha"', '"alpha + 0*i"'))).start("a", h=0.05).steps(30).w
    assert np.abs(by_rows - by_sites).max() < 1e-13


@quick
def test_reports_say_what_is_given_up():
    """run, explain and verify."""
    spec = spec_of("pairs", more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 200\n')
    found = smidgen.run(spec)
    assert set(found.summary["errors"]) == {"casimirs"} and set(found.summary["changes"]) == {"energy", "momentum"}
    words = " ".join(smidgen.explain(spec).words())
    assert "The sites of w are damped: no step is symplectic" in words and "preserved exactly" in words and "energy is conserved by" not in words
    assert [i.kind for i in smidgen.explain(spec).integrals] == ["casimir"]


def test_its_certificate_passes(few_states):
    spec = spec_of("pairs", more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 200\n')
    found = smidgen.verify(spec, tier="quick")
    found.check()
    assert {name: found.row(name).note for name in ("symplectic", "energy")} == {"symplectic": "damped sites lose area", "energy": "damped sites lose energy"}


@pytest.mark.parametrize("compiler, real", [("gcc", "double"), ("clang++", "long double"), *(pytest.param(c, r, marks=pytest.mark.long) for c in COMPILERS for r in REALS)])
@pytest.mark.parametrize("name, features", [("axis", ("ensemble",)), ("pairs", ("tangent",)), ("chain", ())])
def test_no_compiler_complains(tmp_path, name, features, compiler, real):
    """A single sphere and its ensemble, few in lanes and Newton, a chain by rows."""
    if compiler not in COMPILERS:
        pytest.skip("no such compiler")
    files = generate(spec_of(name, alpha="0.1" if name == "chain" else "alpha"), features=features)
    write_files(files, tmp_path)
    how = OPTIMISED if compiler == "gcc" else READ
    assert not compile_all(tmp_path, [f for f in files if f.endswith(".c")], compiler, real=real, how=how)
