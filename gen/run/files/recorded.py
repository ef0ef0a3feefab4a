"""From the metadata of a result back to the spec and the settings that made it."""
from __future__ import annotations

import tempfile
from pathlib import Path

from ...errors import UsageError
from .options import OPTIONS


def recorded(meta: dict):
    """(spec, run's name, settings) of a result's metadata, as `received.checked` gives it. Raises UsageError, SpecError."""
    return spec_of(meta["sources"], meta["spec"]), meta["run"] or None, {option.name: meta[option.key] for option in OPTIONS if option.kind}


def spec_of(sources, name: str):
    """Read the spec of this name from its recorded texts: the spec itself first, then files it names. Raises UsageError, SpecError."""
    from ...read import load
    from ...read.files import LIBRARY
    with tempfile.TemporaryDirectory(prefix="smidgen-") as folder:
        try:
            path = _written(Path(folder), sources, name)
        except (OSError, ValueError) as problem:
            raise UsageError(f"the spec in the metadata cannot be read: {problem}") from None
        return load(str(path), [Path(folder, LIBRARY)], recorded=True)


def _written(folder: Path, sources, name: str) -> Path:
    """The path of the spec, when all files lie in `folder`; a scene has its name from its file."""
    if not sources:
        raise ValueError("the text of the spec is missing")
    paths = [_inside(folder, name) for name in (f"{name}.toml", *(other for other, _ in sources[1:]))]
    for path, (_, text) in zip(paths, sources):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="")
    return paths[0]


def _inside(folder: Path, name: str) -> Path:
    """A recorded name is data: it must stay in the folder made for it."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"{name!r} is outside the folder of the spec")
    return path
