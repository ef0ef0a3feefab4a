"""Sub-stepping: a step that fails is taken as smaller ones, for those who ask for it, and recorded."""
import json
import signal

import numpy as np
import pytest
import smidgen
from smidgen.run.step.saved import COUNT_LOW, H, HISTORY, PAST, Saved, retimed
from smidgen.run.step.substeps import DEEPEST, substep
from support import crash
from support.runs import FORMATS, patient_disk    # noqa: F401

# One spin across a field B(t) along z turns by phi with sin(phi/2) = h B/2 in a step, B taken at the
# midpoint: there is no step where h |B| > 2. The pulse is beyond that for two of the forty.
PULSE = """
[model]
name = "pulse"
[space]
w = { sphere = 1 }
[parameters]
strength = { default = 20.0 }
[effects.field]
over = "site(i) of w"
energy = "strength * exp(-(t - 5)^2 / 0.05) * w[i].z"
[starts.across]
x = "1"
y = "0"
z = "0"
[runs.demo]
start = "across"
h = 0.5
steps = 40
output = { every = 1, what = ["states", "energy"] }
"""


@pytest.fixture(scope="module")
def pulse():
    """The spec of the pulse."""
    return smidgen.load_text(PULSE)


def fields(strength, t):
    return strength * np.exp(-(t - 5) ** 2 / 0.05)


def test_never_on_by_itself(pulse):
    with pytest.raises(smidgen.RunError, match="no solution") as caught:
        smidgen.run(pulse)
    assert caught.value.result.substeps is None


def expected(strength, h=0.5, steps=40):
    """(angles turned, [(step, k)]) of the midpoint rule on the equator: sin(phi/2) = h B/2 at each midpoint,
    with the least k for which every part exists."""
    angle, turned, split = 0.0, [0.0], []
    for n in range(steps):
        for k in range(DEEPEST + 1):
            part = h / 2 ** k
            half = part * fields(strength, n * h + (np.arange(2 ** k) + 0.5) * part) / 2
            if np.all(np.abs(half) <= 1):
                break
        angle += np.sum(2 * np.arcsin(half))
        turned.append(angle)
        split += [(n + 1, k)] * (k > 0)
    return np.array(turned), split


@pytest.mark.parametrize("strength", [20.0, 40.0, 300.0])
def test_the_steps_that_fail_and_their_parts(pulse, strength):
    """Which steps, into how many parts, and where the spin ends: by the closed form of the rule on the equator."""
    result = smidgen.run(pulse, parameters={"strength": strength}, substeps=True)
    angle, split = expected(strength)
    assert [(int(s), int(k)) for s, _, k in result.substeps] == split and split
    np.testing.assert_array_equal(result.substeps[:, 1], 0.5 * result.substeps[:, 0])
    w = result.w["w"][:, 0]
    wanted = np.stack([np.cos(angle), -np.sin(angle), 0 * angle], axis=1)
    np.testing.assert_allclose(w, wanted, atol=2e-13)
    assert result.meta["substeps"] is True and result.summary["in_parts"] == len(split)


def test_no_step_fails_and_the_bits_are_the_same(pulse):
    given = dict(parameters={"strength": 1.0})
    plain, asked = smidgen.run(pulse, **given), smidgen.run(pulse, substeps=True, **given)
    np.testing.assert_array_equal(plain.w["w"], asked.w["w"])
    assert asked.substeps.shape == (0, 3)


def test_what_even_the_smallest_parts_cannot_do(pulse):
    """2^10 parts fail too: the error of the whole step, and the state before it."""
    given = dict(parameters={"strength": 1e6})
    with pytest.raises(smidgen.RunError) as plain:
        smidgen.run(pulse, **given)
    with pytest.raises(smidgen.RunError) as asked:
        smidgen.run(pulse, substeps=True, **given)
    assert str(asked.value) == str(plain.value) and asked.value.status == plain.value.status == 2
    np.testing.assert_array_equal(asked.value.result.final, plain.value.result.final)


