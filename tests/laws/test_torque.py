"""Torques: the motion is that of the law, at the order of the method, on the spheres, and absent where a scene does not call for it.

    w' = o w x b + T(w, neighbours, t),   T tangent;  under Gilbert's damping T -> (T + o s (alpha/r) w x T)/(1 + alpha^2), T all torques together
"""
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.strict import COMPILERS, OPTIMISED, READ, compile_all

import smidgen
from smidgen.build.binary import write_files
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.effects.torque import Torque, closed
from smidgen.compile.select import select
from smidgen.errors import SpecError, UsageError
from smidgen.methods import METHODS
from smidgen.run.step.integrator import build

quick = pytest.mark.quick
LAWS = [(form, o, kappa, radius) for form in (None, "gilbert", "ll") for o, kappa, radius in ((1, 1.0, 1.0), (-1, 1.4, 2.0), (1, -0.8, 0.5), (-1, -1.0, 1.0))]
P = np.array([0.3, -0.2, 0.9])


def lengths(w):
    return np.sqrt((w * w).sum(-1))


def spec_of(effects, sites, form=None, o=1, kappa=1.0, radius=1.0, alpha=0.3, more="", start="random = 5", factor="sphere"):
    bath = f'[effects.bath]\nover = "site(k) of w"\ndamping = "alpha"\nform = "{form}"\n' if form else ""
    size = f", radius = {radius}" if factor == "sphere" else ""
    return smidgen.load_text(f"""[model]
name = "pushed"
orientation = {o}
[space]
w = {{ {factor} = "n", kappa = {kappa}{size} }}
[parameters]
n = {sites}
alpha = {alpha}
tau = 0.15
p = {{ default = {P.tolist()}, vector = true }}
{effects}{bath}[starts.a]
{start}
{more}""")


def effect(name, over, key, formula, on=""):
    return f'[effects.{name}]\nover = "{over}"\n{key} = "{formula}"\n' + (f'on = "{on}"\n' if on else "")


# -- Slonczewski's torque in closed form --------------------------------------------------------

def spin(form, o, kappa, radius, alpha, tau, torque="tau/R*cross(w[i], cross(w[i], vec(0, 0, 1)))"):
    """In a field along z about which it turns with the frequency 1, whatever its strength is."""
    return spec_of(effect("field", "site(i) of w", "energy", f"-{o * kappa}*w[i].z") + effect("current", "site(i) of w", "torque", torque.replace("R", str(radius)).replace("tau", str(tau))),
                   1, form, o, kappa, radius, alpha, start="theta = 1\nphi = 0")


def height(form, o, kappa, alpha, tau, time):
    g = 1 / (1 + alpha**2) if form == "gilbert" else 1
    return np.tanh(g * ((alpha * o * np.sign(kappa) if form else 0) - tau) * time + np.arctanh(np.cos(1)))


@quick
@pytest.mark.parametrize("form, o, kappa, radius", LAWS)
@pytest.mark.parametrize("torque", ["tau/R*cross(w[i], cross(w[i], vec(0, 0, 1)))", "tau*(w[i]*w[i].z/R - R*vec(0, 0, 1))"])
def test_slonczewski_in_closed_form(form, o, kappa, radius, torque):
    """w_z = tanh(g (alpha lam - tau) t + atanh w_z0), g = 1 or 1/(1 + alpha^2); as a turn in closed form, and tangent on the sphere alone, so by Newton."""
    spec = spin(form, o, kappa, radius, 0.1, 0.25, torque)
    assert (closed(spec.of(Torque)[0], spec) is not None) == torque.startswith("tau/R")
    one, errors = build(spec), []
    for h in (0.1, 0.05):
        one.start("a", h=h).steps(round(5 / h))
        errors.append(abs(one.w[0, 2] / radius - height(form, o, kappa, 0.1, 0.25, 5)))
        assert abs(lengths(one.w)[0] / radius - 1) < 1e-15
    assert errors[1] < 1e-3 and 1.97 < np.log2(errors[0] / errors[1]) < 2.03


