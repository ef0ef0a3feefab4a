"""Edges of steps: matrices that are singular, sites at rest, fields that are no numbers, sweeps that find nothing; each with what is left behind."""
import itertools
import sys

import numpy as np
import pytest
import smidgen
from smidgen.errors import RunError
from smidgen.run.step.block import Block
from smidgen.run.step.saved import H
from support import texts
from support.filters import HERE

sys.path.insert(0, str(HERE / "coefficients"))
import compositions as coefficients  # noqa: E402

NO_CONVERGENCE, NO_SOLUTION, NOT_FINITE, SINGULAR = 1, 2, 4, 7
TANGENT = ("tangent",)


def system(name, space, *energies):
    """A spec from the lines of its space and (over, energy) pairs; over "": once."""
    effects = [f"[effects.e{k}]\n" + (f'over = "{over}"\n' if over else "") + f'energy = "{energy}"' for k, (over, energy) in enumerate(energies)]
    return smidgen.load_text("\n".join([f'[model]\nname = "{name}"\n[space]\n{space}', *effects, ""]))


def refused(model, *statuses):
    """The next step fails so, and all that decides later bits stays. Returns the error."""
    saved = model.save()
    with pytest.raises(RunError) as caught:
        model.step()
    assert caught.value.status in statuses and np.array_equal(model.save(), saved)
    return caught.value


def unit(rows):
    rows = np.array(rows, float)
    return rows / np.linalg.norm(rows, axis=1)[:, None]


def generic(sites, seed=4):
    return unit(np.random.default_rng(seed).normal(size=(sites, 3)))


# -- Moser-Veselov ------------------------------------------------------------------------------

MOMENTS = np.array([1.0, 2.0, 4.0])


def divided(spec, w, W, h):
    """The largest component of W - w - (h/q) X(m), m = (w + W)/2, and what stands below the root of q = (1 + sqrt(1 - h^2 |b|^2))/2."""
    m = (w + W) / 2
    below = 1 - (h * h) * np.sum((m / MOMENTS)**2)
    q = (1 + np.sqrt(max(below, 0))) / 2
    return np.abs(W - w - spec.orientation * h / q * np.cross(m, m / MOMENTS)).max(), below


@pytest.mark.parametrize("w", [(0.6, 0.0, 0.8), (0.5, 0.7, -0.5), (0.9, -0.3, 0.3)])
def test_moser_veselov_up_to_the_end_of_its_root(w):
    """Near the end it goes by stages of h; where it has no step the state stays."""
    spec = smidgen.load("free_rigid_body")
    model, w = smidgen.build(spec, method="moser-veselov"), unit([w])
    least = 1.0
    for h in np.arange(0.5, 4, 0.05):
        model.start(w.copy(), h=h)
        try:
            off, below = divided(spec, w, model.step().w, h)
        except RunError as error:
            assert error.status == NO_CONVERGENCE and error.site == 0 and np.array_equal(model.state(), w)
            break
        assert off < 1e-14 and below > 0
        least = below
    else:
        raise AssertionError("the root has no end")
    assert least < 0.2


def test_about_an_axis_the_root_ends_at_the_moment_of_inertia():
    model = smidgen.build(smidgen.load("free_rigid_body"), method="moser-veselov")
    for axis, moment in zip(np.eye(3)[:, None], MOMENTS):
        assert np.array_equal(model.start(axis.copy(), h=0.99 * moment).step().w, axis)
        refused(model.start(axis.copy(), h=1.01 * moment), NO_CONVERGENCE)


# -- singular matrices --------------------------------------------------------------------------

POLE = np.array([[0.0, 0.0, 1.0]])
SADDLE = system("saddle", "w = { sphere = 1 }", ("site(i)", "(w[i].x^2 - w[i].y^2)/2"))
TWO_SADDLES = system("saddles", "w = { sphere = 2 }", ("site(i)", "(w[i].x^2 - w[i].y^2)/2"))
COUPLED = system("coupled_saddle", "w = { sphere = 2 }", ("pair(i, j) of w", "w[i].x*w[j].x - w[i].y*w[j].y"))


