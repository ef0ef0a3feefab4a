"""Every status is reached, and a refused step leaves the state bit for bit as it was.

WRONG_BRANCH needs a guess on the wrong branch: tests/laws/test_branch.py.
"""
import ctypes
from math import acos, asin, cos, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from support.systems import load

import smidgen
from smidgen.errors import RunError
from smidgen.read import load_text
from smidgen.run.step.status import STATUS, Status
from smidgen.run.step.start import initial_state

NO_CONVERGENCE, NO_SOLUTION, NOT_FINITE, BAD_PARAMETER, OFF_MANIFOLD = 1, 2, 4, 5, 6
TEXT = '[model]\nname = "{name}"\n[space]\n{space}\n[parameters]\n{parameters}\n[effects.field]\n{field}\n'
SITE = 'over = "site(i) of w"\nenergy = "{}"'


def build(name, energy, space="w = { sphere = 1 }", parameters="", values=None):
    """A model of independent sites with one energy."""
    return smidgen.build(load_text(TEXT.format(name=name, space=space, parameters=parameters,
                                               field=SITE.format(energy))), parameters=values)


def larmor(field=1.0):
    """One spin with H = B w_z: it turns about z."""
    return build("larmor", "B*w[i].z", parameters="B = 1.0", values={"B": field})


def refused(model, status, site=None):
    """One more step fails with `status`; state, time and count stay. Returns the error."""
    w, t = model.state(), model.t
    with pytest.raises(RunError) as caught:
        model.step()
    assert caught.value.status == status
    assert model.state().tobytes() == model.w.tobytes() == w.tobytes() and model.t == t
    assert site is None or model.report()["site"] == site
    return caught.value


def tilted(angle):
    """A spin at `angle` from the z axis."""
    return np.array([[sin(angle), 0.0, cos(angle)]])


# -- no solution: a perpendicular spin ------------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("field, h", [(3.0, 1.0), (2.0, 1.0), (-2.001, 1.0), (2.001, -1.0), (1e6, 1.0)])
def test_a_perpendicular_spin_in_a_strong_field_has_no_step(field, h):
    refused(larmor(field).start(np.array([[1.0, 0.0, 0.0]]), h=h), NO_SOLUTION, site=0)


@pytest.mark.quick
@pytest.mark.parametrize("strength", [1e-3, 0.5, 1.0, 1.9, 1.999999])
def test_a_perpendicular_spin_turns_by_the_exact_angle(strength):
    """cos(phi) = 1 - (lambda h)^2/2; clockwise, for w' = w x B e_z."""
    model = larmor(strength).start(np.array([[1.0, 0.0, 0.0]]), h=1.0).step()
    angle = acos(1 - strength ** 2 / 2) if strength > 0.1 else 2 * asin(strength / 2)
    condition = 1 / sqrt(1 - strength ** 2 / 4)     # d phi/d(lambda h), in halves: round-off grows by it
    assert np.abs(model.w[0] - [cos(angle), -sin(angle), 0]).max() < 4e-16 * (1 + condition)


@pytest.mark.quick
@pytest.mark.parametrize("strength", [0.1, 1.0, 1.99, 2.0, 3.0, 50.0])
@pytest.mark.parametrize("angle", [0.05, 0.7, 1.2, 1.5, 2.5])
def test_any_other_spin_has_a_step_of_every_size(angle, strength):
    """sin^2(phi/2) = ((4+a) - sqrt((4+a)^2 - 16 r^2 a))/(8 r^2), a = (lambda h)^2, r = sin(angle)."""
    model = larmor(strength).start(tilted(angle), h=1.0).step()
    r, a = sin(angle), strength ** 2
    expected = 2 * a / ((4 + a) + sqrt((4 + a) ** 2 - 16 * r * r * a))      # the same, without cancellation
    chord = np.hypot(*(model.w[0, :2] - tilted(angle)[0, :2])) / (2 * r)    # sin(phi/2)
    assert chord ** 2 == pytest.approx(expected, rel=1e-13)
    assert abs(model.w[0, 2] - cos(angle)) <= (0 if strength < 2 else 5e-16)    # strong fields: W from the midpoint


# -- no solution: a branch that ends ----------------------------------------------------------------

def hard_chain(h):
    """A rough chain of 24 spins; a step of 0.05 exists, one of 40 does not."""
    chain = smidgen.build(load("heisenberg_chain"), parameters={"n": 24})
    w = np.random.default_rng(5).normal(size=(24, 3))
    return chain.start(w / np.linalg.norm(w, axis=1)[:, None], h=h)