@quick
@pytest.mark.parametrize("form", ["gilbert", "ll"])
@pytest.mark.parametrize("alpha", [0.1, 1e-8, 10.0])
def test_at_slonczewskis_threshold_a_spin_keeps_its_height(form, alpha):
    """tau = alpha lam; a little less and damping wins, a little more and the current does."""
    ends = [build(spin(form, 1, 1.0, 1.0, alpha, part * alpha)).start("a", h=0.1).steps(200).w[0, 2] - np.cos(1) for part in (1, 0.5, 1.5)]
    assert abs(ends[0]) < 1e-14 and ends[1] > 0 > ends[2]


@pytest.mark.parametrize("form", ["gilbert", "ll"])
@pytest.mark.parametrize("scheme, order", [("spherical-midpoint-4", 4), ("spherical-midpoint-6", 6), ("gauss-4", 4)])
def test_higher_orders_reach_it_at_their_order(form, scheme, order):
    one, errors = build(spin(form, -1, -1.4, 2.0, 0.1, 0.25), method=scheme), []
    for h in (0.5, 0.25):
        one.start("a", h=h).steps(round(5 / h))
        errors.append(abs(one.w[0, 2] / 2 - height(form, -1, -1.4, 0.1, 0.25, 5)))
    assert np.log2(errors[0] / errors[1]) > order - 0.2


# -- A wall under Zhang and Li's torque ---------------------------------------------------------

def wall(alpha, beta, form="gilbert", u=0.05):
    """K = J/16: the wall is sqrt(8) cells wide. D, the central difference, is that of two bonds, each of which moves one of its ends."""
    ahead, behind = "cross(w[i], cross(w[i], u/2*w[j])) + cross(w[i], beta*u/2*w[j])", "-cross(w[i], cross(w[i], u/2*w[j])) - cross(w[i], beta*u/2*w[j])"
    said = [text.replace("beta", str(beta)).replace("u/2", str(u / 2)) for text in (ahead, behind)]
    chain = "chain(n, open)"
    return spec_of(effect("exchange", f"bond(i, j) of {chain}", "energy", "-dot(w[i], w[j])") + effect("axis", "site(i) of w", "energy", "-w[i].z^2/16")
                   + effect("ahead", f"bond(i, j) of {chain}", "torque", said[0]) + effect("behind", f"bond(j, i) of {chain}", "torque", said[1], "w[i]"),
                   80, form, alpha=alpha, start='theta = "2*atan(exp((i - 30)/sqrt(8)))"\nphi = 0.3')


def of_wall(one):
    """(where it is, its azimuth)."""
    z = one.w[:, 2]
    k = np.flatnonzero((z[:-1] > 0) & (z[1:] <= 0))[0]
    return k + z[k] / (z[k] - z[k + 1]), np.arctan2(one.w[:, 1].sum(), one.w[:, 0].sum())


@pytest.mark.parametrize("alpha, beta, form, speed, rate", [(0.1, 0.1, "gilbert", 0.979, 0), (0.1, 0.0, "gilbert", 0.969, -1.741e-3), (0.1, 0.2, "gilbert", 0.988, 1.741e-3),
                                                            (0.1, 0.0, "ll", 0.979, 0)])
def test_a_wall_is_carried_by_the_current_and_turns_where_beta_is_not_alpha(alpha, beta, form, speed, rate):
    """At the rate (beta - alpha) u/(d (1 + alpha^2)), 1.750e-3 here of a wall in the continuum; for damping of Landau and Lifshitz, which leaves torques
    alone, beta = 0 is what beta = alpha is for Gilbert's."""
    one = build(wall(alpha, beta, form)).start("a", h=0.2).steps(200)
    first, (place, azimuth) = one.t, of_wall(one)
    one.steps(600)
    time, (there, turned) = one.t - first, of_wall(one)
    assert abs((there - place) / time / 0.05 - speed) < 2e-3 and abs((turned - azimuth) / time - rate) < 1e-5
    assert abs(rate) < 1e-9 or abs((turned - azimuth) / time / ((beta - alpha) * 0.05 / (np.sqrt(8) * (1 + alpha**2))) - 1) < 0.012
    assert np.abs(lengths(one.w) - 1).max() < 1e-15


# -- Torques of every kind beside a library's integrator ----------------------------------------

