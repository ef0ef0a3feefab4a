"""Ensembles: each member has the bits that it has alone, those of a single sphere in lanes; a member that fails is named."""
import functools

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.language import limits
from smidgen.run.many import ensemble as module
from smidgen.run.step.start import initial_state
from support.strict import COMPILERS, MODES, compile_all

BODIES = ("free_rigid_body", "irreversible_rigid_body", "forced_rigid_body")
PULSED = """
[model]
name = "pulsed"
[space]
w = { sphere = 1, kappa = "1 + a^2" }
[parameters]
a = 0.3
n = 3
B = { default = [0.3, 0.2, 0.5], vector = true }
[effects.smooth]
energy = "exp(a*w.x) + log(2 + w.y)*sin(w.z) + sqrt(2 + w.z)*B[1] + n*w.z^2 - cos(2*t)*dot(B, w) + 1.5*(2 + w.x)^1.3"
[effects.pieces]
energy = "if(w.x > w.y and not w.z > 0.9, 0.1*w.x*w.y, -0.1*w.y^3) + max(w.x, a)*0.1"
[starts.a]
theta = "1 + a"
phi = 0.4
"""
PLANAR = """
[model]
name = "planar"
[space]
w = { sphere = 1 }
[effects.only]
energy = "w.x^2"
"""
EDGE = """
[model]
name = "edge"
[space]
w = { sphere = 1 }
[parameters]
B = 1.0
[effects.only]
energy = "w.x + B*sqrt(0.5 + w.z)"
"""
SITES = """
[model]
name = "sites"
[space]
w = { sphere = "n" }
[parameters]
n = 4
K = { default = [1.0, 2.0, 3.0, 4.0], size = "n" }
[effects.only]
over = "site(i) of w"
energy = "K[i]*w[i].z^2"
[starts.a]
theta = "1 + 0.3*i"
phi = 0.4
"""
OWN_STEPS, EXTRAPOLATION, COMPOSED = ("dop853", "dop853-projected"), "extrapolation-12", ("spherical-midpoint-4", "spherical-midpoint-10")
SPECS = {**{name: smidgen.load(name) for name in BODIES}, "pulsed": smidgen.load_text(PULSED), "planar": smidgen.load_text(PLANAR),
         "edge": smidgen.load_text(EDGE), "mixed": smidgen.load_text(PULSED.replace("cos(2*t)*", "").replace("pulsed", "mixed"))}


def test_these_go_in_lanes():
    timed = {"forced_rigid_body", "pulsed"}
    for spec in SPECS.values():
        for method in ("spherical-midpoint", EXTRAPOLATION, *OWN_STEPS, *COMPOSED):
            goes = "#define SMG_LANE_SPHERE 1" in generate(spec, method=method, features=("ensemble",))[f"{spec.name}.c"]
            assert goes == (method not in OWN_STEPS or spec.name not in timed)


def points(members: int, seed: int = 0) -> np.ndarray:
    w = np.random.default_rng(seed).standard_normal((members, 1, 3))
    return w / np.linalg.norm(w, axis=2)[..., None]


def alone(spec, w, h, steps, t0=0.0, **how):
    """(state, status, steps taken) of each member by itself."""
    values, own, tolerance = how.pop("parameters", {}), how.pop("own", {}), how.pop("tolerance", None)
    found = []
    for k, one in enumerate(w):
        model = smidgen.build(spec, parameters={**values, **{name: value[k] for name, value in own.items()}}, **how).start(one.copy(), t0, h, tolerance=tolerance)
        done = model.advance(steps)
        error = model.failure()
        found.append((model.state(), 0 if error is None else error.status, done))
    states, status, done = zip(*found)
    return np.array(states), np.array(status), np.array(done)


def agree(found, wanted) -> bool:
    """The same bits, signs of zeros too."""
    return (found.w.tobytes() == wanted[0].tobytes() and np.array_equal(found.status, wanted[1]) and np.array_equal(found.steps, wanted[2])
            and sorted(found.failures) == list(np.flatnonzero(wanted[1])))


