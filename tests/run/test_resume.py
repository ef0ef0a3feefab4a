"""Going on with a run: what is refused, what is got round, and in what order the disk is written."""
import os
import signal
import subprocess
import sys
import time
from importlib import import_module

import numpy as np
import pytest
import smidgen
from smidgen.run.files.checkpoint import Folder, folder_of
from smidgen.build import binary
from smidgen.errors import Exit
from support import crash
from support.runs import chain_run, patient_disk, same_as_unbroken, unbroken    # noqa: F401
from support.systems import begin

pytestmark = pytest.mark.usefixtures("patient_disk")


@pytest.fixture
def stopped(tmp_path, patient_disk):
    """The result's name of a run that was killed when the state of step 120 was safe."""
    out = tmp_path / "a.h5"

    def live():
        real = vars(import_module("smidgen.run.run"))["_save"]

        def save(model, recorder, began):
            real(model, recorder, began)
            if model.count == 120:
                crash.die()
        vars(import_module("smidgen.run.run"))["_save"] = save
        chain_run(out)
    assert crash.forked(live) == -signal.SIGKILL
    return out


def content(folder):
    """name -> bytes of all that is there."""
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def spoil(part):
    """One bit in the middle of a part flips."""
    data = bytearray(part.path.read_bytes())
    data[len(data) // 2] ^= 1
    part.path.write_bytes(data)


def refused(out, said):
    """A resume is refused in these words, and changes nothing."""
    before = content(folder_of(out))
    with pytest.raises(smidgen.CheckpointError, match=said) as caught:
        smidgen.resume(out)
    assert caught.value.exit_code == Exit.OUTPUT
    assert content(folder_of(out)) == before


def test_a_stopped_run_goes_on(stopped, unbroken):
    seen = []
    result = smidgen.resume(stopped, progress=seen.append)
    assert seen[0] > 120 and seen[-1] == 130            # the first 120 steps are not done again
    same_as_unbroken(stopped, unbroken)
    assert result.summary["errors"] == unbroken[".h5"][1]["errors"]     # over the whole run
    assert smidgen.resume(stopped).meta["status"] == "complete"         # nothing is left to do
    same_as_unbroken(stopped, unbroken)


def test_a_run_that_goes_on_makes_checkpoints_as_before(tmp_path):
    """As often as the call said that began it; so a second kill costs no more than the first."""
    out, seen = tmp_path / "a.h5", set()
    crash.forked(lambda: crash.Deadly(40) and smidgen.run("free_rigid_body", steps=300, checkpoint=30, out=out))
    assert 0 < Folder(out).parts("state")[-1].number < 240
    smidgen.resume(out, progress=lambda done: seen.update(part.number for part in Folder(out).parts("state")))
    assert {240, 270} <= seen


def test_what_was_saved_is_there_in_memory_too(stopped, unbroken):
    kept = smidgen.resume(stopped, keep=True)
    read = smidgen.load_result(unbroken[".h5"][0])
    np.testing.assert_array_equal(kept.step, read.step)
    np.testing.assert_array_equal(kept.w["w"], read.w["w"])
    np.testing.assert_array_equal(kept.values["casimirs"], read.values["casimirs"])


def test_a_damaged_state_is_got_round(stopped, unbroken):
    spoil(Folder(stopped).parts("state")[-1])
    said = []
    smidgen.resume(stopped, tell=said.append)
    assert len(said) == 1 and "state-000000000000000120" in said[0] and "damaged" in said[0]
    same_as_unbroken(stopped, unbroken)


def test_damaged_last_rows_are_got_round(stopped, unbroken):
    spoil(Folder(stopped).parts("rows")[-1])
    said = []
    smidgen.resume(stopped, tell=said.append)
    assert "rows-" in said[0]
    same_as_unbroken(stopped, unbroken)


@pytest.mark.parametrize("kind", ["rows", "state"])
def test_a_part_that_is_gone_is_got_round(stopped, unbroken, kind):
    Folder(stopped).parts(kind)[-1].path.unlink()
    smidgen.resume(stopped, tell=print)
    same_as_unbroken(stopped, unbroken)


@pytest.mark.filterwarnings("ignore:.*going back")
@pytest.mark.parametrize("kind", ["run", "rows"])
def test_damage_that_cannot_be_got_round_is_refused(stopped, kind):
    part = Folder(stopped).parts(kind)[0]
    spoil(part)
    refused(stopped, f"{part.path.name}.*damaged")


@pytest.mark.filterwarnings("ignore:.*going back")
def test_no_state_left_is_refused(stopped):
    for part in Folder(stopped).parts("state"):
        spoil(part)
    refused(stopped, "there is no earlier state")


def test_every_bit_of_a_part_is_watched(stopped):
    """Also those that HDF5 itself would not miss."""
    part = Folder(stopped).parts("state")[-1]
    data = part.path.read_bytes()
    for at in range(0, len(data), max(1, len(data) // 100)):
        part.path.write_bytes(data[:at] + bytes([data[at] ^ 128]) + data[at + 1:])
        with pytest.raises(smidgen.CheckpointError, match="damaged"):
            part.read()
    part.path.write_bytes(data[:-1])
    with pytest.raises(smidgen.CheckpointError, match="damaged"):
        part.read()


def test_another_version_is_refused(stopped, monkeypatch):
    monkeypatch.setattr(import_module("smidgen.run.resume"), "generator_name", lambda: "smidgen 9.9 0123456789abcdef")
    refused(stopped, "started by smidgen .* this is smidgen 9.9")


def test_another_compiler_is_refused(stopped, monkeypatch):
    build = import_module("smidgen.build.binary")
    monkeypatch.setattr(build, "compiler_version", lambda words: "another compiler 1.0")
    refused(stopped, "started with different settings .*compiler")


def test_another_format_is_refused(stopped, monkeypatch):
    monkeypatch.setattr(import_module("smidgen.run.files.checkpoint"), "FORMAT", 2)
    refused(stopped, "another version of smidgen")


def test_one_run_at_a_time(stopped, unbroken):
    folder = Folder.open(stopped)
    refused(stopped, "another run is writing")
    with pytest.raises(smidgen.CheckpointError, match="another run is writing"):
        chain_run(stopped)
    folder.release()
    smidgen.resume(stopped)
    same_as_unbroken(stopped, unbroken)


@pytest.mark.parametrize("checkpoint", [None, 40])
def test_saved_work_is_not_thrown_away(stopped, checkpoint):
    before = content(folder_of(stopped))
    with pytest.raises(smidgen.CheckpointError, match=r"unfinished run \(120 steps are saved\).*--resume"):
        chain_run(stopped, checkpoint=checkpoint)
    assert content(folder_of(stopped)) == before
    assert not stopped.exists()


def test_nothing_to_go_on_with(tmp_path, unbroken):
    with pytest.raises(smidgen.CheckpointError, match="there is no checkpoint.*--checkpoint"):
        smidgen.resume(tmp_path / "none.h5")
    folder_of(tmp_path / "empty.h5").mkdir()
    with pytest.raises(smidgen.CheckpointError, match="there is no checkpoint"):
        smidgen.resume(tmp_path / "empty.h5")


def test_checkpoints_need_a_file():
    with pytest.raises(smidgen.UsageError, match="need a file"):
        chain_run(None)


@pytest.mark.parametrize("wrong", [0, -1, 2.5, 10 ** 12 + 1, "often"])
def test_wrong_cadences(tmp_path, wrong):
    with pytest.raises(smidgen.UsageError, match="checkpoint"):
        chain_run(tmp_path / "a.h5", checkpoint=wrong)
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_run_goes_on(tmp_path, unbroken):
    """Ctrl-C: the result so far is there, and the rest can follow."""
    out = tmp_path / "a.h5"

    def interrupt(done):
        if done > 60:
            signal.raise_signal(signal.SIGINT)
    with pytest.raises(smidgen.Interrupted):
        chain_run(out, progress=interrupt)
    part = smidgen.load_result(out)
    assert part.meta["status"] == "interrupted" and 60 < part.meta["done"] < 130
    assert folder_of(out).is_dir()
    smidgen.resume(out)
    same_as_unbroken(out, unbroken)


def test_a_failure_is_the_failure_without_checkpoints(toy, tmp_path):
    for name, checkpoint in (("a.npz", None), ("b.npz", 4)):
        with pytest.raises(smidgen.RunError, match="step 13"):
            smidgen.run(toy, "demo", parameters={"fail": 12}, out=tmp_path / name, checkpoint=checkpoint)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix != ".toml") == ["a.npz", "b.npz"]


def test_long_double_goes_on(tmp_path):
    """The eleven bits that a double has not are saved as well."""
    whole = chain_run(tmp_path / "whole.h5", real="long double", checkpoint=None, keep=True)
    out = tmp_path / "a.h5"
    crash.forked(lambda: crash.Deadly(30) and chain_run(out, real="long double"))
    result = smidgen.resume(out, keep=True)
    assert result.final.dtype == np.longdouble
    np.testing.assert_array_equal(result.final, whole.final)
    np.testing.assert_array_equal(result.w["w"], whole.w["w"])


@pytest.mark.long
def test_many_chunks_between_two_checkpoints(tmp_path):
    """Rows are safe as they come; those after the last state are computed again."""
    spec = begin("free_rigid_body").spec
    given = dict(steps=20_000, every=1, what=["states", "energy"])
    smidgen.run(spec, out=tmp_path / "whole.h5", **given)
    out = tmp_path / "a.h5"
    crash.forked(lambda: crash.Deadly(28) and smidgen.run(spec, out=out, checkpoint=15_000, **given))
    assert len(Folder(out).parts("rows")) > 2
    smidgen.resume(out)
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_a_spec_says_so_itself(tmp_path):
    text = (begin("free_rigid_body").spec.sources[0][1].replace("[runs.demo]", "[runs.demo]\ncheckpoint = 7\nsubsteps = true"))
    spec = smidgen.load_text(text)
    assert (spec.runs[0].checkpoint, spec.runs[0].substeps) == (7, True)
    assert smidgen.run(spec, "demo", steps=10).substeps.shape == (0, 3)     # no file, no checkpoints
    out = tmp_path / "a.h5"
    crash.forked(lambda: crash.Deadly(40) and smidgen.run(spec, "demo", out=out))
    assert Folder(out).parts("state")[-1].number % 7 == 0


@pytest.mark.parametrize("wrong", ["checkpoint = 0", "checkpoint = 1.5", "checkpoint = true", "substeps = 1"])
def test_wrong_words_in_a_spec(wrong):
    text = begin("free_rigid_body").spec.sources[0][1].replace("[runs.demo]", f"[runs.demo]\n{wrong}")
    with pytest.raises(smidgen.SpecError, match=wrong.split()[0]):
        smidgen.load_text(text)


def test_each_name_is_given_when_the_bytes_are_on_the_disk(tmp_path, monkeypatch):
    """fsync of a file, then its rename, then fsync of its folder; no state before its rows."""
    seen, names = [], {}

    def fsync(handle, real=os.fsync):
        seen.append(("fsync", os.readlink(f"/proc/self/fd/{handle}")))
        real(handle)

    def replace(old, new, real=os.replace):
        seen.append(("name", str(old), str(new)))
        real(old, new)
    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(os, "replace", replace)
    chain_run(tmp_path / "a.h5")
    named = [k for k, act in enumerate(seen) if act[0] == "name"]
    assert len(named) > 8
    for k in named:
        assert seen[k - 1] == ("fsync", seen[k][1])
        names[seen[k][2]] = k
    for path, k in names.items():
        if "/rows-" not in path:
            assert seen[k + 1] == ("fsync", os.path.dirname(path))
    assert list(names)[-1] == str(tmp_path / "a.h5")


# The command

def test_the_command(command, tmp_path, monkeypatch):
    monkeypatch.setattr(binary, "FLAGS", ("-std=c11", "-O3", "-ffp-contract=off", "-fno-math-errno"))     # as the new process has them
    words = ["run", "free_rigid_body", "--steps", 10 ** 6, "--every", 70_000]
    assert command(*words, "--out", "whole.h5").returncode == 0
    out = tmp_path / "a.h5"
    begun = subprocess.Popen([sys.executable, "-m", "smidgen", *map(str, words), "--out", str(out), "--checkpoint", "20000"])
    while begun.poll() is None and not list(tmp_path.glob("a.h5.checkpoint/state-*.h5")):
        time.sleep(0.01)
    begun.kill()
    assert begun.wait() == -signal.SIGKILL
    refusal = command(*words, "--out", "a.h5")
    assert refusal.returncode == 8 and "--resume a.h5" in refusal.stderr
    told = command("run", "--resume", "a.h5")
    assert told.returncode == 0 and "1000000 of 1000000 steps" in told.stdout, told.stderr
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()
    assert command("run", "--resume", "a.h5", "--json").returncode == 0


@pytest.mark.parametrize("words, said", [
    (["run", "--resume", "none.h5"], "there is no checkpoint"),
    (["run", "free_rigid_body", "--resume", "a.h5"], "omit SPEC"),
    (["run", "--resume", "a.h5", "--steps", "5"], "--json only"),
    (["run", "--resume", "a.h5", "--out", "b.h5"], "omit SPEC"),
    (["run", "free_rigid_body", "--checkpoint", "5"], "--out result.h5"),
    (["run", "free_rigid_body", "--checkpoint", "5", "--out", "-"], "--out result.h5"),
    (["run", "free_rigid_body", "--checkpoint", "0", "--out", "a.h5"], "checkpoint must be")])
def test_wrong_words(words, said, capsys, tmp_path, monkeypatch):
    from smidgen.cli import main
    monkeypatch.chdir(tmp_path)
    assert main(words) in (2, 8)
    assert said in capsys.readouterr().err