@pytest.mark.parametrize("spec", [SADDLE, TWO_SADDLES], ids=lambda s: s.name)
def test_a_rest_whose_matrix_is_singular_has_no_step(spec):
    """At the pole J = I - (h/2) DX has the eigenvalues 1 +- h/2: another branch meets that of rest at h = 2."""
    model, w = smidgen.build(spec), np.tile(POLE, (2 if spec is TWO_SADDLES else 1, 1))
    assert np.array_equal(model.start(w.copy(), h=1.9).step().w, w)
    error = refused(model.start(w.copy(), h=2.0), SINGULAR)
    assert error.site == 0 and error.reached < 1


@pytest.mark.parametrize("spec, solver", [(SADDLE, "auto"), (TWO_SADDLES, "auto"), (COUPLED, "newton"), (COUPLED, "plain")], ids=lambda s: getattr(s, "name", s))
def test_a_singular_step_has_no_tangent_map(spec, solver):
    """The step at rest, then its tangent map for the h at which J is singular there; for any other h there is one."""
    model = smidgen.build(spec, solver=solver, features=TANGENT)
    saved = model.start(np.tile(POLE, (model.sites, 1)), h=1.0).step().save()
    v = np.random.default_rng(1).normal(size=(2, model.sites, 3))
    for h, singular in ((2.0, True), (1.5, False)):
        saved[H] = h
        model.restore(saved)
        carried = v.copy()
        if singular:
            with pytest.raises(RunError) as caught:
                model.tangent(carried)
            assert caught.value.status == SINGULAR and caught.value.site >= 0 and np.array_equal(carried, v)
        else:
            assert np.abs(model.tangent(carried)).max() > np.abs(v).max()
        assert np.array_equal(model.save(), saved)


def test_the_report_is_of_the_site_whose_steps_end_first():
    """Each alone: at the pole J has the eigenvalues 1 +- h (1 + i)/2."""
    spec = system("steeper", "w = { sphere = 3 }", ("site(i)", "if(i == 1, 2, 1)*(w[i].x^2 - w[i].y^2)/2"))
    error = refused(smidgen.build(spec).start(np.tile(POLE, (3, 1)), h=5.0), NO_SOLUTION, SINGULAR, NO_CONVERGENCE)
    assert error.site == 1 and error.reached == pytest.approx(0.2, abs=0.02)


def coupled(sites, over, energy, more="", path=""):
    """Spins of which a[i] and ends[i] say which two are coupled, sites 5 and 6, and that the field of site 6 ends before that of others."""
    a, ends = [0] * sites, [9] * sites
    a[5] = a[6] = ends[6] = 1
    return smidgen.load_text(f"""
[model]
name = "coupled"
[space]
w = {{ sphere = {sites} }}
[parameters]
a = {{ default = {a}, size = {sites} }}
ends = {{ default = {ends}, size = {sites} }}
{more}
[effects.coupling]
over = "{over}"
energy = "{energy}"
""", str(path))


@pytest.mark.parametrize("name, sites, over, graph", [("dense", 8, "pair(i, j) of w", ""), ("band", 64, "bond(i, j) of chain(64, periodic)", ""),
                                                      ("sparse", 64, "edge(i, j) of g", '[graphs.g]\nfile = "edges.csv"')])
def test_a_singular_matrix_names_its_site(tmp_path, name, sites, over, graph):
    """Sites 5 and 6 meet another branch at h = 2; elimination comes to its end with the second of them. The graph: a grid of 8 by 8."""
    (tmp_path / "edges.csv").write_text("".join(f"{k},{k + d}\n" for k in range(64) for d in (1, 8) if k + d < 64 and (d == 8 or k % 8 < 7)))
    spec = coupled(sites, over, "a[i]*a[j]*(w[i].x*w[j].x - w[i].y*w[j].y)", graph, tmp_path / "coupled.toml")
    model = smidgen.build(spec, solver="newton", features=TANGENT)
    assert model.notes["solver"] == name
    saved = model.start(np.tile(POLE, (model.sites, 1)), h=1.0).step().save()
    saved[H] = 2.0
    model.restore(saved)
    with pytest.raises(RunError) as caught:
        model.tangent(np.ones((2, model.sites, 3)))
    assert caught.value.status == SINGULAR and caught.value.site == 6