HOW = ("portable", "native", "clang")


@pytest.fixture(params=HOW)
def how(request, monkeypatch):
    """Builds with registers of different widths, by both compilers."""
    if request.param == "clang":
        if "clang" not in COMPILERS:
            pytest.skip("no clang")
        monkeypatch.setenv("CC", "clang")
    return {"native": request.param == "native"}


@pytest.mark.parametrize("how, h", [pytest.param(how, h, marks=() if how == "native" or h in (0.3, 2.5) else pytest.mark.long)
                                    for how in HOW for h in (0.05, 0.3, 1.1, 2.5)], indirect=["how"])
@pytest.mark.parametrize("name", BODIES)
def test_each_member_has_the_bits_that_it_has_alone(how, name, h):
    """At 0.05 most steps take one iteration in lanes, at 0.3 two, at 1.1 most are taken alone, at 2.5 many end at a fold."""
    w = points(13)
    assert agree(smidgen.ensemble(SPECS[name], start=w, h=h, steps=70, t0=0.7, threads=1, **how), alone(SPECS[name], w, h, 70, 0.7))


def test_members_fail_where_they_fail_alone():
    """Some do and some do not, and at different steps; where they were, they stay."""
    spec, w = SPECS["irreversible_rigid_body"], points(40)
    found, wanted = smidgen.ensemble(spec, start=w, h=2.5, steps=40, every=8, what="states"), alone(spec, w, 2.5, 40)
    assert agree(found, wanted) and 5 < len(found.failures) < 35 and len(set(found.steps)) > 5
    longer = smidgen.ensemble(spec, start=w, h=2.5, steps=48)
    for k, said in found.failures.items():
        assert f"step {wanted[2][k] + 1} from" in said
        assert np.array_equal(longer.w[k], found.w[k]) and np.array_equal(found.states[-1, k], found.w[k])


@pytest.mark.parametrize("members", [1, 2, 7, 8, 9, 33])
def test_any_number_of_members(members):
    spec, w = SPECS["forced_rigid_body"], points(members, 3)
    found = smidgen.ensemble(spec, start=w, h=0.2, steps=40, native=True)
    assert agree(found, alone(spec, w, 0.2, 40)) and found.w.shape == (members, 1, 3)


@pytest.mark.parametrize("name, own", [("free_rigid_body", {"I2": (1.5, 2.5), "I3": (3, 4)}), ("forced_rigid_body", {"eps": (0, 0.3)}),
                                       ("pulsed", {"a": (0.1, 0.8), "B": (0.1, 0.9)})])
def test_parameters_of_each_member(how, name, own):
    spec, w, rng = SPECS[name], points(11), np.random.default_rng(5)
    own = {p: rng.uniform(*ends, (11, 3) if p == "B" else 11) for p, ends in own.items()}
    found = smidgen.ensemble(spec, start=w, parameters=own, h=0.1, steps=50, **how)
    assert agree(found, alone(spec, w, 0.1, 50, own=own))


def test_one_number_of_a_member_stands_for_a_whole_array():
    """As in a call for one."""
    spec, values = smidgen.load_text(SITES), np.array([[1.0], [5.0], [9.0]])
    found = smidgen.ensemble(spec, parameters={"K": values}, h=0.1, steps=5)
    assert np.array_equal(found.w, smidgen.ensemble(spec, parameters={"K": np.repeat(values, 4, axis=1)}, h=0.1, steps=5).w)
    for k, value in enumerate(values[:, 0]):
        assert np.array_equal(found.w[k], smidgen.build(spec, parameters={"K": value}).start("a", h=0.1).steps(5).w)


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, lanes):
    spec, w = SPECS["pulsed"], points(9)
    wanted = alone(spec, w, 0.05, 60)
    monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
    assert agree(smidgen.ensemble(spec, start=w, h=0.05, steps=60), wanted)