def test_other_failures_stay_failures(toy):
    """No convergence, no solution, a wrong branch, a singular matrix: parts may help; a value that is not
    finite is no matter of the step."""
    for status in (1, 2, 3, 7):
        result = smidgen.run(toy, "demo", parameters={"fail": 12, "status": status}, substeps=True)
        assert result.substeps.tolist() == [[13, 13 * 0.125, 1]]
    with pytest.raises(smidgen.RunError, match="finite"):
        smidgen.run(toy, "demo", parameters={"fail": 12, "status": 4}, substeps=True)


def test_nothing_of_the_time_and_the_carry_is_lost(pulse):
    top = smidgen.build(pulse, parameters={"strength": 6.0}).start("across", h=0.1, t0=0.3).steps(40)
    before = top.save()
    for count in (40, 2 ** 52 + 1):
        part = retimed(before, 0.1 / 8, 8 * count)
        assert Saved.of(part).count == 8 * count
        assert 0.3 + (8 * count) * (0.1 / 8) == 0.3 + count * 0.1
    past = int(before[PAST])
    kept = [k for k in range(len(before)) if k not in (H, HISTORY, COUNT_LOW, COUNT_LOW - 1) and k < past]
    np.testing.assert_array_equal(retimed(before, 0.05, 80)[kept], before[kept])
    assert not np.any(retimed(before, 0.05, 80)[past:]) and np.any(before[past:])


def test_a_step_in_parts_is_those_parts(pulse):
    """As a trajectory of its own with h/2^k from the same place."""
    top = smidgen.build(pulse).start("across", h=0.5)
    with pytest.raises(smidgen.RunError):
        top.steps(40)
    count, w, t = top.count, top.w.copy(), top.t
    k = substep(top)
    other = smidgen.build(pulse).start(w, t0=t, h=0.5 / 2 ** k).steps(2 ** k)
    np.testing.assert_allclose(top.state(), other.w, atol=1e-15)
    assert (top.count, top.h, top.t) == (count + 1, 0.5, 0.5 * (count + 1))


@pytest.mark.parametrize("suffix", FORMATS)
def test_files_hold_the_record(pulse, tmp_path, suffix):
    out = tmp_path / f"a{suffix}"
    kept = smidgen.run(pulse, substeps=True, out=out, keep=True)
    read = smidgen.load_result(out)
    np.testing.assert_array_equal(read.substeps, kept.substeps)
    assert read.meta["substeps"] is True
    smidgen.repeat(out, out=tmp_path / f"b{suffix}")
    assert (tmp_path / f"b{suffix}").read_bytes() == out.read_bytes()


def test_a_resume_keeps_the_record(pulse, tmp_path, patient_disk):
    """Killed at every operation on the disk, before, within and after the steps in parts."""
    out, whole = tmp_path / "a.npz", tmp_path / "whole.npz"
    smidgen.run(pulse, substeps=True, out=whole)

    def begin(path):
        return smidgen.run(pulse, substeps=True, out=path, checkpoint=5)
    stopped = 0
    for at in range(8, 60, 2):
        stopped += crash.forked(lambda: crash.Deadly(at) and begin(out) and 0) == -signal.SIGKILL
        result = crash.begin_or_resume(out, begin)
        assert out.read_bytes() == whole.read_bytes() and result.summary["in_parts"] > 0
        out.unlink()
    assert stopped > 15


def test_the_command_warns(pulse, tmp_path, monkeypatch, capsys):
    from smidgen.cli import main
    (tmp_path / "pulse.toml").write_text(PULSE)
    monkeypatch.chdir(tmp_path)
    assert main(["run", "pulse.toml"]) == 4
    assert main(["run", "pulse.toml", "--substeps"]) == 0
    said = capsys.readouterr().out
    assert "warning" in said and "replaced by smaller ones" in said and "symplectic" in said
    assert main(["run", "pulse.toml", "--substeps", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["in_parts"] == 2
