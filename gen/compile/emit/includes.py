"""Which headers a text includes, once `#if SMG_NAME` has been decided by the macros that a model defines."""
from __future__ import annotations

import re

DEFINE = re.compile(r"^#define (SMG_\w+) (-?\d+)$", re.MULTILINE)
INCLUDE = re.compile(r'[ \t]*#[ \t]*include[ \t]*"([A-Za-z0-9_.]+)"')
TEST = re.compile(r"#(?:el)?if (!?)(SMG_\w+)( && [^|]+)?$")
GUARD = re.compile(r"#ifndef (SMG_\w+)$")


def macros_of(source: str) -> dict:
    """Name -> number of the macros that a generated file defines."""
    return {name: int(value) for name, value in DEFINE.findall(source)}


def decided(line: str, macros: dict) -> bool | None:
    """What a test of a single macro of the runtime comes to, or of one and more where that one does not hold; None: another one."""
    guard = GUARD.match(line)
    if guard and guard[1] in macros:
        return False
    test = TEST.match(line)
    if test is None:
        return None
    holds = (macros.get(test[2], 0) == 0) == bool(test[1])
    return None if holds and test[3] else holds


def active_lines(text: str, macros: dict):
    """(line, whether it is compiled): tests that are not decided count as true, of the first branch and of those after it."""
    stack, held, sure = [True], [True], [True]      # this branch; one of those so far; one that is decided
    for line in text.splitlines():
        word = line.split(None, 1)[0] if line.strip() else ""
        if word.startswith("#if"):
            for one in (stack, held, sure):
                one.append(False)
        elif word == "#endif":
            for one in (stack, held, sure):
                one.pop()
        if word.startswith("#if") or word == "#elif":
            holds = decided(line, macros)
            stack[-1] = not sure[-1] and holds is not False
            held[-1], sure[-1] = held[-1] or stack[-1], sure[-1] or holds is True
        elif word == "#else":
            stack[-1] = not held[-1]
        yield line, all(stack)


def included(text: str, macros: dict) -> list[str]:
    """The names in its active `#include "name"` lines, in their order."""
    found = [INCLUDE.match(line) for line, active in active_lines(text, macros) if active]
    return [match[1] for match in found if match]
