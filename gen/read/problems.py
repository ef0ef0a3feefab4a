"""Collects the errors of a spec: up to ten, each place once, then stops."""
from __future__ import annotations

import difflib
from contextlib import contextmanager

from ..errors import Diagnostic, SpecError
from ..language import limits
from ..language import codes
from ..public import by_its_end
from .source import Source, Sources, Span


class Bad(Exception):
    """What was being read is wrong; the error is already noted."""


class TooBig(Bad):
    """A formula beyond a limit: nothing more of it is looked at."""


class Problems:
    """The errors found so far in a spec; `source`: its own file, to which those that it builds on are added; recorded: by a result,
    where a key may have its name of an earlier version."""

    def __init__(self, source: Source, recorded: bool = False):
        self.sources, self.recorded = Sources(source), recorded
        self.found: list[Diagnostic] = []
        self.seen: set = set()
        self.measured = False       # units may follow numbers in formulas
        self.defaults: dict = {}    # place of an effect's `use` -> the arguments that its piece has by default
        self.places: dict = {}      # (formula's place, Expr) -> place of that part

    def note(self, code: str, span: Span, cause: str, hint: str) -> None:
        """Record an error; raises SpecError when there are too many to be useful."""
        place = (code, span) if code != codes.MISSING else (code, span, cause)     # a table may lack several keys
        if place in self.seen:
            return
        self.seen.add(place)
        if len(self.found) == limits.ERRORS:
            raise SpecError(self.ordered(), more=True)
        file = self.sources.of(span.start)
        line, column = file.place(span.start - file.begin)
        text = file.line(line)
        length = max(1, min(span.end - span.start, len(text) - column + 1))
        self.found.append(Diagnostic(code, file.name, line, column, text, cause, self.of_default(span, cause) + hint, length))

    def of_default(self, span: Span, cause: str) -> str:
        """What to give where a default of a piece does not fit the scene."""
        return "".join(f"that is the default of `{a}`, so give `{a} = ...`; " for a, value in self.defaults.get(span.start, {}).items() if f"`{value}`" in cause)

    def fail(self, code: str, span: Span, cause: str, hint: str):
        """Record an error and leave what is being read."""
        self.note(code, span, cause, hint)
        raise Bad

    @contextmanager
    def guard(self):
        """Go on with the next item after an error inside."""
        try:
            yield
        except Bad:
            if not self.found:
                raise

    def tried(self, *reads) -> list:
        """What each of the reads gives, Bad itself for those that are wrong."""
        found = []
        for read in reads:
            try:
                found.append(read())
            except Bad:
                found.append(Bad)
        return found

    def together(self, *reads) -> list:
        """The same where nothing is wrong: an error in one read hides none in another."""
        found = self.tried(*reads)
        if any(x is Bad for x in found):
            raise Bad
        return found

    def ordered(self) -> list[Diagnostic]:
        """By file, then by place."""
        names = [file.name for file in self.sources.files]
        return sorted(self.found, key=lambda d: (names.index(d.file), d.line, d.column))

    def finish(self) -> None:
        """Raise SpecError if anything was found."""
        if self.found:
            raise SpecError(self.ordered())


def meant(word: str, known) -> str | None:
    """The known name nearest to `word`, if one is near."""
    folded = {k.lower(): k for k in sorted(known)}
    close = difflib.get_close_matches(word, sorted(known), 1, 0.6)
    return folded.get(word.lower()) or (close[0] if close else None)


def nearest(word: str, known, also=()) -> str:
    """`did you mean ...` for the known name nearest to `word`, or the list of them.

    Names in `also` are guessed, but not listed.
    """
    end = by_its_end(word, known)
    known = sorted(set(known))
    guesses = known + sorted(set(also) - set(known))
    guess = end or meant(word, guesses)
    if guess:
        return f"did you mean `{guess}`?"
    if not known:
        return "nothing of this kind is declared"
    return "known here: " + ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
