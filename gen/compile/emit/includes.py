"""Which headers a text includes, once `#if SMG_NAME` has been decided by the macros that a model defines."""
from __future__ import annotations

import re

DEFINE = re.compile(r"^#define (SMG_\w+) (-?\d+)$", re.MULTILINE)
INCLUDE = re.compile(r'[ \t]*#[ \t]*include[ \t]*"([A-Za-z0-9_.]+)"')
TEST = re.compile(r"#if (!?)(SMG_\w+)$")


def macros_of(source: str) -> dict:
    """Name -> number of the macros that a generated file defines."""
    return {name: int(value) for name, value in DEFINE.findall(source)}


def active_lines(text: str, macros: dict):
    """(line, whether it is compiled): tests of a single macro of the runtime are decided, every other one counts as true."""
    stack = [True]
    for line in text.splitlines():
        word = line.split(None, 1)[0] if line.strip() else ""
        if word.startswith("#if"):
            test = TEST.match(line)
            holds = not test or (macros.get(test[2], 0) == 0) == bool(test[1])
            stack.append(holds)
        elif word in ("#else", "#elif"):
            stack[-1] = not stack[-1] or word == "#elif"
        elif word == "#endif":
            stack.pop()
        yield line, all(stack)


def included(text: str, macros: dict) -> list[str]:
    """The names in its active `#include "name"` lines, in their order."""
    found = [INCLUDE.match(line) for line, active in active_lines(text, macros) if active]
    return [match[1] for match in found if match]