@pytest.mark.parametrize("method", OWN_STEPS)
@pytest.mark.parametrize("name", BODIES)
def test_steps_of_their_own_in_lanes(how, name, method):
    """Many internal steps in one of h, or one; refused ones at a loose tolerance; the first sizes."""
    w = points(13)
    for h, steps, tolerance in ((20.0, 2, 1e-10), (0.1, 12, None), (3.0, 6, 0.01)):
        found = smidgen.ensemble(SPECS[name], start=w, h=h, steps=steps, t0=0.7, method=method, tolerance=tolerance, threads=1, **how)
        assert agree(found, alone(SPECS[name], w, h, steps, 0.7, method=method, tolerance=tolerance))
        if name == "forced_rigid_body":
            assert found.lanes == 1 and "one by one" in repr(found)
        else:
            assert found.lanes in (2, 4, 8) and f"{found.lanes} at a time" in repr(found)


@pytest.mark.parametrize("method", OWN_STEPS)
def test_members_that_take_more_steps_than_others(method):
    """Bodies up to a hundred times as fast as others: a lane whose member is done is given to the next one."""
    w, own = points(37, 4), {"I1": 10 ** np.random.default_rng(6).uniform(-2, 0, 37)}
    found = smidgen.ensemble(SPECS["free_rigid_body"], start=w, parameters=own, h=0.6, steps=3, every=1, what="states", method=method, tolerance=1e-8)
    assert agree(found, alone(SPECS["free_rigid_body"], w, 0.6, 3, own=own, method=method, tolerance=1e-8))
    at_once = smidgen.ensemble(SPECS["free_rigid_body"], start=w, parameters=own, h=0.6, steps=3, method=method, tolerance=1e-8)
    assert at_once.w.tobytes() == found.states[-1].tobytes() == found.w.tobytes()


@pytest.mark.parametrize("members", [1, 7, 8, 9, 16, 17])
def test_steps_of_their_own_of_any_number_of_members(members):
    """Registers that are not full, and none at all: a start off its sphere is no member that steps."""
    w = points(members, 3)
    assert agree(smidgen.ensemble(SPECS["free_rigid_body"], start=w, h=5.0, steps=2, method=OWN_STEPS[1]),
                 alone(SPECS["free_rigid_body"], w, 5.0, 2, method=OWN_STEPS[1]))
    assert len(smidgen.ensemble(SPECS["free_rigid_body"], start=1.1 * w, h=5.0, steps=2, method=OWN_STEPS[1]).failures) == members


@pytest.mark.parametrize("seed", [1, 2, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(3, 30))])
def test_any_steps_of_their_own(seed):
    rng = np.random.default_rng(seed)
    members, method = int(rng.integers(1, 30)), str(rng.choice(OWN_STEPS))
    w, h, steps, tolerance = points(members, seed), float(10 ** rng.uniform(-2, 1)), int(rng.integers(1, 9)), float(10 ** rng.uniform(-14, -2))
    own = {"a": rng.uniform(-0.8, 0.8, members), "B": rng.uniform(-1, 1, (members, 3))}
    found = smidgen.ensemble(SPECS["mixed"], start=w, parameters=own, h=h, steps=steps, method=method, tolerance=tolerance)
    assert agree(found, alone(SPECS["mixed"], w, h, steps, own=own, method=method, tolerance=tolerance))


@pytest.mark.parametrize("method", OWN_STEPS)
def test_members_whose_own_steps_fail(method):
    """Where the energy ends: below, there is no field at all; others come to its edge after some steps, others never."""
    w, spec = points(41, 2), SPECS["edge"]
    found, wanted = smidgen.ensemble(spec, start=w, h=0.5, steps=30, method=method), alone(spec, w, 0.5, 30, method=method)
    assert agree(found, wanted) and 5 < len(found.failures) < 36 and len(set(found.steps)) > 4
    for k, said in found.failures.items():
        assert f"step {wanted[2][k] + 1} from" in said


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_steps_of_their_own_in_any_number_of_lanes(monkeypatch, lanes):
    wanted = alone(SPECS["mixed"], points(9), 2.0, 5, method=OWN_STEPS[1])
    monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
    found = smidgen.ensemble(SPECS["mixed"], start=points(9), h=2.0, steps=5, method=OWN_STEPS[1])
    assert agree(found, wanted) and found.lanes == lanes and ("one by one" in repr(found)) == (lanes == 1)