@pytest.mark.parametrize("solver", ["auto", "newton"])
def test_a_field_that_is_no_number_names_its_site(solver):
    spec = coupled(8, "pair(i, j) of w", "0.1*dot(w[i], w[j])", '[effects.field]\nover = "site(i)"\nenergy = "sqrt(ends[i] - t)*w[i].x"')
    model = smidgen.build(spec, solver=solver).start(generic(8), h=0.1).steps(10)
    assert refused(model, NOT_FINITE).site == 6


def test_steps_by_rows_end_with_their_field():
    """In one call, which takes all that there are."""
    spec = system("ending_rows", "w = { sphere = 64 }", ("bond(i, j) of chain(64, periodic)", "0.3*dot(w[i], w[j])"), ("site(i)", "sqrt(3 - t)*w[i].x"))
    model = smidgen.build(spec).start(generic(64), h=0.1)
    assert model.advance(100) == 30 and model.failure().status == NOT_FINITE
    refused(model, NOT_FINITE)


@pytest.mark.parametrize("h", [1e100, 1e200])
def test_a_ring_has_no_step_of_any_size(h):
    """Where squares of fields overflow, too."""
    error = refused(smidgen.build("heisenberg_chain", parameters={"n": 64}).start(generic(64), h=h), NO_SOLUTION)
    assert error.site >= 0


def test_a_ring_by_the_classical_midpoint_goes_from_site_to_site_where_h_is_large():
    model = smidgen.build("heisenberg_chain", method="classical-midpoint", parameters={"n": 64})
    refused(model.start(generic(64), h=50.0), NO_CONVERGENCE, NO_SOLUTION)
    assert np.abs(model.start(generic(64), h=0.9).step().w - generic(64)).max() > 0.1


def test_more_threads_than_shares():
    size = {"nx": 18, "ny": 18, "nz": 18}
    ends = [smidgen.build("cubic_lattice", parameters=size, threads=threads).start("random", h=0.05).steps(2).save() for threads in (1, 4)]
    assert np.array_equal(*ends)


@pytest.mark.parametrize("h", [0.2, 0.4])
def test_open_ends_beyond_the_bound_of_rows(h):
    """Beside steps from site to site."""
    spec = system("open_box", "w = { sphere = 315 }", ("bond(i, j) of cubic(9, 7, 5, open)", "dot(w[i], w[j]) + 0.5*w[i].x*w[j].x"))
    rows, sites = (smidgen.build(spec, solver=solver).start(generic(315), h=h).step().w for solver in ("auto", "plain"))
    assert np.abs(rows - sites).max() < 1e-11


@pytest.mark.parametrize("up", [1, -1])
def test_a_spin_on_the_top_that_a_torque_takes_away(up):
    """W - w = h m x (m x e), e along the top: from h = 2 on the spin could as well be anywhere; at the bottom it stays."""
    spec = system("driven", "w = { sphere = 2 }", ("", "w[1].x"))
    spec = smidgen.load_text(spec.sources[0][1] + f'[effects.current]\nover = "site(i) of w"\ntorque = "{up}*cross(w[i], cross(w[i], vec(0, 0, 1)))"\n')
    model, w = smidgen.build(spec), unit([[0, 0, up], [0.6, 0, 0.8]])
    assert np.array_equal(model.start(w.copy(), h=1.999).step().w[0], w[0])
    for h in (2.0, 2.5):
        error = refused(model.start(w.copy(), h=h), NO_SOLUTION)
        assert error.site == 0 and error.reached == pytest.approx(2 / h, abs=1e-12)
        w[0] = -w[0]
        assert np.array_equal(model.start(w.copy(), h=h).step().w[0], w[0])
        w[0] = -w[0]