FIELD = effect("axis", "site(i) of w", "energy", "-0.3*w[i].z^2 + 0.2*w[i].x")
PAIRS = effect("pairs", "pair(i, j) of w", "energy", "0.7*dot(w[i], w[j])") + FIELD
CHAIN = effect("bonds", "bond(i, j) of chain(n, periodic)", "energy", "-0.9*dot(w[i], w[j])") + FIELD
SQUARE = effect("bonds", "bond(i, j) of square(4, 4, periodic)", "energy", "-0.9*dot(w[i], w[j])") + FIELD
Z, X = np.array([0, 0, 1]), np.array([1, 0, 0])
OWN = -0.15 * np.array([0.2, 1.0, -1.0])


def own(w):
    return -0.6 * w * Z + 0.2 * X


def neighbours(m):
    return np.roll(m, 1, 0) + np.roll(m, -1, 0)


def ahead_in_square(w):
    """The neighbours at the ends of the bonds that begin at each site."""
    grid = w.reshape(4, 4, 3)
    return (np.roll(grid, -1, 0) + np.roll(grid, -1, 1)).reshape(-1, 3)


def around_in_square(w):
    grid = w.reshape(4, 4, 3)
    return sum(np.roll(grid, s, a) for s in (1, -1) for a in (0, 1)).reshape(-1, 3)


STEADY = effect("current", "site(i) of w", "torque", "tau*(1 + 0.2*cos(t))*cross(w[i], cross(w[i], p)) + cross(w[i], 0.1*i*p)")
HARD = (effect("lossy", "site(i) of w", "torque", "-tau*cross(w[i], cross(w[i], vec(0.2*w[i].x, w[i].y, -w[i].z)))")
        + effect("shaken", "site(i) of w", "torque", "tau*dot(w[i], p)*cross(w[i], p)*(1 + 0.3*sin(t))"))
AHEAD = effect("ahead", "bond(i, j) of {}", "torque", "0.2*cross(w[i], cross(w[i], w[j])) + 0.1*cross(w[i], w[j])")


def steady(t, w):
    return 0.15 * (1 + 0.2 * np.cos(t)) * np.cross(w, np.cross(w, P)) + np.cross(w, 0.1 * np.arange(len(w))[:, None] * P)


def hard(t, w):
    return np.cross(w, np.cross(w, OWN * w)) + 0.15 * (w @ P)[:, None] * np.cross(w, P) * (1 + 0.3 * np.sin(t))


# name -> (sites, effects, dH/dw, torque(t, w))
SYSTEMS = {"one": (1, FIELD + HARD, own, hard), "closed": (4, PAIRS + STEADY, lambda w: 0.7 * (w.sum(0) - w) + own(w), steady),
           "few": (4, PAIRS + HARD, lambda w: 0.7 * (w.sum(0) - w) + own(w), hard),
           "chain": (16, CHAIN + AHEAD.format("chain(n, periodic)") + HARD, lambda w: -0.9 * neighbours(w) + own(w),
                     lambda t, w: 0.2 * np.cross(w, np.cross(w, np.roll(w, -1, 0))) + 0.1 * np.cross(w, np.roll(w, -1, 0)) + hard(t, w)),
           "square": (16, SQUARE + AHEAD.format("square(4, 4, periodic)"), lambda w: -0.9 * around_in_square(w) + own(w),
                      lambda t, w: 0.2 * np.cross(w, np.cross(w, ahead_in_square(w))) + 0.1 * np.cross(w, ahead_in_square(w))),
           "alone": (3, STEADY, lambda w: 0 * w, steady)}


def named(name, form=None, o=1, kappa=1.0, radius=1.0, more=""):
    return spec_of(SYSTEMS[name][1], SYSTEMS[name][0], form, o, kappa, radius, more=more)


def slope(name, form, o, kappa, radius, t, w):
    """w' by the law itself; Gilbert's is solved for w', site by site."""
    _, _, gradient, torque = SYSTEMS[name]
    b, c = gradient(w) / kappa, 0.3 * np.sign(kappa) / radius if form else 0
    moved = o * np.cross(w, b) + torque(t, w)
    if form == "ll":
        return moved + c * np.cross(w, np.cross(w, b))

    def solved(wi, ti):
        cross = np.array([[0, -wi[2], wi[1]], [wi[2], 0, -wi[0]], [-wi[1], wi[0], 0]])
        return np.linalg.solve(np.eye(3) - o * c * cross, ti)
    return np.array([solved(wi, ti) for wi, ti in zip(w, moved)])


