"""Stop and go on: a saved state has all the bits, and a run that is killed ends as an unbroken one."""
import itertools
import signal
import time

import numpy as np
import pytest
import smidgen
from smidgen.run.files.checkpoint import folder_of
from smidgen.compile.features import FEATURES
from smidgen.methods import METHODS
from smidgen.run.step.saved import COUNT_HIGH, COUNT_LOW, DEGREE, H, HEAD, HISTORY, NEWTON_STEPS, PAST, SCALE, SIZE, TOLERANCE, Saved
from support import crash
from support.features import ANYWHERE
from support.runs import FORMATS, chain_run, patient_disk, same_as_unbroken, unbroken     # noqa: F401
from support.systems import CLASSICAL, FREE_BODIES, QUICK, SPECS, VESELOV, accepts, begin, model, tiers


# The saved state

def goes_on(one, other, w, h, before=37, after=50):
    """Does `other`, restored after `before` steps of `one`, end with the same bits?"""
    one.start(w.copy(), h=h).steps(before)
    saved = one.save()
    one.steps(after)
    other.start(w.copy(), h=0.5 * h).restore(saved)
    assert other.count == before and other.h == h
    np.testing.assert_array_equal(other.save(), saved)
    other.steps(after)
    np.testing.assert_array_equal(other.save(), one.save())
    np.testing.assert_array_equal(other.w, one.w)
    assert other.t == one.t


@pytest.mark.parametrize("name", tiers(SPECS, (), (*QUICK, "heisenberg_chain", "vortex_tracers")))
def test_every_spec_goes_on(name):
    case = begin(name)
    goes_on(model(case), model(case), case.w, case.h)


@pytest.mark.parametrize("name, feature", [*itertools.product(["forced_rigid_body", "two_bodies"], ANYWHERE), ("heisenberg_chain", "distributed")])
def test_every_feature_goes_on(name, feature):
    case = begin(name)
    goes_on(*(model(case, features=[feature]) for _ in range(2)), case.w, case.h)


@pytest.mark.long
@pytest.mark.parametrize("feature", [None, *FEATURES])
@pytest.mark.parametrize("method", [CLASSICAL, VESELOV, "spherical-midpoint"])
@pytest.mark.parametrize("name", SPECS)
def test_every_method_and_feature_goes_on(name, method, feature):
    if (method == VESELOV and name not in FREE_BODIES) or not accepts(name, method):
        pytest.skip("no such method for this spec")
    case, more = begin(name), {"features": [feature]} if feature else {}
    try:
        one = model(case, method, **more)
    except smidgen.UsageError as refusal:
        pytest.skip(f"no such feature for this spec: {refusal}")
    goes_on(one, model(case, method, **more), case.w, case.h)


@pytest.mark.parametrize("solver, real", [("newton", "double"), ("rotation", "double"), ("rotation", "long double"), *(
    pytest.param(solver, real, marks=pytest.mark.long) for solver, real in (("plain", "double"), ("newton", "long double"), ("plain", "long double")))])
def test_every_solver_goes_on(solver, real):
    case = begin("heisenberg_chain", n=12)
    goes_on(*(model(case, solver=solver, real=real) for _ in range(2)), case.w, case.h)


@pytest.mark.parametrize("features, h", [((), 8.0), (("extended",), 1.5)], ids=["by rows", "from site to site"])
def test_the_rest_from_sweeps_goes_on(features, h):
    """While sweeps from site to site do not settle, their trial is put off: the count of that is part of the state. Those by rows are tried in every step."""
    case = begin("heisenberg_chain", n=12)
    one, other = (model(case, features=features) for _ in range(2))
    one.start(case.w.copy(), h=h).steps(3)
    assert (one.save()[NEWTON_STEPS] > 0) == bool(features)
    goes_on(one, other, case.w, h, before=3, after=300)


@pytest.mark.parametrize("before", [0, 1, 3, 8, 57, 64, 129])
def test_any_place_in_the_history_goes_on(before):
    """The rows of a single sphere move in their array; where they stand decides nothing."""
    case = begin("irreversible_rigid_body")
    goes_on(model(case), model(case), case.w, case.h, before=before, after=100)


@pytest.fixture
def chain():
    """A ring of 12 spins after 20 steps."""
    case = begin("heisenberg_chain", n=12)
    return model(case).start(case.w, h=case.h).steps(20)


def test_counts_beyond_the_integers_of_a_double(chain):
    saved = chain.save()
    for count in (2 ** 53 + 1, 2 ** 61 + 2 ** 31 + 5, 2 ** 62 - 1):
        saved[COUNT_HIGH], saved[COUNT_LOW] = divmod(count, 2 ** 32)
        assert chain.restore(saved).count == count
        np.testing.assert_array_equal(chain.save(), saved)
        assert Saved.of(saved).count == count
    assert chain.steps(2).count == 2 ** 62 + 1


@pytest.mark.parametrize("place, values", [
    (SIZE, [0, 1e9, np.nan]), (PAST, [0, 11]), (H, [1e-310, -1e-310, np.inf]), (COUNT_HIGH, [-1, 0.5, 2.0 ** 30, 2.0 ** 31]),
    (COUNT_LOW, [-1, 0.5, 2.0 ** 32]), (HISTORY, [-2, 8, 2.5]), (DEGREE, [-2, 7, 0.5]), (NEWTON_STEPS, [-256, 256, 1.5]), (TOLERANCE, [-1e-9, 1.0]),
    (SCALE, [-1, np.nan, np.inf, 0, 5, 0.1]), (HEAD, [np.nan, np.inf]), (HEAD + 36, [np.nan]), (-1, [-np.inf])])