@pytest.mark.parametrize("name", ["free_rigid_body", "point_vortices"])
def test_a_composed_tangent_map_that_is_no_number(name):
    """What stages had moved goes back."""
    spec = smidgen.load(name)
    model = smidgen.build(spec, method="spherical-midpoint-4", features=TANGENT).start(spec.runs[0].start, h=0.1).steps(2)
    saved, v = model.save(), np.ones((1, model.sites, 3))
    v[0, -1, 2] = np.nan
    with pytest.raises(RunError) as caught:
        model.tangent(v)
    assert caught.value.status == NOT_FINITE and np.array_equal(model.save(), saved)
    assert np.isfinite(model.tangent(np.ones((1, model.sites, 3)))).all()


# -- sites at rest ------------------------------------------------------------------------------

BODIES = system("bodies", "w = { r3 = 2 }", ("site(i)", "w[i].x^2/2 + w[i].y^2/3 + 0.2*w[i].z"), ("pair(i, j) of w", "0.4*dot(w[i], w[j]) + 0.1*w[i].x*w[j].y"))


@pytest.mark.parametrize("method, features", [("spherical-midpoint", ()), ("spherical-midpoint", ("extended",)), ("geodesic-midpoint", ()), ("rattle", ()), ("gauss-4", ()), ("heun", ()),
                                              ("dop853-projected", ())])
@pytest.mark.parametrize("site", [0, 1])
def test_a_body_at_rest_stays_among_others(method, features, site):
    """A point is a leaf of its own: no direction, no length to keep; the other body keeps its length."""
    w = np.array([[0.3, -0.4, 1.2], [-0.5, 0.7, 0.1]])
    w[site] = 0
    model = smidgen.build(BODIES, method=method, features=features).start(w.copy(), h=0.2).steps(20)
    assert not model.w[site].any()
    assert np.linalg.norm(model.w[1 - site]) == pytest.approx(np.linalg.norm(w[1 - site]), rel=1e-15)
    assert np.abs(model.w[1 - site] - w[1 - site]).max() > 0.1


def test_an_axis_without_a_term_turns_nothing():
    """Beside a term of strength 0 about it."""
    ends = []
    for more in ("", " + a*w[i].y^2"):
        spec = smidgen.load_text(f'[model]\nname = "axes"\n[space]\nw = {{ sphere = 2 }}\n[parameters]\na = 0.0\n'
                                 f'[effects.own]\nover = "site(i)"\nenergy = "w[i].x^2/2 + w[i].z/3{more}"\n')
        ends.append(smidgen.build(spec, method="axis-splitting").start(generic(2), h=0.1).steps(20).state())
    assert np.abs(ends[0] - ends[1]).max() < 1e-14 and np.abs(ends[0] - generic(2)).max() > 0.1


def test_beside_a_body_at_rest_no_column_is_carried():
    """At w = 0 the method of R^3 has no derivative, whichever site it is."""
    model = smidgen.build(BODIES, features=TANGENT).start(np.array([[0, 0, 0], [-0.5, 0.7, 0.1]]), h=0.2).step()
    with pytest.raises(RunError) as caught:
        model.tangent(np.ones((2, 3)))
    assert caught.value.status == SINGULAR and caught.value.site == 0


# -- the last evaluation in extended precision ----------------------------------------------------

needs_long_double = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 60, reason="long double is no longer than double")


DYADIC = system("dyadic", "w = { r3 = 2 }", ("site(i)", "w[i].x^2/2 + w[i].y^2/4 + w[i].z/8"), ("pair(i, j) of w", "dot(w[i], w[j])/2 + w[i].x*w[j].y/8"))


@needs_long_double
@pytest.mark.parametrize("spec, w", [(smidgen.load("nambu_a39"), [[0.9, -0.4, 0.7]]), (DYADIC, [[0.3, -0.4, 1.2], [-0.5, 0.7, 0.1]])], ids=["nambu", "r3"])
def test_a_step_has_the_digits_of_long_double(spec, w):
    """w + compensation beside the step of the long-double build: much less than what a plain step is off by. No sphere, to which each build would
    bring the start by its own rounding."""
    w, off = np.array(w), {}
    exact = smidgen.build(spec, real="long double").start(w.astype(np.longdouble), h=0.1).step().state()
    for features in ((), ("extended",)):
        model = smidgen.build(spec, features=features).start(w.copy(), h=0.1).step()
        saved = model.save().astype(np.longdouble)
        found = saved[11:11 + w.size] + saved[11 + w.size:11 + 2 * w.size]
        off[features] = float(np.abs(found - exact.ravel()).max())
    assert off["extended",] < 2e-18 * np.abs(w).max() and off["extended",] < off[()] / 10


