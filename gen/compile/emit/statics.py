"""The static functions of a model as data: what nothing calls is left out before anything is printed."""
from __future__ import annotations

import re
from dataclasses import dataclass

WORD = re.compile(r"\w+")


@dataclass(frozen=True)
class Static:
    """A function, type or table: its name, its C text with the comment, and whether it stays when nothing here mentions it."""
    name: str
    text: str
    wanted: bool = False


def needed_statics(statics, rest: str) -> list:
    """Those that are wanted, or mentioned by `rest` or by a later one that stays; a function follows what it calls."""
    mentioned, kept = set(WORD.findall(rest)), []
    for static in reversed(statics):
        if static.wanted or static.name in mentioned:
            kept.append(static)
            mentioned.update(WORD.findall(static.text))
    return kept[::-1]