@pytest.mark.parametrize("name", [*BODIES, "pulsed", "planar"])
def test_extrapolation_in_lanes(how, name):
    """Steps large and small; in fields that depend on time, which is the same for all, too."""
    for h, steps in ((0.7, 9), (0.05, 3)):
        found = smidgen.ensemble(SPECS[name], start=points(13), h=h, steps=steps, t0=0.7, method=EXTRAPOLATION, threads=1, **how)
        assert agree(found, alone(SPECS[name], points(13), h, steps, 0.7, method=EXTRAPOLATION)) and found.lanes in (2, 4, 8)


@pytest.mark.parametrize("name, own", [("free_rigid_body", {"I2": (1.5, 2.5), "I3": (3, 4)}), ("pulsed", {"a": (0.1, 0.8), "B": (0.1, 0.9)})])
def test_extrapolation_with_parameters_of_each_member(name, own):
    spec, w, rng = SPECS[name], points(70), np.random.default_rng(5)
    own = {p: rng.uniform(*ends, (70, 3) if p == "B" else 70) for p, ends in own.items()}
    found = smidgen.ensemble(spec, start=w, parameters=own, h=0.3, steps=5, method=EXTRAPOLATION)
    assert agree(found, alone(spec, w, 0.3, 5, own=own, method=EXTRAPOLATION))


@pytest.mark.parametrize("members", [1, 7, 8, 9, 64, 65, 133])
def test_extrapolation_of_any_number_of_members(members):
    """Registers and batches of them that are not full."""
    spec, w = SPECS["forced_rigid_body"], points(members, 3)
    found = smidgen.ensemble(spec, start=w, h=0.4, steps=7, every=2, method=EXTRAPOLATION, native=True)
    assert agree(found, alone(spec, w, 0.4, 7, method=EXTRAPOLATION))


@pytest.mark.parametrize("name", ["edge", "edge in time"])
def test_members_whose_extrapolation_fails(name):
    """Those beyond the edge have no field; of others a step comes to it, the first members of their registers too."""
    spec = SPECS["edge"] if name == "edge" else smidgen.load_text(EDGE.replace("B*sqrt", "(B + 0.2*sin(t))*sqrt").replace('"edge"', '"timed_edge"'))
    w = points(41, 2)
    found, wanted = smidgen.ensemble(spec, start=w, h=0.5, steps=30, method=EXTRAPOLATION), alone(spec, w, 0.5, 30, method=EXTRAPOLATION)
    assert agree(found, wanted) and 5 < len(found.failures) < 36 and len(set(found.steps)) > 4
    parts = smidgen.ensemble(spec, start=w, h=0.5, steps=30, every=7, method=EXTRAPOLATION)
    assert parts.w.tobytes() == found.w.tobytes() and np.array_equal(parts.steps, found.steps)
    for k, said in found.failures.items():
        assert f"step {wanted[2][k] + 1} from" in said


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_extrapolation_in_any_number_of_lanes(monkeypatch, lanes):
    wanted = alone(SPECS["pulsed"], points(9), 0.4, 5, method=EXTRAPOLATION)
    monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
    found = smidgen.ensemble(SPECS["pulsed"], start=points(9), h=0.4, steps=5, method=EXTRAPOLATION)
    assert agree(found, wanted) and found.lanes == lanes


@pytest.mark.parametrize("how, h", [pytest.param(how, h, marks=() if how == "native" and h != 0.05 else pytest.mark.long) for how in HOW for h in (0.05, 0.3, 1.1, 2.5)],
                         indirect=["how"])
@pytest.mark.parametrize("name", [*BODIES, "pulsed"])
def test_compositions_in_lanes(how, name, h):
    """From stages of one iteration to steps that end at a fold; with more steps than a choice of the predictor takes, and continued by another call."""
    w, stops = points(13), {"every": 19, "what": "states"}
    for method in COMPOSED:
        found = smidgen.ensemble(SPECS[name], start=w, h=h, steps=40, t0=0.7, method=method, threads=1, **stops, **how)
        assert agree(found, alone(SPECS[name], w, h, 40, 0.7, method=method)) and found.lanes in (2, 4, 8)


