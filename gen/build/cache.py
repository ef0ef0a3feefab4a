"""The folder of compiled libraries: ours alone, locked while one is made, each checked before a process uses it for the first time, and again if it has changed.

What lies there is loaded and run. So the folder must be one that nobody else can write, and every
entry holds the sha256 of its files, taken when it was made: a bit that flips on the disk is found.
"""
from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import stat
import tempfile
import time
import warnings
from pathlib import Path

from ..errors import BuildError
from ..system import locked, shared

KEPT = 300          # entries that are kept; the ones unused longest go first
LEFT = 86400        # seconds after which a log of a compiler, or what a killed process was building, goes
RECENT = 3600       # seconds since its last use in which an entry stays: a process may be about to load it
SEAL = "sha256"     # the file with the digest of the others
TICK = 10 ** 9      # ns
_whole: dict = {}   # entries that this process has found as they were made -> their marks then: a digest takes as long as ten thousand steps of a body


def cache_folder() -> Path:
    """$SMIDGEN_CACHE, else smidgen in $XDG_CACHE_HOME or ~/.cache; made when missing.

    Raises BuildError when it cannot be made, and when someone else may write it.
    """
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    place = Path(os.environ.get("SMIDGEN_CACHE") or Path(base) / "smidgen")
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        trouble = shared(place)
    except OSError as problem:
        raise BuildError(f"cannot create the cache {place}: {problem.strerror}; "
                         "set SMIDGEN_CACHE to a writable folder") from None
    if trouble:
        raise BuildError(f"the cache {place} is not safe: {trouble}, and code stored in it would be executed. It holds nothing but compiled models: delete it, or set SMIDGEN_CACHE to a folder of your own that nobody else can write")
    return place


def entry(name: str, make) -> Path:
    """The folder `name` of the cache; make(folder) fills a new one.

    Two processes at once are safe: a lock a name, a folder of its own, one rename. An entry that is
    not as it was made is made again. Raises BuildError.
    """
    place = cache_folder() / name
    try:
        with lock(place):
            if not whole(place):
                _remove(place)
                _make(place, make)
            os.utime(place)
    except OSError as problem:
        raise BuildError(f"cannot build in the cache {place.parent}: {problem.filename or ''} {problem.strerror}; "
                         "set SMIDGEN_CACHE to a writable folder") from None
    return place


@contextlib.contextmanager
def lock(place: Path):
    """One process at a time; the kernel frees the lock of one that dies. A link in its place is not followed."""
    handle = locked(place.with_suffix(".lock"), 0o600, wait=True)
    try:
        yield
    finally:
        os.close(handle)


def whole(place: Path) -> bool:
    """Is the folder `place` there, ours alone, and to the last bit as it was made?"""
    if not os.path.lexists(place):
        return False
    with contextlib.suppress(OSError):
        if not place.is_symlink() and not shared(place):
            key, now, marks = place.absolute(), time.time_ns(), marks_of(place)
            if _whole.get(key) == marks:
                return True
            if plain_files(marks) and (place / SEAL).read_bytes() == digest_of(place):
                _whole[key] = marks if settled(marks, now) else None
                return True
    warnings.warn(f"{place} is damaged or writable by other users, and is rebuilt")
    return False


def marks_of(place: Path) -> list:
    """What changes when any file of a folder does, as long as nobody sets the clock: names, sizes, nodes, times."""
    found = [(file.name, file.stat(follow_symlinks=False)) for file in os.scandir(place)]
    return sorted((name, one.st_mode, one.st_size, one.st_dev, one.st_ino, one.st_mtime_ns, one.st_ctime_ns) for name, one in found)


def plain_files(marks: list) -> bool:
    """No links: what they lead to may change while they stay."""
    return all(stat.S_ISREG(one[1]) for one in marks)


def settled(marks: list, now: int) -> bool:
    """Would a change from `now` on (ns) have another time? Clocks of files go by ticks of some ms."""
    return all(one[-1] < now - TICK for one in marks)


def digest_of(place: Path) -> bytes:
    """sha256 of the names and bytes of all files of a folder but the seal."""
    files = sorted(p for p in place.iterdir() if p.name != SEAL)
    return hashlib.sha256(repr([(p.name, p.read_bytes()) for p in files]).encode()).hexdigest().encode()


def _make(place, make):
    work = Path(tempfile.mkdtemp(prefix=".building-", dir=place.parent))
    try:
        make(work)
        (work / SEAL).write_bytes(digest_of(work))
        os.rename(work, place)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    _prune(place.parent)


def _remove(place):
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    else:
        place.unlink(missing_ok=True)


def _prune(cache: Path) -> None:
    """Forget what was unused longest. A loaded library survives its file on Linux."""
    used = sorted(((last_use(p), p) for p in cache.iterdir() if (p / SEAL).exists()), reverse=True)
    for when, old in used[KEPT:]:
        if time.time() - when >= RECENT:
            _forget(old)
    for old in [*cache.glob("failed-*.log"), *cache.glob(".building-*")]:
        if time.time() - last_use(old) >= LEFT:
            with contextlib.suppress(OSError):
                _remove(old)


def _forget(old: Path) -> None:
    """Another process may have found it meanwhile: then it stays."""
    with lock(old):
        if time.time() - last_use(old) >= RECENT:
            shutil.rmtree(old, ignore_errors=True)
            old.with_suffix(".lock").unlink(missing_ok=True)


def last_use(place: Path) -> float:
    """Seconds; of one that is gone, now."""
    try:
        return place.stat().st_mtime
    except OSError:
        return time.time()