def test_at_any_step_it_is_the_same_step():
    """Steps whose series falls fast, slowly and not at all: the state is that of the step without it, to round-off."""
    spec = smidgen.load("heisenberg_chain")
    plain, extended = (smidgen.build(spec, parameters={"n": 12}, features=features) for features in ((), ("extended",)))
    for h in np.arange(0.1, 1.6, 0.1):
        w = generic(12, 7)
        states = [model.start(w.copy(), h=h).steps(3).w for model in (plain, extended)]
        assert np.abs(states[0] - states[1]).max() < 1e-13


def test_where_products_overflow_the_step_is_as_without(monkeypatch):
    """Pairs of doubles: the square of |w| = 1e150 cannot be split; the increment stays what it was."""
    monkeypatch.setenv("CC", "gcc -DSMG_DOUBLE_DOUBLE")
    spec = system("enormous", "w = { r3 = 1 }", ("site(i)", "w[i].x/2 + w[i].y/3 + w[i].z/5"))
    w = np.array([[1e150, -1e150, 0.5e150]])
    plain, extended = (smidgen.build(spec, features=features).start(w.copy(), h=0.3).step().w for features in ((), ("extended",)))
    assert np.isfinite(extended).all() and np.abs(plain - extended).max() <= 1e-15 * np.abs(w).max()
    assert np.abs(extended - w).max() > 0.05 * np.abs(w).max()


# -- stages, fields that are no numbers -----------------------------------------------------------

def late_stage(scheme="ss21", least=9):
    """(number of a stage whose middle lies later than those of all before, a time between), h = 1."""
    half = [float(x) for x in coefficients.coefficients(scheme)]
    gammas = [*half, 1 - 2 * sum(half), *half[::-1]]
    ends = np.cumsum(gammas)
    middles = ends - np.array(gammas) / 2
    k = next(k for k in range(least, len(middles)) if middles[k] > middles[:k].max())
    return k, float(middles[k] + middles[:k].max()) / 2


def test_a_stage_that_fails_late_leaves_no_trace():
    """The field is no number from the tenth stage or so on: more increments of this step have come than the history keeps."""
    stage, end = late_stage()
    assert stage > 8
    spec = system("ending", "w = { sphere = 3 }", ("pair(i, j) of w", "0.3*dot(w[i], w[j])"), ("", f"sqrt({end + 1!r} - t)*w[0].x/10"))
    model = smidgen.build(spec, method="spherical-midpoint-8").start(generic(3), h=0.125).steps(8)     # up to t = 1
    saved = model.save()
    saved[H] = 1.0
    saved[2] -= 8 - 1.0         # t0: the eight steps were of this h, and time is the same
    model.restore(saved)
    assert model.t == 1.0
    assert refused(model, NOT_FINITE).site >= 0


def test_outputs_end_where_a_step_fails():
    """At whichever step between two outputs that is; what was put out before stands."""
    growing = system("growing", "w = { sphere = 1 }", ("site(i)", "exp(400*t)*w[i].z^2"))
    w = unit([[0.6, 0.0, 0.8]])
    for method in ("spherical-midpoint", "classical-midpoint"):         # the first looks for midpoints near the centre
        model = smidgen.build(growing, method=method).start(w.copy(), h=1.0, t0=-4.0)
        taken, block = model.advance(20), Block(model, True)
        assert 1 < taken < 20
        for every in (1, 2, 3, 4):
            model.start(w.copy(), h=1.0, t0=-4.0)
            done = model.outputs(0, every, block, 0, 15)
            assert done == 1 + taken // every and model.count == taken and model.failure() is not None
            assert np.array_equal(block.t[:done], -4.0 + every * np.arange(done))
            assert np.array_equal(block.states[0], w)