@pytest.mark.quick
def test_a_branch_that_ends_leaves_the_state_and_a_smaller_step_goes_on():
    """The refused state is a good start: in half the steps the chain goes on from it."""
    chain = hard_chain(0.05).steps(20)
    moved = chain.w.copy()
    chain.start(moved, h=40.0)
    error = refused(chain, NO_SOLUTION)
    assert 0 <= error.site < 24 and error.residual > 1e-12 and error.iterations > 0
    limit = 40.0 * error.reached
    chain.start(moved.copy(), h=(1 - 1e-4) * limit).step()      # there is a step up to where a midpoint nears the centre
    chain.start(moved, h=1.001 * limit + 1e-3)
    assert refused(chain, NO_SOLUTION).reached == pytest.approx(limit / chain.h, rel=1e-3)
    chain.start(moved, h=40.0)
    on, fresh = chain.start(moved.copy(), h=0.025).steps(20).w.copy(), hard_chain(0.05).steps(20)
    assert on.tobytes() == fresh.start(fresh.w.copy(), h=0.025).steps(20).w.tobytes()


# -- no convergence -------------------------------------------------------------------------------

def test_a_lattice_says_where_and_up_to_which_step_solutions_exist():
    """A step of nearly the part of h that is told is taken; no other site is named by default."""
    lattice = smidgen.build(load("cubic_lattice"), solver="rotation")
    w = np.random.default_rng(2).normal(size=(lattice.sites, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    error = refused(lattice.start(w, h=30.0), NO_SOLUTION)
    assert error.site >= 0 and error.residual > 1e-12 and 0 < error.reached < 1
    assert lattice.start(w, h=0.999 * error.reached * 30.0).step().report()["reached"] == 1


# -- not finite -----------------------------------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("energy", ["exp(400*t)*w[i].z", "exp(400*t)*w[i].z^2"])
def test_a_field_that_overflows_after_good_steps(energy):
    """Sites alone: in closed form, and by Newton."""
    model = build("growing", energy, parameters="unused = 1.0").start(tilted(1.0), h=1.0, t0=-4.0)
    model.advance(10)
    assert np.isfinite(model.state()).all() and model.count < 10
    error = model.failure()
    assert error is not None
    refused(model, error.status)


BREATHING = TEXT.format(name="breathing", space="w = { r3 = 1 }", parameters="C = 2.9\neps = 1.5",
                        field='energy = "w.x^2/2"\n[effects.breathing]\nenergy = "w.z^2/(2*C*(1 + eps*cos(2*t)))"\n[starts.a]\nvectors = [[0.05, 1.2, 0.1]]')


@pytest.mark.quick
@pytest.mark.filterwarnings("error")
def test_an_energy_that_is_infinite_is_named():
    with pytest.raises(RunError, match=r"step 1 from t = 0: the energy is not finite at the start: effect 'breathing' at site 0") as caught:
        smidgen.run(load_text(BREATHING), h=0.05, steps=10, parameters={"C": 0})
    assert caught.value.status == NOT_FINITE


@pytest.mark.quick
@pytest.mark.filterwarnings("error")
def test_an_energy_that_is_singular_is_told_where_a_step_fails():
    """C_t passes through 0 again and again: the field changes within a step, or the energy has grown before."""
    with pytest.raises(RunError, match=r"H depends on time, and the field changes by a factor of .* within this step"):
        smidgen.run(load_text(BREATHING), h=0.05, steps=2000)
    with pytest.raises(RunError, match=r"the energy of effect 'breathing' is .* here, .* at the start: H may be singular"):
        smidgen.run(load_text(BREATHING), h=0.0005, steps=200000, every=100)


@pytest.mark.quick
def test_a_field_that_is_infinite_from_the_start():
    refused(build("strong", "exp(1000 + t)*w[i].z", parameters="unused = 1.0").start(tilted(1.0), h=1.0),
            NOT_FINITE, site=0)


@pytest.mark.quick
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_start_that_is_not_finite(bad):
    with pytest.raises(RunError) as caught:
        larmor().start(np.array([[0.0, bad, 1.0]]), h=0.1)
    assert caught.value.status == NOT_FINITE


# -- bad parameters, starts off the sphere --------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("strength", [0.0, np.nan, np.inf])
def test_a_strength_that_no_step_could_use(strength):
    """The C refuses it too, behind the reader's back: NaN and infinity as values, zero as a strength."""
    model = build("weak", "w[i].z", space='w = { sphere = 3, kappa = "k" }', parameters="k = 1.0")
    w = np.tile(tilted(1.0), (3, 1))
    assert status_of_start(model, w, k=1.0) == 0
    assert status_of_start(model, w, k=strength) == (BAD_PARAMETER if strength == 0 else NOT_FINITE)


def status_of_start(model, w, **values):
    """The status of a start with parameter values that reach the C unchecked."""
    names = [p.name for p in model.scene.parameters if not p.fixed and p.kind != "array"]
    scalars = np.array([values.get(name, 1.0) for name in names])
    status = ctypes.c_int(0)
    state = model._c.new(scalars.ctypes.data, None, w.ctypes.data, 0.0, 0.1, ctypes.byref(status))
    if state:
        model._c.free(state)
    return status.value


@pytest.mark.quick
@pytest.mark.parametrize("n", [0, -3, 2, 2.0 ** 50])
def test_a_size_that_no_step_could_use(n):
    """A cyclic chain needs three sites; products of enormous sizes would overflow."""
    chain = smidgen.build(load("heisenberg_chain"), parameters={"n": 24})
    w = np.tile(tilted(1.0), (24, 1))
    assert status_of_start(chain, w, n=24.0) == 0
    assert status_of_start(chain, w, n=float(n)) == BAD_PARAMETER


@pytest.mark.quick
@pytest.mark.parametrize("part, good", [(5e-13, True), (-5e-13, True), (2e-12, False), (-2e-12, False)])
def test_a_start_off_its_sphere(part, good):
    model = larmor()
    if good:
        model.start(tilted(1.0) * (1 + part), h=0.1).step()
        return
    with pytest.raises(RunError) as caught:
        model.start(tilted(1.0) * (1 + part), h=0.1)
    assert caught.value.status == OFF_MANIFOLD


# -- tracers --------------------------------------------------------------------------------------

TRACERS = """
[model]
name = "stirred"
[space]
v = {{ sphere = 2 }}
p = {{ sphere = 2, tracer = true }}
[effects.own]
over = "site(i) of v"
energy = "2*v[i].x"
{more}
[effects.carry]
over = "each(i of v, j of p)"
energy = "v[i].x*p[j].x + 2*v[i].y*p[j].y + v[i].z*p[j].z"
"""
FAINT = '[effects.faint]\nover = "pair(i, j) of v"\nenergy = "1e-40*dot(v[i], v[j])"'


def test_tracers_of_sites_that_feel_only_themselves():
    """A coupling far below round-off between the sites changes nothing for what they carry."""
    w = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.8, 0.6, 0.0], [0.0, 1.0, 0.0]])
    alone, faint = (smidgen.build(load_text(TRACERS.format(more=more))).start(w.copy(), h=0.1).steps(5).w
                    for more in ("", FAINT))
    assert np.abs(alone - faint).max() < 1e-15
    assert np.abs(alone[2:] - w[2:]).min(axis=1).max() > 0 and np.abs(alone[2:] - w[2:]).max() > 0.1


def test_a_tracer_on_a_vortex_is_refused():
    model = smidgen.build(load("vortex_tracers"))
    w = initial_state(model.scene, "ring")
    w[3] = w[0]
    model.start(w, h=0.1)
    with pytest.raises(RunError):
        model.step()
    assert model.state().tobytes() == w.tobytes()


@pytest.mark.quick
def test_statuses_are_those_of_the_header():
    """Python reads numbers, names and meanings from runtime/core/smidgen.h; no other file of it states them."""
    assert {number: name for number, (name, _) in STATUS.items()} == {
        1: "no convergence", 2: "no solution", 3: "wrong branch", 4: "not finite", 5: "bad parameter", 6: "off manifold", 7: "singular"}
    assert STATUS[Status.NO_CONVERGENCE][1] == "the step equation did not converge" and STATUS[Status.SINGULAR][1] == "the Newton matrix is singular"
    gen = Path(smidgen.__file__).resolve().parent
    stated = [meaning for _, meaning in STATUS.values() if meaning != "a value is not finite"]      # which the witness says, too
    assert [path.name for path in gen.rglob("*.py") for meaning in stated if meaning in path.read_text() and "witness" not in path.parts] == []