def test_what_cannot_be_a_saved_state_is_refused(chain, place, values):
    before = chain.save()
    for value in values:
        wrong = before.copy()
        wrong[place] = value
        with pytest.raises(smidgen.RunError, match="not a saved state"):
            chain.restore(wrong)
        np.testing.assert_array_equal(chain.save(), before)
    with pytest.raises(smidgen.RunError, match="not a saved state"):
        chain.restore(before[:-1])
    chain.restore(before).steps(1)


@pytest.mark.quick
@pytest.mark.parametrize("name, method", [("free_rigid_body", "spherical-midpoint"), ("two_bodies", "gauss-4"), ("nambu_a34", "spherical-midpoint"), ("free_rigid_body", "dop853"), ("heisenberg_chain", "spherical-midpoint")])
def test_a_saved_state_is_on_its_spheres(name, method):
    """As a start is; what steps move it off them grows with their number, and of methods that keep no leaf is not judged."""
    case = begin(name)
    one, kind = model(case, method), {f.name: f.kind for f in case.spec.families}
    for steps in (0, 7):
        saved = one.start(case.w.copy(), h=case.h).steps(steps).save()
        here = slice(HEAD, HEAD + 3)
        wrong = [np.full(3, 1e200), *([np.zeros(3)] if "r3" not in kind.values() else [])]
        if set(kind.values()) == {"sphere"} and METHODS[method].keeps_leaf:
            wrong += [saved[here] * (1 + 1e-7), saved[here] * 2, saved[here] / 2]
        for w in wrong:
            other = saved.copy()
            other[here] = w
            with pytest.raises(smidgen.RunError, match="not a saved state"):
                one.restore(other)
            assert one.restore(saved).save().tobytes() == saved.tobytes()


def test_the_edges_of_a_saved_state(chain):
    saved = chain.save()
    for place, value in ((NEWTON_STEPS, -255), (HISTORY, 5), (DEGREE, 4), (SCALE, 3.5)):       # by rows five increments are kept
        edge = saved.copy()
        edge[place] = value
        np.testing.assert_array_equal(chain.restore(edge).save(), edge)


# Runs

@pytest.mark.parametrize("suffix", FORMATS)
def test_checkpoints_leave_no_trace_in_the_result(tmp_path, suffix, unbroken):
    out = tmp_path / f"a{suffix}"
    result = chain_run(out)
    same_as_unbroken(out, unbroken)
    assert result.summary["errors"] == unbroken[suffix][1]["errors"]


def operations(path) -> int:
    """How many operations on the disk a whole run takes."""
    def count():
        deadly = crash.Deadly()
        chain_run(path)
        path.with_suffix(".count").write_text(str(deadly.count))
    assert crash.forked(count) == 0
    number = int(path.with_suffix(".count").read_text())
    path.with_suffix(".count").unlink()
    path.unlink()
    return number


@pytest.mark.parametrize("suffix, part", [(".h5", 0.15), (".npz", 0.1), (".csv", 0.1), *(
    pytest.param(suffix, part, marks=pytest.mark.long) for suffix, part in ((".h5", 1), (".npz", 0.3), (".csv", 0.3)))])
def test_killed_at_every_operation_on_the_disk(tmp_path, patient_disk, suffix, part, unbroken):
    """In the middle of each write, before and after each fsync, rename and removal. part: of the operations, from the last on; the formats differ only when the result is put together."""
    out = tmp_path / f"a{suffix}"
    total = operations(out)
    assert total > 50
    for at in range(total - int(part * total), total):
        assert crash.forked(lambda: crash.Deadly(at) and chain_run(out) and 0) == -signal.SIGKILL
        crash.begin_or_resume(out, chain_run)
        same_as_unbroken(out, unbroken)
        out.unlink()


def test_killed_again_and_again(tmp_path, patient_disk, unbroken):
    """Also while it goes on: each life lasts an operation more."""
    out, lives = tmp_path / "a.h5", 0
    for at in range(3, 100):
        def live(at=at):
            crash.Deadly(at)
            crash.begin_or_resume(out, chain_run)
        lives += 1
        if crash.forked(live) == 0:
            break
    assert lives > 5
    same_as_unbroken(out, unbroken)


def killed_at_random(tmp_path, unbroken, seed, count):
    """Resumes that are killed at random instants till the run is complete; over and over."""
    out, begins = tmp_path / "a.h5", time.perf_counter()
    chain_run(out, checkpoint=3)
    longest = time.perf_counter() - begins
    out.unlink()
    kills = 0
    for seconds in crash.instants(seed, count, longest):
        def act():
            crash.begin_or_resume(out, lambda path: chain_run(path, checkpoint=3))
        kills += crash.killed_after(seconds, act) == -signal.SIGKILL
        if out.exists() and not folder_of(out).exists():
            same_as_unbroken(out, unbroken)
            out.unlink()
    crash.begin_or_resume(out, chain_run)
    same_as_unbroken(out, unbroken)
    return kills


def test_killed_at_random_instants(tmp_path, unbroken):
    assert killed_at_random(tmp_path, unbroken, seed=1, count=5) >= 1
