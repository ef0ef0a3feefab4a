"""Where each key and value of a TOML text stands, down to the characters of strings.

`tomllib` gives the values and judges the text; this scanner runs over text that is known
to be valid TOML 1.0 and only keeps positions. A path is a tuple of keys and list indices.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from .source import Span, Text

ESCAPES = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", '"': '"', "\\": "\\"}
BARE = set("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-")


@dataclass(frozen=True)
class Mark:
    """key: where the key (or table header) stands; value: where the value does."""
    key: Span
    value: Span
    text: Optional[Text] = None


class Marks:
    """Positions of one valid TOML text; look them up in `at[path]`. begin: the offset of its first character."""

    def __init__(self, text: str, begin: int = 0):
        self.s, self.k, self.begin = text, 0, begin
        self.at: dict[tuple, Mark] = {}
        self.counts: dict[tuple, int] = {}
        self.document()

    # Statements

    def document(self) -> None:
        table: tuple = ()
        while self.blank(newlines=True) < len(self.s):
            if self.s[self.k] == "[":
                table = self.header()
            else:
                self.pair(table)

    def header(self) -> tuple:
        """`[a.b]` or `[[a.b]]`; returns the path of the table it opens."""
        start, double = self.k, self.s.startswith("[[", self.k)
        self.k += 2 if double else 1
        keys = self.key()
        self.k = self.blank() + (2 if double else 1)
        path = self.below((), [name for name, _ in keys][:-1]) + (keys[-1][0],)
        span = self.span(start, self.k)
        for length in range(1, len(keys)):
            self.at.setdefault(path[:length], Mark(keys[length - 1][1], span))
        if double:
            number = self.counts[path] = self.counts.get(path, -1) + 1
            self.at.setdefault(path, Mark(keys[-1][1], span))
            path += (number,)
        self.at[path] = Mark(keys[-1][1], span)
        return path

    def below(self, path: tuple, names) -> tuple:
        """Follow dotted names from `path`; a list of tables means its last member."""
        for name in names:
            path += (name,)
            if path in self.counts:
                path += (self.counts[path],)
        return path

    def pair(self, table: tuple) -> None:
        """`a.b = value`."""
        keys = self.key()
        self.k = self.blank() + 1
        path = table
        for name, span in keys[:-1]:
            path += (name,)
            self.at.setdefault(path, Mark(span, span))
        self.value(path + (keys[-1][0],), keys[-1][1])

    def key(self) -> list[tuple[str, Span]]:
        """A dotted key: each part with its place."""
        parts = []
        while True:
            start = self.blank()
            name = self.word()
            parts.append((name, self.span(start, self.k)))
            if self.blank() >= len(self.s) or self.s[self.k] != ".":
                return parts
            self.k += 1

    def word(self) -> str:
        if self.s[self.k] in "\"'":
            return self.string().value
        start = self.k
        while self.k < len(self.s) and self.s[self.k] in BARE:
            self.k += 1
        return self.s[start:self.k]

    def span(self, start: int, end: int) -> Span:
        return Span(self.begin + start, self.begin + end)

    # Values

    def value(self, path: tuple, key: Span) -> None:
        start, text = self.blank(), None
        c = self.s[self.k]
        if c in "\"'":
            text = self.string()
        elif c == "[":
            self.array(path)
        elif c == "{":
            self.inline(path)
        else:
            self.scalar()
        self.at[path] = Mark(key, self.span(start, self.k), text)

    def scalar(self) -> None:
        while self.k < len(self.s) and self.s[self.k] not in ",]}#\n":
            self.k += 1
        while self.s[self.k - 1] in " \t":
            self.k -= 1

    def array(self, path: tuple) -> None:
        self.k += 1
        number = 0
        while self.s[self.blank(newlines=True)] != "]":
            self.value(path + (number,), self.span(self.k, self.k + 1))
            number += 1
            if self.s[self.blank(newlines=True)] == ",":
                self.k += 1
        self.k += 1

    def inline(self, path: tuple) -> None:
        self.k += 1
        while self.s[self.blank()] != "}":
            self.pair(path)
            if self.s[self.blank()] == ",":
                self.k += 1
        self.k += 1

    # Strings

    def string(self) -> Text:
        quote = self.s[self.k]
        if self.s.startswith(quote * 3, self.k):
            return self.multiline(quote)
        self.k += 1
        chars, offsets = [], []
        while self.s[self.k] != quote:
            offsets.append(self.k)
            chars.append(self.character(quote == '"'))
        return self.close(chars, offsets, 1)

    def multiline(self, quote: str) -> Text:
        self.k += 3
        if self.s[self.k] == "\n":
            self.k += 1
        chars, offsets = [], []
        while not self.ends(quote):
            if quote == '"' and self.continued():
                continue
            offsets.append(self.k)
            chars.append(self.character(quote == '"'))
        return self.close(chars, offsets, 3)

    def ends(self, quote: str) -> bool:
        """Three quotes that no further quote follows: `\"\"\"\"\"` holds two and ends."""
        return (self.s.startswith(quote * 3, self.k)
                and not self.s.startswith(quote * 4, self.k))

    def continued(self) -> bool:
        """A backslash at the end of a line skips all white space that follows."""
        rest = self.k + 1
        while self.s[self.k] == "\\" and self.s[rest] in " \t":
            rest += 1
        if self.s[self.k] != "\\" or self.s[rest] != "\n":
            return False
        while self.s[rest] in " \t\n":
            rest += 1
        self.k = rest
        return True

    def character(self, escapes: bool) -> str:
        c = self.s[self.k]
        self.k += 1
        if c != "\\" or not escapes:
            return c
        c = self.s[self.k]
        self.k += 1
        if c in "uU":
            digits = 4 if c == "u" else 8
            self.k += digits
            return chr(int(self.s[self.k - digits:self.k], 16))
        return ESCAPES[c]

    def close(self, chars, offsets, quotes: int) -> Text:
        offsets.append(self.k)
        self.k += quotes
        return Text("".join(chars), tuple(self.begin + k for k in offsets))

    def blank(self, newlines: bool = False) -> int:
        """Skip blanks, and with `newlines` also line ends and comments; the new offset."""
        while self.k < len(self.s):
            c = self.s[self.k]
            if newlines and c == "#":
                end = self.s.find("\n", self.k)
                self.k = len(self.s) if end < 0 else end
            elif c in " \t" or (newlines and c == "\n"):
                self.k += 1
            else:
                break
        return self.k