def flow(time, first, *law):
    def rate(t, y):
        return slope(*law, t, y.reshape(-1, 3)).ravel()
    return solve_ivp(rate, (0, time), first.ravel(), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1].reshape(-1, 3)


@pytest.mark.parametrize("name", [pytest.param(n, marks=quick if n in ("one", "closed", "few", "alone") else ()) for n in SYSTEMS])
@pytest.mark.parametrize("form, o, kappa, radius", LAWS)
def test_order_two_on_the_spheres_to_the_flow_of_the_law(name, form, o, kappa, radius):
    one, errors = build(named(name, form, o, kappa, radius)), []
    for steps in (40, 80):
        one.start("a", h=1.5 / steps)
        first = one.w.copy()
        one.steps(steps)
        errors.append(np.abs(one.w - flow(1.5, first, name, form, o, kappa, radius)).max())
        assert np.abs(lengths(one.w) / radius - 1).max() < 2e-15
    assert 1.9 < np.log2(errors[0] / errors[1]) < 2.1


@pytest.mark.parametrize("name", ["few", "closed"])
@pytest.mark.parametrize("method", [pytest.param(m, marks=() if m in ("cf4", "gauss-4", "dop853", "spherical-midpoint-4") else pytest.mark.long)
                                    for m in METHODS if METHODS[m].responds and not METHODS[m].variant])
def test_every_method_that_takes_torques_goes_to_the_same_end_and_takes_the_witness_step(name, method):
    one, errors = build(named(name, "gilbert"), method=method), []
    for steps in (20, 40):
        one.start("a", h=2 / steps)
        first = one.w.copy()
        one.steps(steps)
        errors.append(np.abs(one.w - flow(2, first, name, "gilbert", 1, 1.0, 1.0)).max())
    assert errors[1] < 3e-13 or np.log2(errors[0] / errors[1]) > METHODS[method].order - 0.25
    by_hand = Witness(named(name, "gilbert")).step(first, 0.0, 0.05, method)
    assert np.abs(one.start(first.copy(), h=0.05).step().w - by_hand).max() < (1e-13 if METHODS[method].controlled else 2e-15)


@quick
@pytest.mark.parametrize("method", [m for m in METHODS if not METHODS[m].responds and METHODS[m].stages == 1])
def test_other_methods_refuse_them_and_name_some_that_do_not(method):
    for name in ("one", "alone"):
        with pytest.raises(UsageError, match=r"does not support torques \(effect '.*'\); use spherical-midpoint or|does not derive from an energy|does not provide it"):
            build(named(name), method=method)


@pytest.mark.parametrize("name, solver", [("few", "newton"), ("few", "plain"), ("chain", "newton"), ("chain", "rotation"), ("chain", "plain"), ("square", "rotation"), ("square", "plain")])
@pytest.mark.parametrize("h", [0.1, 0.7])
def test_every_solver_finds_the_step(name, solver, h):
    spec = named(name, "gilbert", -1, 1.4, 2.0)
    one = build(spec, solver=solver).start("a", h=h)
    first = one.w.copy()
    found = one.step().w
    slow = max(1, one.report()["iterations"] / 36)      # sweeps that shrink errors by 1 - p take -log(eps)/p, and leave 1/p times what rounding does to one
    assert np.abs(found - Witness(spec).step(first, 0.0, h)).max() < 4e-15 * slow


def test_a_matrix_that_is_not_stored_is_no_more_symmetric():
    """Where sweeps do not settle, GMRES and the curve of solutions find the step of the witness, or say as it does that there is none."""
    spec, found = named("square"), 0
    one, by_hand = build(spec, solver="plain"), Witness(spec)
    for h in (1.5, 2.0, 2.5):
        first = one.start("a", h=h, seed=4).w.copy()
        try:
            one.step()
        except smidgen.RunError:
            assert np.array_equal(one.w, first)
            continue
        found += 1
        assert np.abs(by_hand.residual(first, one.w, 0.0, h)) < 1e-13
    assert found


