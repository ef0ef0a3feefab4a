"""A distributed run that is killed at any instant goes on with the same bits, and leaves nothing behind."""
import json
import os
import random
import signal
import subprocess
import sys
import time
import types

import numpy as np
import pytest
import smidgen
from smidgen.cli import main
from smidgen.run.distributed import store
from smidgen.run.distributed.run import run_distributed
from smidgen.run.files import places
from smidgen.run.files.checkpoint import CheckpointError, writing
from smidgen.run.files.places import finish, lay_out, lay_out_again, standing, write_at
from smidgen.run.step import divided
from support import crash
from test_distributed_runs import MAGNET, same
from test_ranks import MPI, SMALL, needs_mpi4py

GIVEN = dict(start="random", h=0.1, steps=14, every=4, what=("states", "energy", "momentum"), estimate=False)


class InParts(crash.Deadly):
    """It also dies in the middle of a write to a part of a file, and in HDF5 with what it has written so far on the disk."""

    def __init__(self, at=None):
        super().__init__(at)
        self.pwrite, os.pwrite, os.truncate = os.pwrite, self.part, self.counted(os.truncate)
        for name in ("put_text", "label", "contiguous", "shorten"):
            setattr(places, name, self.flushed(getattr(places, name)))

    def part(self, handle, data, offset):
        if self.count == self.at:
            self.pwrite(handle, data[:len(data) // 2], offset)
        self.passes()
        return self.pwrite(handle, data, offset)

    def flushed(self, call):
        def writing(h5, *args):
            found = call(h5, *args)
            if self.count == self.at:
                h5.flush()
            self.passes()
            return found
        return writing


def begun():
    run_distributed(MAGNET, None, "a.h5", **GIVEN, checkpoint=3)


def go_on():
    """As the command does, or from the start where there is no checkpoint."""
    if not os.path.isdir("a.h5.distributed"):
        return None if os.path.exists("a.h5") else begun()
    if main(["run", "--resume", "a.h5"]):
        assert not os.path.exists("a.h5.distributed/newest.json")
        begun()
    return None


@pytest.fixture
def whole(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CC", f"gcc -Wno-psabi {' '.join(SMALL)}")
    smidgen.run(MAGNET, out="whole.h5", **GIVEN)


def operations() -> int:
    """How many a run makes whose library is in the cache."""
    begun()
    os.unlink("a.h5")
    assert crash.forked(lambda: [deadly := InParts(), begun(), os.write(told, str(deadly.count).encode())] and 0) == 0
    return int(os.read(heard, 9))


heard, told = os.pipe()


def check(at, at_again=None):
    """Killed at that operation, and then at another one of the run that goes on."""
    status = crash.forked(lambda: [InParts(at), begun()] and 0)
    if at_again is not None:
        crash.forked(lambda: [InParts(at_again), go_on()] and 0)
    go_on()
    assert same("whole.h5", "a.h5") and sorted(os.listdir()) == ["a.h5", "whole.h5"], (at, at_again)
    os.unlink("a.h5")
    return status


def test_killed_at_some_operations(whole):
    count = operations()
    os.unlink("a.h5")
    assert count > 60
    assert [at for at in (*range(1, count, 9), *range(count - 12, count)) if check(at) != -signal.SIGKILL] == []


@pytest.mark.long
def test_killed_at_every_operation_and_while_it_goes_on(whole):
    count, dice = operations(), random.Random(1)
    os.unlink("a.h5")
    assert [at for at in range(count) if check(at) != -signal.SIGKILL] == []
    for _ in range(100):
        check(dice.randrange(count), dice.randrange(count))


def test_what_is_torn_is_seen(whole, monkeypatch):
    """If the bytes outside the arrays were not written anew, a file that was about to become the result would be refused."""
    monkeypatch.setattr(store, "lay_out_again", lambda *_: None)
    count, found = operations(), []
    os.unlink("a.h5")
    for at in range(count - 12, count):
        crash.forked(lambda: [InParts(at), begun()] and 0)
        found.append(not os.path.isdir("a.h5.distributed") or main(["run", "--resume", "a.h5"]) == 0)
        subprocess.run("rm -rf a.h5*", shell=True, check=True)
    assert not all(found)


def test_arrays_stay_where_they_were_until_the_file_is_complete(tmp_path):
    """Of a run that ended early too, whose arrays are made shorter."""
    path, w = tmp_path / "a.h5", np.arange(45.0).reshape(3, 5, 3)
    arrays = {"t": ((3,), np.dtype(float)), "w": ((3, 5, 3), np.dtype(float)), "final": ((5, 3), np.dtype(float))}
    for at in range(100):
        found = lay_out(path, arrays)
        handle = os.open(path, os.O_WRONLY)
        write_at(handle, w, found["w"].offset)
        os.close(handle)
        ended = crash.forked(lambda: [InParts(at), finish(path, {"families": {"w": 5}}, 2, ["t", "w"])] and 0)
        lay_out_again(path, tmp_path / "fresh.h5", arrays, {name: place.offset for name, place in found.items()})
        assert standing(path, arrays) == found and np.array_equal(np.fromfile(path, count=45, offset=found["w"].offset).reshape(w.shape), w)
        if ended == 0:
            break
    assert 3 < at < 99


def test_a_run_that_is_still_being_written_is_left_alone(whole, capsys):
    """The ranks of a run whose mpirun was killed may come to their end later than one thinks."""
    crash.forked(lambda: [InParts(40), begun()] and 0)
    held = writing(store.Store("a.h5").folder, "a.h5")
    assert main(["run", "--resume", "a.h5"]) == 8 and "another run is writing a.h5" in capsys.readouterr().err
    with pytest.raises(CheckpointError, match="another run is writing a.h5"):
        begun()
    os.close(held)
    go_on()
    assert same("whole.h5", "a.h5")


def test_a_run_that_has_just_begun_is_left_alone(tmp_path):
    """Its folder looks like what is left of the complete run whose result it will replace."""
    kept = store.Store(tmp_path / "a.h5")
    kept.folder.mkdir()
    kept.out.touch()
    held = writing(kept.folder, kept.out)
    with pytest.raises(CheckpointError, match="another run is writing"):
        kept.unfinished()
    assert kept.folder.is_dir()
    os.close(held)
    (kept.folder / "run.json").touch()      # of a run without checkpoints, whose result has its name
    assert not kept.unfinished() and not kept.folder.is_dir() and kept.lock is None


def test_a_folder_that_stays_is_no_failure_of_a_complete_run(tmp_path, monkeypatch):
    """A network file system keeps files that are open, under other names."""
    kept = store.Store(tmp_path / "a.h5")
    kept.folder.mkdir()

    def refused(_):
        raise OSError("Directory not empty")
    monkeypatch.setattr(store.Path, "rmdir", refused)
    kept.remove()
    assert list(kept.folder.iterdir()) == []


def test_ranks_exchange_what_they_save_before_one_of_them_can_fail(tmp_path, monkeypatch):
    """Others would wait for a rank that cannot open its file."""
    monkeypatch.setattr(divided.ranks, "grid", "1x2")
    monkeypatch.setattr(divided.ranks, "count", lambda: 2)
    model, moved = object.__new__(divided.Divided), []
    model._now(count=3, first=0, end=4, _state=None, _c=types.SimpleNamespace(part_save=lambda *given: moved.append(given)))
    with pytest.raises(OSError):
        store.Store(tmp_path / "a.h5").write_state(model)
    assert moved == [(None, 0, 0, None)]


def test_arrays_at_other_places_are_left_alone(whole, capsys):
    """As those of another version of HDF5 might be."""
    crash.forked(lambda: [InParts(70), begun()] and 0)
    found = store.Store("a.h5").folder / "places.json"
    other, before = {name: at + 8 for name, at in json.loads(found.read_text()).items()}, store.Store("a.h5").file.read_bytes()
    found.write_text(json.dumps(other))
    assert main(["run", "--resume", "a.h5"]) == 8 and "not those of the checkpoint" in capsys.readouterr().err
    assert store.Store("a.h5").file.read_bytes() == before


DRIVER = """
import os, signal, sys, threading
from smidgen import ranks
from smidgen.build import binary
from smidgen.cli import main
from smidgen.run.distributed import rows
binary.FLAGS = tuple("-O0" if f == "-O3" else f for f in binary.FLAGS)
begin = rows.Rows.begin
def begun(*given):
    rank, seconds = os.environ["KILL"].split()
    if rank == str(ranks.variable(ranks.RANK) or 0):
        threading.Timer(float(seconds), os.kill, (os.getpid(), signal.SIGKILL)).start()
    begin(*given)
rows.Rows.begin = begun
sys.exit(main())
"""
WORDS = ("magnet.toml", "--start", "random", "--h", "0.1", "--steps", "600", "--every", "60", "--what", "states,energy,momentum", "--no-estimate")


@needs_mpi4py
@pytest.mark.long
def test_ranks_killed_at_random_times(tmp_path, monkeypatch):
    """One rank, or the program that starts them; the run goes on with another number of them."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "magnet.toml").write_text(MAGNET.sources[0][1])
    (tmp_path / "driver.py").write_text(DRIVER)
    monkeypatch.setenv("CC", f"gcc -Wno-psabi {' '.join(SMALL)}")
    dice, killed = random.Random(3), 0

    def started(count, *words, kill="-1 0"):
        words = ["mpirun", "-n", str(count), sys.executable, "driver.py", "run", *words]
        return subprocess.Popen(words, env={**os.environ, **MPI, "KILL": kill}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    assert started(2, *WORDS, "--distributed", "--out", "whole.h5").wait() == 0
    for n in range(40):
        ranks, seconds = dice.choice((1, 2, 3)), dice.uniform(0, 0.6)
        words = ("--resume", "a.h5") if os.path.isdir("a.h5.distributed") else (*WORDS, "--distributed", "--checkpoint", "45", "--out", "a.h5")
        run = started(ranks, *words, kill=f"{dice.randrange(ranks)} {seconds}" if n % 4 else "-1 0")
        if n % 4 == 0:
            time.sleep(1 + seconds)
            run.kill()
        killed += run.wait() != 0
        wait_for_the_end(run.pid)
        if not os.path.exists("a.h5.distributed/newest.json") and not os.path.exists("a.h5"):
            subprocess.run("rm -rf a.h5.distributed", shell=True, check=True)
        if os.path.exists("a.h5") and not os.path.isdir("a.h5.distributed"):
            assert same("whole.h5", "a.h5")
            os.unlink("a.h5")
    if os.path.isdir("a.h5.distributed"):
        assert started(2, "--resume", "a.h5").wait() == 0 and same("whole.h5", "a.h5")
    assert killed >= 15


def wait_for_the_end(session: int) -> None:
    """No process of it is left after a minute: ranks whose mpirun was killed go on until they have messages for others."""
    for _ in range(600):
        if not subprocess.run(["ps", "-o", "pid=", "-s", str(session)], capture_output=True, text=True).stdout.strip():
            return
        time.sleep(0.1)
    raise AssertionError("processes of a killed run are left")