@pytest.mark.parametrize("kappa", ["1e-30", "1e-150"])
def test_an_error_too_large_to_be_squared(kappa):
    """Steps of it are refused until none is left to try."""
    spec = system("strong", f"w = {{ r3 = 2, kappa = {kappa} }}", ("site(i)", "1e150*(w[i].x^2 + 2*w[i].y^2)"), ("pair(i, j) of w", "dot(w[i], w[j])"))
    model = smidgen.build(spec, method="dop853").start(generic(2), h=1.0)
    before = model.state()
    with pytest.raises(RunError):
        model.step()
    assert np.array_equal(model.state(), before) and model.count == 0


@pytest.mark.parametrize("method", ["isospectral-midpoint", "heun"])
def test_a_rotation_too_large_to_be_squared(method):
    """tau^2 overflows: the slope is a number, the increment none."""
    spec = system("fields", "w = { sphere = 2 }", ("site(i)", "0.3*w[i].z + 0.1*w[i].x"))
    model = smidgen.build(spec, method=method)
    assert refused(model.start(generic(2), h=1e200), NOT_FINITE).site == 0
    model.start(generic(2), h=1e100).step()


@pytest.mark.parametrize("method, beyond", [("gauss-4", 158.3), ("geodesic-midpoint", 158.3), ("rattle", 150)])
def test_beside_products_that_overflow_nothing_has_settled(method, beyond):
    """Around 10^158 the products in a sweep overflow before, with or after what it changes."""
    model = smidgen.build(system("diagonal", "w = { sphere = 2 }", ("site(i)", "1e150*(w[i].x + w[i].y + w[i].z)")), method=method)
    for power in np.arange(157.6, 158.5, 0.02):
        refused(model.start(generic(2), h=10**power), NOT_FINITE, *([NO_CONVERGENCE] if power < beyond else []))


def edge(law, more=""):
    """Two spins; at x = c the field of the first ends or jumps."""
    return smidgen.load_text(f"""
[model]
name = "edge"
[space]
w = {{ sphere = 2 }}
[parameters]
nothing = {{ default = 0.0 }}
c = {{ default = 9.0 }}
s = {{ default = 1.0 }}
[effects.own]
over = "site(i)"
energy = "0.35*w[i].x^2 + w[i].y^2/3 + 0.4*w[i].z"
[effects.edge]
energy = "{law}"
{more}""")


ENDS, JUMPS = "nothing*sqrt(s*(c - w[0].x))", "if(s*w[0].x > s*c, w[0].y, 0)"
COUPLING = '[effects.pair]\nover = "pair(i, j) of w"\nenergy = "0.3*dot(w[i], w[j])"\n'


@pytest.mark.parametrize("law", [ENDS, JUMPS], ids=["ends", "jumps"])
@pytest.mark.parametrize("more, solver, seeds", [("", "auto", 40), (COUPLING, "newton", 120)], ids=["alone", "newton"])
def test_a_field_that_ends_or_jumps_an_ulp_beside_the_midpoint(law, more, solver, seeds):
    """The step is that of one side, or is refused: also where the evaluations at its end are the first to see the other side."""
    model, counts = smidgen.build(edge(law, more), solver=solver), {True: 0, False: 0}
    for seed, s in itertools.product(range(seeds), (1.0, -1.0)):
        w = generic(2, seed)
        sides = [model.set_parameters({"c": c, "s": s}).start(w.copy(), h=0.3).step().state()[0] for c in ((9*s,) if law == ENDS else (9.0, -9.0))]
        c = unit([w[0] + sides[0]])[0, 0]
        for ulps in (-1, 0, 1):
            model.set_parameters({"c": c + ulps*np.spacing(c)}).start(w.copy(), h=0.3)
            taken = model.advance(1) == 1
            counts[taken] += 1
            if taken:
                assert min(np.abs(model.w[0] - side).max() for side in sides) < 1e-14
            else:
                refused(model, NOT_FINITE if law == ENDS else NO_CONVERGENCE)
    assert min(counts.values()) > seeds / 4


