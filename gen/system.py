"""What systems have in different ways: locks between processes, owners of files, folders that can be put on the disk."""
from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path

# Windows has no such flags, and Unix no text files that need the last one.
NO_LINK, NO_WAIT, BYTES = (getattr(os, name, 0) for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_BINARY"))
OPENS_FOLDERS = os.name != "nt"
NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)      # what file systems without locks say
OTHERS = 0o022      # mode bits: group or others may write


def locked(path: Path, mode: int, wait: bool) -> int | None:
    """The handle of a lock, held until it is closed or its process dies; None where another holds it and `wait` is false.

    A link in its place is not followed. A file that was removed while we waited for it is no lock any more. Raises OSError.
    """
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | NO_LINK, mode)
        if not taken(handle, wait):
            os.close(handle)
            return None
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(handle), os.stat(path)):
                return handle
        os.close(handle)


def taken(handle: int, wait: bool) -> bool:
    """Is the lock of an open file ours now? A file system that has no locks refuses nobody."""
    import portalocker
    while True:
        try:
            portalocker.lock(handle, portalocker.LOCK_EX | (portalocker.LockFlags(0) if wait else portalocker.LOCK_NB))
            return True
        except portalocker.LockException as refusal:
            if getattr(refusal.__cause__, "errno", None) in NO_LOCKS:
                return True
            if not wait:
                return False        # with `wait`: Windows gives up after ten seconds


def shared(place: Path) -> str:
    """Why someone else may change what lies in `place`, or nothing. Parents may be as /tmp is: there a folder of ours stays ours.

    Windows has no owners and modes of this kind: its folders of a user are that user's alone.
    """
    if not hasattr(os, "getuid"):
        return ""
    for status in (place.lstat(), place.stat()):
        if status.st_uid != os.getuid():
            return f"it belongs to user {status.st_uid}, not to {os.getuid()}"
    return f"it can be written by others (mode {status.st_mode & 0o7777:o})" if status.st_mode & OTHERS else ""


def sync_folder(folder: Path) -> None:
    """Put the names in `folder` on the disk: only then does a rename outlast a power cut. Windows opens no folders, and writes names at once."""
    if not OPENS_FOLDERS:
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
