"""Files that a kill, a power cut or a full disk leaves whole: the old one or the new one."""
from __future__ import annotations

import errno
import os
from pathlib import Path

from ...errors import OutputError
from ...system import NO_LINK, sync_folder

FRESH = ".new"      # the ending of a file that is not complete


def check_place(path: Path) -> None:
    """Raises OutputError where no file can have this name: before the work whose result it is to hold."""
    wrong = errno.EISDIR if path.is_dir() else errno.ENOENT if not path.parent.is_dir() else None
    if wrong:
        raise OutputError(f"cannot write {path}: {os.strerror(wrong)}")


def write_new(path: Path, data: bytes, name_too: bool = True) -> None:
    """Write `data` beside `path`, put it on the disk, then give it its name. Raises OSError;
    what `path` was before is then as it was. name_too: put the name on the disk as well."""
    fresh = path.with_name(path.name + FRESH)
    try:
        with open(fresh, "wb", 0, opener=_not_through_a_link) as out:
            _write_all(out, memoryview(data))
            os.fsync(out.fileno())
        os.replace(fresh, path)
    except OSError:
        fresh.unlink(missing_ok=True)
        raise
    if name_too:
        sync_folder(path.parent)


def _not_through_a_link(path, flags):
    return os.open(path, flags | NO_LINK, 0o666)


def _write_all(out, data):
    while len(data):
        data = data[out.write(data):]
