"""What nothing calls leaves nothing in the C: static functions and tables without a user are dropped.

Kernels and templates offer a function wherever a method may want it; only the whole model
tells which are wanted. Emitted functions start at the beginning of a line with `static`,
after a comment or none, and end with `}` at the beginning of a line; tables are one line.
"""
from __future__ import annotations

import re
from collections import Counter

_COMMENT = r"^(?:/\*(?:[^*]|\*(?!/))*\*/\n)?"
_FUNCTION = re.compile(_COMMENT + r"static (?:inline )?(?:const )?\w+ \*?(\w+)\([^;{]*\) \{\n(?:.*\n)*?\}\n+",
                       re.MULTILINE)
_TABLE = re.compile(_COMMENT + r"static const \w+ (\w+)(?:\[\w*\])+ = .*;\n", re.MULTILINE)
_WORD = re.compile(r"\w+")


def without_uncalled(text: str) -> str:
    """C text without the static functions and tables whose name it mentions nowhere else."""
    while True:
        count = Counter(_WORD.findall(text))
        kept = text
        for kind in (_FUNCTION, _TABLE):
            kept = kind.sub(lambda f: "" if count[f[1]] == own_mentions(f) else f[0], kept)
        if kept == text:
            return text
        text = kept


def own_mentions(function) -> int:
    """How often a function and its comment say its name."""
    return sum(word == function[1] for word in _WORD.findall(function[0]))