@quick
@pytest.mark.parametrize("name", ["one", "few", "closed", "chain"])
def test_the_witness_has_the_same_law(name):
    """Its vector field beside the one of this file, and its derivative beside differences."""
    for form, o, kappa, radius in LAWS:
        one = Witness(named(name, form, o, kappa, radius))
        w = np.random.default_rng(3).normal(size=(one.sites, 3))
        w *= radius / lengths(w)[:, None]
        assert np.abs(one.vector_field(w, 0.4) - slope(name, form, o, kappa, radius, 0.4, w)).max() < 1e-14
        matrix, _ = one.jacobian(w, 0.4)
        v = np.random.default_rng(4).normal(size=w.shape)
        gap = (one.vector_field(w + 1e-5 * v, 0.4) - one.vector_field(w - 1e-5 * v, 0.4)) / 2e-5
        assert np.abs(matrix @ v.ravel() - gap.ravel()).max() < 1e-8


@pytest.mark.parametrize("name, solver", [("one", "auto"), ("few", "auto"), ("closed", "auto"), ("chain", "auto"), ("chain", "rotation"), ("square", "rotation")])
def test_the_tangent_map_is_the_derivative_of_the_step(name, solver):
    spec = named(name, "gilbert")
    one = build(spec, solver=solver, features=("tangent",))
    first = one.start("a", h=0.2).w.copy()
    v = np.random.default_rng(5).normal(size=first.shape)
    v -= first * (first * v).sum(1, keepdims=True)
    one.step()
    found, ends = one.tangent(v[None].copy())[0], []
    for sign in (1, -1):
        w = first + sign * 1e-5 * v
        ends.append(Witness(spec).step(w / lengths(w)[:, None], 0.0, 0.2))
    assert np.abs((ends[0] - ends[1]) / 2e-5 - found).max() < 1e-8


# -- Around the step ----------------------------------------------------------------------------

@quick
@pytest.mark.parametrize("name, method", [("few", "spherical-midpoint"), ("chain", "spherical-midpoint"), ("closed", "spherical-midpoint"), ("few", "gauss-4")])
def test_what_a_scene_does_not_call_for_leaves_nothing(name, method):
    """Left out by name, it gives the C of a spec that never had it, byte for byte but for the spec's own digest."""
    with_it = named(name)
    energies = [e.name for e in with_it.energies]
    text = with_it.sources[0][1]
    begin = min(text.index(f"[effects.{t.name}]") for t in with_it.of(Torque))
    without = smidgen.load_text(text[:begin] + text[text.index("[starts.a]"):])
    one, other = (replace(select(spec, energies), digest="") for spec in (with_it, without))
    assert generate(one, method) == generate(other, method) != generate(with_it, method)


@quick
def test_a_restart_has_the_bits_of_the_unbroken_run():
    one, other = build(named("chain")).start("a", h=0.1), build(named("chain"))
    one.steps(7)
    saved = one.save()
    other.start("a", h=0.1).restore(saved)
    assert np.array_equal(one.steps(50).w, other.steps(50).w)


@pytest.mark.parametrize("name", ["one", "few", "closed"])
def test_members_of_an_ensemble_have_their_own_torque_and_the_bits_that_they_have_alone(name):
    spec, taus = named(name, "gilbert"), np.array([0.0, 0.1, 0.4, 1.0, -0.05, 0.2, 0.3, 0.7, 0.9])
    found = smidgen.ensemble(spec, start="a", h=0.1, steps=30, parameters={"tau": taus})
    for k, tau in enumerate(taus):
        assert np.array_equal(build(spec, parameters={"tau": float(tau)}).start("a", h=0.1).steps(30).w, found.w[k])


def test_a_current_that_is_the_same_everywhere_keeps_the_rows():
    """A cubic lattice by rows, on one thread and on two; and the same motion from site to site to round-off."""
    text = """[model]
name = "cube"
[space]
w = { sphere = "n*n*n" }
[parameters]
n = 12
p = { default = [0.0, 0.6, 0.8], vector = true }
[effects.exchange]
over = "bond(i, j) of cubic(n, n, n, periodic)"
energy = "-dot(w[i], w[j])"
[effects.current]
over = "site(i) of w"
torque = "0.2*cross(w[i], cross(w[i], p)) + 0.05*cross(w[i], p)"
[starts.a]
random = 2
"""
    spec = smidgen.load_text(text)
    assert any("define SMG_BY_ROWS" in text for text in generate(spec).values())
    one = build(spec)
    by_rows = one.start("a", h=0.05).steps(30).w
    assert np.array_equal(by_rows, build(spec, threads=2).start("a", h=0.05).steps(30).w)
    by_sites = build(smidgen.load_text(text.replace("0.2*cross", "(0.2 + 0*i)*cross"))).start("a", h=0.05).steps(30).w
    assert np.abs(by_rows - by_sites).max() < 1e-13


