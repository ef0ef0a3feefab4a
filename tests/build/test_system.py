"""What differs between systems: locks, owners and folders, with those of Windows played."""
import errno
import os
import subprocess
import sys

import portalocker
import pytest
from smidgen import system
from smidgen.build.cache import entry
from smidgen.run.files.durable import write_new

pytestmark = pytest.mark.quick


def test_a_lock_is_held_by_one(tmp_path):
    first = system.locked(tmp_path / "lock", 0o600, wait=False)
    assert first is not None and system.locked(tmp_path / "lock", 0o600, wait=False) is None
    os.close(first)
    again = system.locked(tmp_path / "lock", 0o600, wait=False)
    assert again is not None
    os.close(again)


@pytest.mark.parametrize("wait", [False, True])
@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_a_file_system_without_locks_refuses_nobody_and_keeps_nobody_waiting(tmp_path, monkeypatch, wait, number):
    def lock(handle, flags):
        raise portalocker.LockException(OSError(number, "no locks")) from OSError(number, "no locks")
    monkeypatch.setattr(portalocker, "lock", lock)
    handle = system.locked(tmp_path / "lock", 0o600, wait)
    assert handle is not None
    os.close(handle)


def test_a_link_is_no_lock(tmp_path):
    (tmp_path / "lock").symlink_to(tmp_path / "other")
    with pytest.raises(OSError):
        system.locked(tmp_path / "lock", 0o600, wait=False)
    assert not (tmp_path / "other").exists()


def test_a_lock_that_was_removed_is_none(tmp_path, monkeypatch):
    """As when another process removes the file between opening and locking it."""
    place, removed = tmp_path / "lock", []
    def taken(handle, wait):
        if not removed:
            removed.append(place.unlink())
        return True
    monkeypatch.setattr(system, "taken", taken)
    handle = system.locked(place, 0o600, wait=True)
    assert removed and os.path.samestat(os.fstat(handle), os.stat(place))
    os.close(handle)


@pytest.fixture
def windows(monkeypatch):
    """Without owners of files; folders cannot be opened."""
    opened = os.open

    def files_alone(path, *args, **more):
        if os.path.isdir(path):
            raise PermissionError(13, "Permission denied", str(path))
        return opened(path, *args, **more)
    monkeypatch.delattr(os, "getuid")
    monkeypatch.setattr(os, "open", files_alone)
    monkeypatch.setattr(system, "OPENS_FOLDERS", False)


def test_the_cache_without_owners(tmp_path, monkeypatch, windows):
    monkeypatch.setenv("SMIDGEN_CACHE", str(tmp_path / "cache"))
    place = entry("one", lambda work: (work / "a").write_text("b"))
    assert (place / "a").read_text() == "b" and entry("one", None) == place


def test_files_without_owners(tmp_path, windows):
    write_new(tmp_path / "a", b"b")
    assert (tmp_path / "a").read_bytes() == b"b"


def test_a_system_that_opens_no_folders_is_seen(tmp_path, monkeypatch, windows):
    """The fixture refuses what Windows does: with the choice of Unix nothing is written."""
    monkeypatch.setattr(system, "OPENS_FOLDERS", True)
    with pytest.raises(PermissionError):
        write_new(tmp_path / "a", b"b")


def test_it_is_imported_without_the_modules_of_unix():
    """As on Windows: nothing but smidgen's own choice of a lock asks for them."""
    program = ("import sys; import numpy, h5py, matplotlib, rich, sympy, jinja2, portalocker\n"
               "for name in ('fcntl', 'pwd', 'grp', 'resource', 'termios'): sys.modules[name] = None\n"
               "import os; del os.getuid, os.O_NOFOLLOW, os.O_NONBLOCK\n"
               "import smidgen, smidgen.cli, smidgen.build.cache, smidgen.run.files.checkpoint\n"
               "smidgen.load('free_rigid_body')\n")
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