@pytest.mark.parametrize("name, own", [("free_rigid_body", {"I2": (1.5, 2.5)}), ("forced_rigid_body", {"eps": (0, 0.3)})])
def test_compositions_with_parameters_of_each_member(name, own):
    own = {p: np.random.default_rng(5).uniform(*ends, 11) for p, ends in own.items()}
    found = smidgen.ensemble(SPECS[name], start=points(11), parameters=own, h=0.2, steps=40, method=COMPOSED[0])
    assert agree(found, alone(SPECS[name], points(11), 0.2, 40, own=own, method=COMPOSED[0]))


@pytest.mark.parametrize("steps", [1, 2, 3, 30])
@pytest.mark.parametrize("members", [1, 7, 9, 33])
def test_compositions_of_any_number_of_members(members, steps):
    """Some of which cannot begin; with fewer steps than a history takes."""
    w = points(members, 3)
    w[1::5] *= 1.1
    found = smidgen.ensemble(SPECS["forced_rigid_body"], start=w, h=0.2, steps=steps, method=COMPOSED[0])
    good = np.flatnonzero(found.status == 0)
    assert list(good) == [k for k in range(members) if k % 5 != 1]
    assert found.w[good].tobytes() == alone(SPECS["forced_rigid_body"], w[good], 0.2, steps, method=COMPOSED[0])[0].tobytes()


def test_compositions_fail_where_they_fail_alone():
    """In any stage: a member then is where its step began, and so are those that are in lanes with it."""
    spec, w = SPECS["irreversible_rigid_body"], points(40)
    found, wanted = smidgen.ensemble(spec, start=w, h=4, steps=30, method=COMPOSED[0]), alone(spec, w, 4, 30, method=COMPOSED[0])
    assert agree(found, wanted) and 2 < len(found.failures) < 38 and len(set(found.steps)) > 3


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_compositions_in_any_number_of_lanes(monkeypatch, lanes):
    wanted = alone(SPECS["pulsed"], points(9), 0.2, 40, method=COMPOSED[0])
    monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
    found = smidgen.ensemble(SPECS["pulsed"], start=points(9), h=0.2, steps=40, method=COMPOSED[0])
    assert agree(found, wanted) and found.lanes == lanes


def test_energy_of_one_component():
    """Where many entries of the matrix are 0; and the plane x = 0, in which nothing moves."""
    w = np.concatenate([points(6), [[[0.0, 0.6, 0.8]], [[-0.0, -1.0, 0.0]], [[1.0, 0.0, -0.0]]]])
    assert agree(smidgen.ensemble(SPECS["planar"], start=w, h=0.3, steps=60), alone(SPECS["planar"], w, 0.3, 60))


def test_outputs_on_the_way():
    spec, w = SPECS["free_rigid_body"], points(5)
    found = smidgen.ensemble(spec, start=w, h=0.1, steps=25, every=10, what=("states", "energy"))
    assert np.array_equal(found.t, [0.0, 10 * 0.1, 20 * 0.1, 25 * 0.1]) and found.states.shape == (4, 5, 1, 3)
    model = smidgen.build(spec).start(w[2].copy(), h=0.1)
    for k, count in enumerate((0, 10, 10, 5)):
        model.steps(count)
        assert np.array_equal(found.states[k, 2], model.w) and found.energy[k, 2] == model.energy()
    assert smidgen.ensemble(spec, start=w, h=0.1, steps=25).states is None


def test_stops_and_threads_change_no_bit(monkeypatch):
    spec, w = SPECS["forced_rigid_body"], points(70)
    whole = smidgen.ensemble(spec, start=w, h=0.3, steps=33, threads=1)
    monkeypatch.setattr(module, "BLOCK", 32)
    for threads, every in ((3, 1), (2, 7)):
        parts = smidgen.ensemble(spec, start=w, h=0.3, steps=33, threads=threads, every=every)
        assert parts.w.tobytes() == whole.w.tobytes()


