"""Files that a kill, a power cut or a full disk leaves whole: the old one or the new one."""
from __future__ import annotations

import os
from pathlib import Path

from ...system import NO_LINK, sync_folder

FRESH = ".new"      # the ending of a file that is not complete


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
