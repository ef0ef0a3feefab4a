"""The tokens of the formula language."""
from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from ..language import codes
from .problems import Problems
from .source import Span, Text

PATTERN = re.compile(r"""
    (?P<blank>[ \t\n]+)
  | (?P<number>(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?)
  | (?P<name>[A-Za-z_][A-Za-z0-9_]*)
  | (?P<op>\*\*|<=|>=|==|!=|[-+*/^().,\[\]<>])
""", re.VERBOSE | re.ASCII)

HINTS = {
    "=": "equality is written `==`", "!": "did you mean `not` or `!=`?",
    "&": "write `and`", "|": "write `norm(w)` for a length, `abs(x)` for a number, `or` "
    "between conditions", "?": "write `if(condition, a, b)`", ":": "write `if(condition, a, b)`",
    "%": "write `mod(a, b)`", "'": "there are no strings in formulas", '"': "there are no "
    "strings in formulas", ";": "a formula is one expression", "{": "use `(` and `)`",
    "}": "use `(` and `)`", "\\": "write the function's name, such as `sin`",
    "\u2212": "write `-`", "\u2013": "write `-`", "\u00b7": "write `*`, or `dot(a, b)`",
    "\u22c5": "write `*`, or `dot(a, b)`", "\u00d7": "write `cross(a, b)`",
    "\u221a": "write `sqrt(x)`", "\u03c0": "write `pi`", "\u00b2": "write `^2`",
    "\u00b5": "write `u` for micro", "\u03bc": "write `u` for micro, or spell it: `mu`", "\u00b0": "write `deg`", "\u00c5": "write `angstrom`", "\u212b": "write `angstrom`",
    "\u00b3": "write `^3`", "\u00bd": "write `1/2`"}


@dataclass(frozen=True)
class Token:
    """kind: 'number', 'name', 'op' or 'end'."""
    kind: str
    text: str
    span: Span


def tokenize(text: Text, problems: Problems) -> list[Token]:
    """All tokens of a formula, with an 'end' token last."""
    tokens, k = [], 0
    while k < len(text.value):
        match = PATTERN.match(text.value, k)
        if match is None:
            stray(text, k, problems)
        if match.lastgroup != "blank":
            tokens.append(Token(match.lastgroup, match.group(), text.span(k, match.end())))
        k = match.end()
    tokens.append(Token("end", "", text.span(k, k)))
    return tokens


def stray(text: Text, k: int, problems: Problems):
    """Report a character that no token starts with."""
    c = text.value[k]
    name = unicodedata.name(c, "no name")
    shown = f"`{c}`" if 32 < ord(c) < 127 else f"U+{ord(c):04X} ({name})"
    plain = unicodedata.normalize("NFKC", c)
    hint = HINTS.get(c, "")
    if not hint and name.startswith("GREEK "):
        hint = f"spell it: `{name.split()[-1].lower().replace('lamda', 'lam')}`"      # lambda is a word of Python
    elif not hint and plain != c and plain.isascii() and plain.strip():
        hint = f"write the ASCII character `{plain}`"
    problems.fail(codes.CHARACTER, text.span(k, k + 1), f"{shown} has no meaning in a formula",
                  hint or "formulas are written in ASCII: letters, digits and + - * / ^ ( ) . ,")
