"""Places in the files of a spec: offsets, spans, and strings that know where they stand.

A spec may build on others. Their texts count as one, one file after the other, so that an offset tells the file too.
"""
from __future__ import annotations

import bisect
from dataclasses import dataclass


@dataclass(frozen=True)
class Span:
    """Characters [start, end) of all texts."""
    start: int
    end: int


class Source:
    """The text of one file with its name, and the line and column of an offset in it.

    begin: where it stands among all texts; folder: where the files lie that it names, "" for a text without a file.
    """

    def __init__(self, text: str, name: str, begin: int = 0, folder: str = ""):
        self.text, self.name, self.begin, self.folder = text, name, begin, folder
        self.starts = [0] + [k + 1 for k, c in enumerate(text) if c == "\n"]

    def place(self, offset: int) -> tuple[int, int]:
        """(line, column) of `offset`, both from 1."""
        line = bisect.bisect_right(self.starts, min(offset, len(self.text)))
        return line, offset - self.starts[line - 1] + 1

    def offset(self, line: int, column: int) -> int:
        """Inverse of `place`, clipped to the text."""
        line = min(max(line, 1), len(self.starts))
        return min(self.starts[line - 1] + max(column - 1, 0), len(self.text))

    def line(self, number: int) -> str:
        """The text of line `number` (from 1) without its end."""
        end = self.text.find("\n", self.starts[number - 1])
        return self.text[self.starts[number - 1]:len(self.text) if end < 0 else end]


class Sources:
    """The files of a spec, the first one its own."""

    def __init__(self, first: Source):
        self.files = [first]

    def add(self, text: str, name: str, folder: str) -> Source:
        """One more file, behind the end of the last one."""
        last = self.files[-1]
        self.files.append(Source(text, name, last.begin + len(last.text) + 1, folder))
        return self.files[-1]

    def of(self, offset: int) -> Source:
        """The file in which an offset lies."""
        return self.files[bisect.bisect_right([file.begin for file in self.files], offset) - 1]


@dataclass(frozen=True)
class Text:
    """A string of the spec; character k stands at offset `offsets[k]`.

    `offsets` has one entry more than `value`: where the string ends.
    """
    value: str
    offsets: tuple[int, ...]

    def span(self, start: int, end: int) -> Span:
        """The place of characters [start, end), at least one character wide."""
        first = self.offsets[start]
        return Span(first, max(first + 1, self.offsets[end - 1] + 1 if end > start else 0))

    @property
    def whole(self) -> Span:
        return self.span(0, len(self.value))