def test_a_step_of_dop853_has_ten_thousand_tries():
    """Its rate grows, so that none is given up before: the step that takes them all is taken, and one that is faster at its end is not."""
    spec = smidgen.load_text("""
[model]
name = "chirp"
[space]
w = { sphere = 1 }
[parameters]
late = { default = 1e3 }
[effects.field]
over = "site(i)"
energy = "(1 + t + exp(400*(t - late)))*w[i].z"
""")
    model, w, most = smidgen.build(spec, method="dop853"), unit([[0.6, 0, 0.8]]), 10000
    tries = model.start(w.copy(), h=59.0).step().report()["iterations"]         # none of them is refused
    for h in 59.0 * np.sqrt(most / tries) * (1 + np.arange(8) * 0.4 / most):
        if model.start(w.copy(), h=h).step().report()["iterations"] == most:
            break
    assert model.report()["iterations"] == most
    error = refused(model.set_parameters({"late": h - 0.02}).start(w.copy(), h=h), NO_CONVERGENCE)
    assert most - 10 < model.report()["iterations"] < most and 0.999 < error.reached < 1


# -- sweeps ---------------------------------------------------------------------------------------

KINDS = system("three_kinds", 'w = { sphere = 2, kappa = [1, -0.7] }\nb = { r3 = 2 }\nv = { nambu = 1, C = "v.x^2 + v.y^2" }',
               ("pair(i, j) of w", "0.7*dot(w[i], w[j])"), ("pair(i, j) of b", "0.4*dot(b[i], b[j]) + 0.2*b[i].x*b[j].y"),
               ("each(i of w, j of b)", "0.3*dot(w[i], b[j])"), ("", "0.5*dot(w[0], v) + v.z^2/2 + 0.1*b[1].x*v.y"))


def test_spins_bodies_and_a_cylinder_are_swept():
    """Each by the step that its leaf has; beside Newton for all at once."""
    w = np.array([*generic(2), [0.3, -0.4, 1.1], [0.9, 0.2, -0.3], [0.6, 0.8, 0.4]])
    swept, newton = (smidgen.build(KINDS, solver=solver).start(w.copy(), h=0.1).steps(10) for solver in ("rotation", "newton"))
    assert swept.notes["solver"] == "rotation" and np.abs(swept.w - newton.w).max() < 1e-14


@pytest.mark.parametrize("space", ["sphere", "r3"])
@pytest.mark.parametrize("sites", [2, 3, 5])
def test_what_sweeps_find_is_what_newton_finds(space, sites):
    """Large steps from random states, and across the fields of the others, where a spin as the others stand has no step at first."""
    spec = system("turned", f"w = {{ {space} = {sites} }}", ("pair(i, j) of w", "dot(w[i], w[j])"), ("site(i)", "0.3*w[i].z^2"))
    models, dice, steps = [smidgen.build(spec, solver=solver) for solver in ("rotation", "newton")], np.random.default_rng(sites), 0
    for case in range(60):
        w = np.eye(3)[[k % 3 for k in range(sites)]] if case % 10 == 0 else generic(sites, case)
        h = dice.uniform(0.3, 4)
        ends = []
        for model in models:
            model.start(w.copy(), h=h)
            ends.append(model.state() if model.advance(1) == 1 else None)
        both = [e for e in ends if e is not None]
        assert len(both) != 2 or np.abs(both[0] - both[1]).max() < 1e-11
        steps += len(both) == 2
    assert steps > 20


def test_sweeps_whose_fields_overflow_end():
    model = smidgen.build(system("strong_pairs", "w = { sphere = 12 }", ("pair(i, j) of w", "1e150*dot(w[i], w[j])")), solver="rotation")
    for h in (1e158, 1e300):
        assert refused(model.start(generic(12), h=h), NOT_FINITE).site >= 0


# -- a graph --------------------------------------------------------------------------------------

@pytest.mark.parametrize("seed", range(3))
def test_a_graph_says_up_to_which_step_solutions_exist(seed, tmp_path):
    model = smidgen.build(texts.read(texts.GLASS, tmp_path))
    assert model.notes["solver"] == "sparse"
    w = generic(30, seed)
    error = refused(model.start(w.copy(), h=20.0), NO_SOLUTION)
    assert error.site >= 0 and 0 < error.reached < 1
    assert model.start(w.copy(), h=0.999 * error.reached * 20.0).step().report()["reached"] == 1
