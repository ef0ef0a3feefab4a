"""Going on after an error of TOML: the statement that is wrong is set aside, with what it was to say.

A line `key = value` becomes `key = 0`, whose key says nothing from then on; a table whose header
is wrong is blanked, and what it names counts as declared. The text keeps its length, so that
places in it stay what they are. Where it is not sure what is wrong, nothing is set aside.
"""
from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Optional

KEY = re.compile(r'[ \t]*("[^"\n]*"|[\w.-]+)[ \t]*=', re.ASCII)
CALL = re.compile(r"[ \t]*\w+[ \t]*\(", re.ASCII)
HEADER = re.compile(r"^[ \t]*\[", re.MULTILINE)
WORD = re.compile(r"\w+", re.ASCII)
MANY_LINES = ('"""', "'''")


@dataclass
class Aside:
    """keys: offsets of keys that say nothing; headers: tables that were blanked, the first of two of one name
    goes with it; names: what was in them."""
    keys: list[int] = field(default_factory=list)
    headers: list[tuple[str, ...]] = field(default_factory=list)
    names: set[str] = field(default_factory=set)


def recovered(text: str, offset: int, message: str, taken: bool, aside: Aside) -> Optional[str]:
    """The text without the statement at `offset`, or None; taken: its key or table is there already."""
    start = text.rfind("\n", 0, offset) + 1
    end = text.find("\n", offset)
    line = text[start:len(text) if end < 0 else end]
    if line.lstrip().startswith("["):
        return without_table(text, start, aside)
    key = KEY.match(line)
    if key and taken:
        return blanked(text, start, start + len(line))
    if key:
        return without_value(text, start, line, key, aside)
    if message.startswith("Expected '='") and not CALL.match(line):     # a formula with arguments: what uses it means nothing without it
        return without_sign(text, start, line, aside)
    return None


def without_sign(text: str, start: int, line: str, aside: Aside) -> str:
    """A line that lacks its `=`: the first word may be the key."""
    aside.names |= set(WORD.findall(line))
    word = WORD.search(line)
    if not word or word.end() + 2 > len(line):
        return blanked(text, start, start + len(line))
    aside.keys.append(start + word.start())
    return text[:start] + f"{' ' * word.start()}{word[0]}=0".ljust(len(line)) + text[start + len(line):]


def without_value(text: str, start: int, line: str, key, aside: Aside) -> Optional[str]:
    """`key = 0` in place of a value that ends on its line."""
    value = line[key.end():]
    if not value or value.count("[") != value.count("]") or any(mark in value for mark in MANY_LINES):
        return None
    aside.keys.append(start + key.start(1))
    return text[:start + key.end()] + "0".ljust(len(value)) + text[start + len(line):]


def without_table(text: str, start: int, aside: Aside) -> Optional[str]:
    """Blanks from a header to the next one."""
    follows = HEADER.search(text, text.find("\n", start) + 1 or len(text))
    end = follows.start() if follows else len(text)
    head, *lines = text[start:end].split("\n")
    if any(mark in line for line in lines for mark in MANY_LINES):
        return None
    aside.headers.append(tuple(part.strip(' \t"[]') for part in head.split(".")))
    aside.names |= {*WORD.findall(head), *(k[1].strip('"') for k in map(KEY.match, lines) if k)}
    return blanked(text, start, end)


def blanked(text: str, start: int, end: int) -> str:
    return text[:start] + re.sub(r"[^\n]", " ", text[start:end]) + text[end:]