@pytest.mark.parametrize("name, method, h", [("heisenberg_chain", "spherical-midpoint", 0.1), ("free_rigid_body", "axis-splitting-4", 0.1),
                                             ("point_vortices", "gauss-4", 0.05), ("nambu_a31", "classical-midpoint", 0.02)])
def test_other_models_and_methods(name, method, h):
    """Members one by one, or stages of each in lanes."""
    spec = smidgen.load(name)
    start = initial_state(spec, spec.runs[0].start)
    w = np.array([start, start[:, [1, 2, 0]] if name != "nambu_a31" else start, start])
    found = smidgen.ensemble(spec, start=w, h=h, steps=12, method=method)
    assert agree(found, alone(spec, w, h, 12, method=method)) and found.lanes == 1 and "one by one" in repr(found)


def test_a_member_of_another_model_that_cannot_begin_stays():
    spec = smidgen.load("point_vortices")
    start = initial_state(spec, spec.runs[0].start)
    w = np.array([start, 1.1 * start, start[:, [1, 2, 0]]])
    found = smidgen.ensemble(spec, start=w, h=0.1, steps=6, every=3)
    assert [*found.failures] == [1] and list(found.steps) == [6, 0, 6] and found.w[1].tobytes() == w[1].tobytes()
    assert found.w[[0, 2]].tobytes() == alone(spec, w[[0, 2]], 0.1, 6)[0].tobytes()


def test_a_start_by_name_and_by_the_values():
    spec, own = SPECS["pulsed"], {"a": np.array([0.1, 0.3, 0.9])}
    found = smidgen.ensemble(spec, start="a", parameters=own, h=0.1, steps=10)
    w = np.array([initial_state(spec, "a", {"a": a}) for a in own["a"]])
    assert agree(found, alone(spec, w, 0.1, 10, own=own))
    assert np.array_equal(smidgen.ensemble(spec, parameters=own, h=0.1, steps=10).w, found.w)


def test_members_that_cannot_begin_are_named():
    spec, w = SPECS["pulsed"], points(6)
    w[2] *= 1.1
    w[4, 0, 1] = np.nan
    found = smidgen.ensemble(spec, start=w, h=0.1, steps=10)
    good = [0, 1, 3, 5]
    assert sorted(found.failures) == [2, 4] and "off manifold" in found.failures[2] and "not finite" in found.failures[4]
    assert found.w[good].tobytes() == alone(spec, w[good], 0.1, 10)[0].tobytes() and found.w[2].tobytes() == w[2].tobytes()
    assert list(found.steps) == [10, 10, 0, 10, 0, 10]


@pytest.mark.parametrize("given, said", [
    (dict(start=np.zeros((3, 2))), "shape"), (dict(start="abc"), "no start 'abc'"), (dict(start=np.ones((3, 2, 3))), "has 1 sites"),
    (dict(parameters={"a": [1.0, 2.0]}), "the numbers of members differ: starts: 3, 'a': 2"), (dict(parameters={"n": [1, 2, 3]}), "'n' must be the same"), (dict(parameters={"a": [1, 2, np.inf]}), "member 2"),
    (dict(parameters={"B": np.ones((3, 2))}), "list of 3 numbers"), (dict(what="spin"), "has no output 'spin'"), (dict(threads=0), "at least 1"), (dict(parameters={"c": 1}), "c"),
    (dict(start=[["x"]]), "array of shape"), (dict(parameters={"a": [1, [2, 3], 4]}), "'a' must be a number, or an array"), (dict(start=[[[1, 0, 0]], [[1]]]), "array of shape"), (dict(steps=None), "no duration"), (dict(every=0), "every must be from 1")])
def test_what_does_not_fit_is_refused(given, said):
    given = {"start": points(3), "h": 0.1, "steps": 10, **given}
    with pytest.raises(smidgen.UsageError, match=said):
        smidgen.ensemble(SPECS["pulsed"], **given)


