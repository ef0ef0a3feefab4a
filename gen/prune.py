"""What nothing calls leaves nothing in the C: static functions without a caller are dropped.

Kernels and templates offer a function wherever a method may want it; only the whole model
tells which are wanted. Emitted functions start at the beginning of a line with `static`,
after a comment or none, and end with `}` at the beginning of a line.
"""
from __future__ import annotations

import re

_FUNCTION = re.compile(r"^(?:/\*(?:[^*]|\*(?!/))*\*/\n)?static (?:inline )?(?:const )?\w+ \*?(\w+)\([^;{]*\) \{\n"
                       r"(?:.*\n)*?\}\n+", re.MULTILINE)
_WORD = re.compile(r"\w+")


def without_uncalled(text: str) -> str:
    """C text without the static functions whose name it mentions nowhere else."""
    while True:
        count: dict = {}
        for word in _WORD.findall(text):
            count[word] = count.get(word, 0) + 1
        kept = _FUNCTION.sub(lambda f: "" if count[f[1]] == own_mentions(f) else f[0], text)
        if kept == text:
            return text
        text = kept


def own_mentions(function) -> int:
    """How often a function and its comment say its name."""
    return sum(word == function[1] for word in _WORD.findall(function[0]))
