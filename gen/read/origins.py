"""Where the effects of a scene come from: those that it calls for, and those of its bases that it does not."""
from __future__ import annotations

import os
from dataclasses import dataclass

from ..errors import UsageError
from ..language.spec import Spec
from .catalogue import kind_of, piece
from .flat_text import at
from .load import read_file, reader_of


@dataclass(frozen=True)
class Origin:
    """called: by the scene; kind: energy, torque, damping, bath, pinned, absent; source: of its piece, or file and line."""
    called: bool
    kind: str
    source: str


def origins(path, library=()) -> tuple[Spec, dict[str, Origin]]:
    """A scene, and effect -> its origin, those of the farthest base first. Raises SpecError."""
    name = os.fspath(path)
    reader = reader_of(read_file(name), name, library)
    spec, known = reader.spec(), reader.scene.known
    places = (os.path.dirname(name) or ".", *library)
    return spec, {effect: origin(reader, effect, places) for effect in sorted(known, key=known.get, reverse=True)}


def origin(reader, effect: str, places) -> Origin:
    marks, called = reader.root.marks, effect in reader.scene.called
    place = at(reader.problems.sources, marks[("effects", effect)].key.start)
    keys = {path[2]: mark for path, mark in marks.items() if path[:2] == ("effects", effect) and len(path) == 3}
    if "use" not in keys:
        return Origin(called, kind_of(keys), place)
    try:
        used = piece(keys["use"].text.value, places)
    except UsageError:
        return Origin(called, "", place)
    return Origin(called, used.kind, f"{used.name}: {used.source}" if used.source else used.name)
