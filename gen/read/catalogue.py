"""What is known of a piece without an effect that uses it: title, source, law, arguments, formulas."""
from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

from ..effects.kinds import KINDS
from ..errors import UsageError
from ..resources import pieces
from .load import read_file
from .pieces import sound
from .problems import Problems, nearest
from .source import Source
from .toml import document



@dataclass(frozen=True)
class Piece:
    """arguments: name -> its table; effect: key -> text, with `$words`."""
    name: str
    path: str
    title: str
    source: str
    law: str
    arguments: dict[str, dict]
    effect: dict[str, object]
    test: dict[str, object] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        return kind_of(self.effect)


def kind_of(keys) -> str:
    """What an effect with these keys is: the key by which its kind is known; with a temperature, a bath."""
    return "bath" if "kT" in keys else next((key for kind in KINDS for key in kind.told_by if key in keys), "")


def catalogue(library=()) -> dict[str, Path]:
    """name -> path of all pieces: of these folders, then those that come with smidgen."""
    found = pieces()
    for folder in reversed([Path(place) for place in library]):
        found.update({p.relative_to(folder).with_suffix("").as_posix(): p for p in sorted(folder.rglob("*.toml")) if is_piece(p)})
    return dict(sorted(found.items()))


def is_piece(path: Path) -> bool:
    """A folder of the user holds specs and other files, too."""
    try:
        return any(line.strip() == "[piece]" for line in path.read_text(encoding="utf-8").splitlines())
    except (OSError, UnicodeDecodeError):
        return False


def piece(name: str, library=()) -> Piece:
    """One piece. Raises UsageError for a name that is none, SpecError for a file with errors."""
    known = catalogue(library)
    if name not in known:
        raise UsageError(f"there is no piece '{name}'; {nearest(name, known)}")
    path = os.fspath(known[name])
    problems = Problems(Source(read_file(path), path, folder=os.path.dirname(path)))
    root = next(iter(problems.tried(lambda: sound(document(problems.sources.files[0], problems)[0]))))
    problems.finish()
    says = root.raw["piece"]
    return Piece(name, path, says["title"], says.get("source", ""), says.get("law", ""), says.get("arguments", {}), root.raw["effect"], root.raw.get("test", {}))
