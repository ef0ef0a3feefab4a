"""A disk that is full: the run ends with a sentence, and what was saved goes on when there is room."""
import contextlib
import errno
import os
import resource
import signal
import subprocess
from importlib import import_module

import pytest
import smidgen
from smidgen.run.files import durable
from smidgen.run.files.checkpoint import Folder, folder_of
from smidgen.errors import Exit
from support import crash
from support.runs import FORMATS, chain_run, patient_disk, same_as_unbroken, unbroken     # noqa: F401


class Room:
    """In place of `durable._write_all`: writes until `left` bytes are used, then ENOSPC."""

    def __init__(self, left):
        self.left, self.write = left, durable._write_all

    def __call__(self, out, data):
        if len(data) > self.left:
            self.write(out, data[:self.left])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.left -= len(data)
        self.write(out, data)


@pytest.mark.parametrize("room", [0, 1, 20_000, 40_000, 60_000, 66_000])
def test_checkpoints_that_find_no_room(tmp_path, patient_disk, monkeypatch, room, unbroken):
    out = tmp_path / "a.h5"
    with monkeypatch.context() as full:
        full.setattr(durable, "_write_all", Room(room))
        with pytest.raises(smidgen.OutputError, match=f"cannot write {out}: No space left") as caught:
            chain_run(out)
    assert caught.value.exit_code == Exit.OUTPUT and not out.exists()
    if folder_of(out).exists():
        saved = Folder(out).parts("state")[-1].number if Folder(out).parts("state") else 0
        assert f"The first {saved} steps are saved" in str(caught.value)
        assert f"smidgen run --resume {out}" in str(caught.value)
        assert not [p for p in folder_of(out).iterdir() if p.suffix == ".new"]
    else:
        assert list(tmp_path.iterdir()) == [] and room < 20_000
    crash.begin_or_resume(out, chain_run)
    same_as_unbroken(out, unbroken)


@pytest.mark.parametrize("suffix", FORMATS)
def test_no_room_for_the_result_itself(tmp_path, patient_disk, suffix, unbroken):
    """The parts are there, the result put together from them is too large: a limit on its size."""
    out = tmp_path / f"a{suffix}"
    limit = {".h5": 20_000, ".npz": 12_000, ".csv": 20_000}[suffix]

    def live():
        real = vars(import_module("smidgen.run.run"))["_close"]

        def close(*args):
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            real(*args)
        vars(import_module("smidgen.run.run"))["_close"] = close
        try:
            chain_run(out, steps=128, checkpoint=64)
        except smidgen.OutputError as problem:
            return 8 if "File too large" in str(problem) and "--resume" in str(problem) else 9
    out.write_bytes(b"what was there before")
    assert crash.forked(live) == 8
    assert out.read_bytes() == b"what was there before"
    smidgen.resume(out)
    assert smidgen.load_result(out).meta["status"] == "complete"
    assert [p.name for p in tmp_path.iterdir()] == [out.name]


def refusing(call, number):
    """`call`, but its call after `number` others finds the disk full."""
    def counted(*args, **more):
        nonlocal number
        number -= 1
        if number < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return call(*args, **more)
    return counted


@pytest.mark.parametrize("name", ["fsync", "replace", "unlink", "mkdir"])
def test_a_disk_that_refuses_any_call(tmp_path, patient_disk, monkeypatch, name, unbroken):
    """Whichever call fails first, and at whatever time: an OutputError, and a run that goes on."""
    out, failed = tmp_path / "a.h5", True
    for number in range(0, 100, 3):
        with monkeypatch.context() as full:
            full.setattr(os, name, refusing(getattr(os, name), number))
            try:
                chain_run(out)
                failed = False
            except smidgen.OutputError:
                pass
        crash.begin_or_resume(out, chain_run)
        assert out.read_bytes() == unbroken[".h5"][0].read_bytes()
        out.unlink()
        if not failed:          # the run makes no more calls than that
            break
    assert number > 0 and not failed


@contextlib.contextmanager
def small_disk(folder, size):
    """A file system of its own in memory."""
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)], capture_output=True)
    if done.returncode:
        pytest.skip("this user may not mount")
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def test_a_real_full_disk(tmp_path, unbroken):
    """A file system of 4 MiB that something else has filled."""
    with small_disk(tmp_path, "4m"):
        out = tmp_path / "a.h5"
        filler = tmp_path / "filler"
        filler.write_bytes(bytes(4_100_000))
        with pytest.raises(smidgen.OutputError, match="No space left.*--resume"):
            chain_run(out)
        assert Folder(out).parts("state")
        filler.unlink()
        smidgen.resume(out)
        same_as_unbroken(out, unbroken)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_full_disk_spares_the_earlier_result(tmp_path, suffix):
    """Without checkpoints too."""
    out = tmp_path / f"a{suffix}"
    chain_run(out, checkpoint=None)
    before = out.read_bytes()

    def live():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) // 2,) * 2)
        try:
            chain_run(out, checkpoint=None)
        except smidgen.OutputError as problem:
            return problem.exit_code
    assert crash.forked(live) == 8
    assert out.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == [out.name]
