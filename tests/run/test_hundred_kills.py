"""kill -9 at a hundred random instants of a checkpointed run: each time a resume ends with the same bits.

The instants: a phase by chance (the start, a stretch of computing, a checkpoint being written, the
result being put together), one of its entries by chance, and a random time within it. A killed run
goes on in two ways: a copy is resumed to its end and compared with the unbroken run, and the run
itself lives on till its next kill. The test prints how many kills fell into which phase.
"""
import random
import shutil
import signal
from collections import Counter

import pytest
import smidgen
from smidgen.run.files.checkpoint import folder_of
from smidgen.run.step.saved import HEAD
from support import crash
from support.phases import COMPUTING, NAMES, START, WRITING, durations, killed_in
from support.runs import chain_run

KILLS = 100
SPINS = 20
WEIGHTS = (1, 3, 3, 1)      # of the phases in NAMES


def long_run(path, **more):
    """Checkpoints at 8 places, between outputs."""
    return chain_run(path, **{**dict(parameters={"n": SPINS}, steps=4000, every=70, checkpoint=470), **more})


def ends_the_same(out, place, whole):
    """The run of `out` as it lies there, resumed to its end in a folder of its own."""
    place.mkdir()
    for path in (folder_of(out), out):
        if path.is_dir():
            shutil.copytree(path, folder_of(place / out.name))
        elif path.exists():
            shutil.copy(path, place)
    crash.begin_or_resume(place / out.name, long_run)
    assert (place / out.name).read_bytes() == whole
    assert [p.name for p in place.iterdir()] == [out.name]
    shutil.rmtree(place)


def kills(tmp_path, count, seed):
    """Counter of the phases in which `count` kills fell; each followed by a resume that is compared."""
    dice, out = random.Random(seed), tmp_path / "a.h5"
    long_run(tmp_path / "whole.h5", checkpoint=None)
    whole = (tmp_path / "whole.h5").read_bytes()
    times = durations(lambda: long_run(out))
    out.unlink()
    fell, ended = Counter(), 0
    while sum(fell.values()) < count:
        phase = dice.choices(range(len(NAMES)), WEIGHTS)[0]
        entries, seconds = times[phase]
        status, at = killed_in(phase, dice.randint(1, entries), dice.uniform(0, seconds),
                               lambda: crash.begin_or_resume(out, long_run))
        assert status in (-signal.SIGKILL, 0)
        if status == -signal.SIGKILL:
            fell[NAMES[at] if at < len(NAMES) else "after the result"] += 1
            ends_the_same(out, tmp_path / "copy", whole)
        else:
            ended += 1
        if out.exists() and not folder_of(out).exists():
            assert out.read_bytes() == whole
            out.unlink()
        assert ended < 10 * count
    return fell


@pytest.mark.long
def test_a_hundred_kills(tmp_path, capsys):
    fell = kills(tmp_path, KILLS, seed=1)
    with capsys.disabled():
        print("\n" + ", ".join(f"{n} in {name}" for name, n in sorted(fell.items())))
    assert sum(fell.values()) == KILLS
    assert all(fell[NAMES[phase]] >= 10 for phase in (START, COMPUTING, WRITING)), fell


def test_a_few_kills(tmp_path):
    assert sum(kills(tmp_path, 6, seed=2).values()) == 6


def without_carry(saved):
    """A saved state whose compensation carry, which stands after w, is zero."""
    found = saved.copy()
    found[HEAD + 3 * SPINS:HEAD + 6 * SPINS] = 0
    return found


def test_a_resume_that_forgets_the_carry_is_seen(tmp_path, monkeypatch):
    """The comparison says no."""
    out = tmp_path / "a.h5"
    long_run(tmp_path / "whole.h5", checkpoint=None)
    killed_in(WRITING, 5, 0.0, lambda: long_run(out))
    real = smidgen.Integrator.restore
    monkeypatch.setattr(smidgen.Integrator, "restore", lambda model, saved: real(model, without_carry(saved)))
    with pytest.raises(AssertionError):
        ends_the_same(out, tmp_path / "copy", (tmp_path / "whole.h5").read_bytes())