def test_in_r3_a_torque_keeps_each_length():
    spec = spec_of(PAIRS + HARD, 3, factor="r3", start="vectors = [[1.0, 2.0, 0.5], [0.1, 0.0, 0.2], [3.0, -1.0, 0.0]]")
    one = build(spec).start("a", h=0.02)
    first = one.w.copy()
    assert np.abs(one.step().w - Witness(spec).step(first, 0.0, 0.02)).max() < 1e-15
    assert np.abs(lengths(one.steps(500).w) / lengths(first) - 1).max() < 1e-14


@quick
def test_reports_say_what_is_given_up():
    """run, explain and verify."""
    spec = named("few", more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 200\n')
    found = smidgen.run(spec)
    assert set(found.summary["errors"]) == {"casimirs"} and set(found.summary["changes"]) == {"energy", "momentum"}
    words = " ".join(smidgen.explain(spec).words())
    assert "Torques move the sites of w" in words and "energy is conserved by" not in words and "lengths are preserved" in words
    assert [i.kind for i in smidgen.explain(spec).integrals] == ["casimir"]


@pytest.mark.parametrize("name", ["few", "closed", "one"])
def test_validate_and_the_certificate_pass(few_states, name):
    spec = named(name, "gilbert" if name == "one" else None, more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 200\n')
    smidgen.validate(spec).check()
    found = smidgen.verify(spec, tier="quick")
    found.check()
    assert found.row("symplectic").note == "damped sites lose area and " * (name == "one") + "torques are not Hamiltonian"


@quick
def test_w_across_the_torque_is_seen_to_vanish_or_said_to_remain():
    """What simplifies to 0 on the sphere passes, however it is written."""
    fine = ["cross(p, w[i])", "w[i]*dot(w[i], p)/4 - p", "p*norm(w[i])^2 - w[i]*dot(p, w[i])", "if(t < 1, cross(w[i], p), cross(w[i], cross(p, w[i]))*exp(w[i].z))",
            "sin(dot(w[i], p))*(w[i]*dot(w[i], p) - 2^2*p)", "vec(-w[i].y, w[i].x, 0)*t"]
    for torque in fine:
        spec_of(FIELD + effect("push", "site(i) of w", "torque", torque), 2, radius=2.0)
    for torque, left in (("tau*p", r"w\[i\].x\*tau\*p\[0\]"), ("w[i]*dot(w[i], p) - p", "3"), ("w[i]", "4")):
        with pytest.raises(SpecError, match=r"E405.*but is .*" + left):
            spec_of(FIELD + effect("push", "site(i) of w", "torque", torque), 2, radius=2.0)


@pytest.mark.parametrize("compiler, real", [("gcc", "double"), ("clang++", "long double")])
@pytest.mark.parametrize("name, features", [("one", ("ensemble",)), ("few", ("tangent",)), ("chain", ()), ("square", ()), ("closed", ())])
def test_no_compiler_complains(tmp_path, name, features, compiler, real):
    if compiler not in COMPILERS:
        pytest.skip("no such compiler")
    files = generate(named(name, "gilbert"), features=features)
    write_files(files, tmp_path)
    how = OPTIMISED if compiler == "gcc" else READ
    assert not compile_all(tmp_path, [f for f in files if f.endswith(".c")], compiler, real=real, how=how)


def test_clang_does_not_complain_of_a_gradient_that_no_step_asks_for(tmp_path):
    """Sites that are alone under a torque that goes by its derivatives, beside others that are coupled."""
    if "clang" not in COMPILERS:
        pytest.skip("no such compiler")
    spec = smidgen.load_text("""[model]
name = "beside"
[space]
x = { sphere = 3 }
z = { sphere = 2 }
""" + effect("own", "site(i) of x", "energy", "x[i].z^2") + effect("push", "site(i) of x", "torque", "cross(x[i], vec(x[i].y, 0, x[i].x^2))")
                             + effect("bond", "pair(i, j) of z", "energy", "dot(z[i], z[j])^2"))
    write_files(files := generate(spec, solver="plain"), tmp_path)
    assert not compile_all(tmp_path, [f for f in files if f.endswith(".c")], "clang")