@pytest.mark.usefixtures("as_shipped")
def test_fused_operations_change_the_last_bits_alone():
    spec, w = SPECS["free_rigid_body"], points(40)
    found, plain = (smidgen.ensemble(spec, start=w, h=0.1, steps=100, fast=fast) for fast in (True, False))
    assert found.lanes == plain.lanes
    assert np.abs(found.w - plain.w).max() < 1e-12 and (plain.lanes < 8 or found.w.tobytes() != plain.w.tobytes())


def test_limits_of_an_ensemble(monkeypatch):
    monkeypatch.setattr(limits, "MEMBERS", 4)
    smidgen.ensemble(SPECS["pulsed"], start=points(4), h=0.1, steps=1)
    with pytest.raises(smidgen.UsageError, match="from 1 to 4 members, not 5"):
        smidgen.ensemble(SPECS["pulsed"], start=points(5), h=0.1, steps=1)
    monkeypatch.setattr(module, "MEMORY", 4 * 24 * 2)
    smidgen.ensemble(SPECS["pulsed"], start=points(4), h=0.1, steps=1, every=1, what="states")
    with pytest.raises(smidgen.UsageError, match="GiB of memory"):
        smidgen.ensemble(SPECS["pulsed"], start=points(4), h=0.1, steps=2, every=1, what="states")


@functools.cache
def files_of(name, method):
    return generate(SPECS[name], method=method, amalgamate=True, features=("ensemble",))


@pytest.mark.parametrize("lanes", [1, 2, pytest.param(8, marks=pytest.mark.long)])
@pytest.mark.parametrize("compiler, mode", MODES)
@pytest.mark.parametrize("name, method", [("pulsed", "spherical-midpoint"), ("free_rigid_body", "spherical-midpoint"), ("mixed", OWN_STEPS[1]), ("pulsed", EXTRAPOLATION),
                                          ("pulsed", COMPOSED[0]), ("free_rigid_body", COMPOSED[0])])
def test_clean_c(tmp_path, name, method, compiler, mode, lanes):
    for file, text in files_of(name, method).items():
        (tmp_path / file).write_text(text)
    assert not compile_all(tmp_path, [f"{name}.c", f"{name}_abi.c"], compiler, "-Wno-psabi", f"-DSMG_LANES={lanes}", how=mode)


def test_nobody_else_pays():
    assert not any("ensemble" in text or "lane" in text for text in generate(SPECS["free_rigid_body"]).values())


def test_a_member_that_cannot_begin_is_no_failed_step():
    """Its site, and how far off its own sphere it is, before any step."""
    spec = smidgen.load_text("""
[model]
name = "m"
[space]
w = { sphere = 3, radius = "r" }
[parameters]
r = 2.0
[effects.exchange]
over = "pair(i, j) of w"
energy = "dot(w[i], w[j])"
""")
    w, r = np.tile(np.eye(3), (3, 1, 1)), np.array([1.0, 2.0, 1.0])
    w[2, 1] *= 1 + 1e-9
    found = smidgen.ensemble(spec, start=w, parameters={"r": r}, h=0.1, steps=2)
    said = "cannot start: off manifold: the start is off its sphere or leaf (site {}: |w| = {}, but its sphere has radius {})"
    assert found.failures == {1: said.format(0, "1", "2"), 2: said.format(1, "1.000000001", "1")} and list(found.steps) == [2, 0, 0]


def test_the_energy_of_a_member_whose_first_step_fails():
    """It stays where it was, and so does its energy; one that cannot begin has none."""
    spec, w = SPECS["irreversible_rigid_body"], points(40)
    w[0] *= 1.1
    found = smidgen.ensemble(spec, start=w, h=4, steps=4, every=2, what="energy")
    first = (found.steps == 0) & (np.arange(40) > 0)
    assert first.any() and np.isnan(found.energy[:, 0]).all() and np.isfinite(found.energy[:, 1:]).all()
    assert (found.energy[:, first] == found.energy[0, first]).all()
