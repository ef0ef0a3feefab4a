"""From the metadata of a result back to the spec and the settings that made it."""
from __future__ import annotations

import tempfile
from pathlib import Path

from .errors import UsageError

ASKED = ("start", "method", "solver", "h", "steps", "every", "section", "what", "effects",
         "seed", "real", "native")


def recorded(meta: dict):
    """(spec, run's name, settings) of a result's metadata. Raises UsageError, SpecError."""
    try:
        settings = {**{key: meta[key] for key in ASKED}, "substeps": meta.get("substeps", False)}
        sources = [(str(name), str(text)) for name, text in meta["sources"]]
        return spec_of(sources), meta["run"] or None, {**settings, "values": meta["set"]}
    except (KeyError, TypeError, ValueError) as problem:
        raise UsageError(f"the metadata of this file is not complete: {problem}") from None


def spec_of(sources):
    """Read a spec from its recorded texts: the spec itself first, then files it names."""
    from .read import load
    if not sources:
        raise ValueError("no spec text")
    with tempfile.TemporaryDirectory(prefix="smidgen-") as folder:
        paths = [_inside(Path(folder), "spec.toml")]
        paths += [_inside(Path(folder), name) for name, _ in sources[1:]]
        for path, (_, text) in zip(paths, sources):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="")
        return load(str(paths[0]))


def _inside(folder: Path, name: str) -> Path:
    """A recorded name is data: it must stay in the folder made for it."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"{name!r} leaves the folder of the spec")
    return path
