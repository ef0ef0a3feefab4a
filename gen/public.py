"""What all that is public shares: misspelt keywords, attributes that are only read, short reprs."""
from __future__ import annotations

import difflib
import functools
import html
import inspect
from typing import Callable, TypeVar

from .errors import KeywordError, ReadOnlyError
from .renamed import ATTRIBUTES, KEYWORDS, now

F = TypeVar("F", bound=Callable)
SHOWN = 6       # names that a repr lists
WORDS = 2000    # bytes of text that a notebook shows of one object


def public(function: F) -> F:
    """`function`, which answers a keyword that it has not with the present word for it, or with the nearest that it has."""
    known = [name for name, p in inspect.signature(function).parameters.items() if p.kind != p.VAR_KEYWORD]

    @functools.wraps(function)
    def called(*args, **given):
        for word in given:
            if word not in known:
                raise KeywordError(f"{function.__qualname__}() has no keyword '{word}'{guess(word, known, KEYWORDS)}")
        return function(*args, **given)
    return called


def by_its_end(word: str, names) -> str | None:
    """The first of the names that end in -word."""
    return next((name for name in names if name.endswith(f"-{word}")), None) if word else None


def guess(word: str, known, renamed: dict) -> str:
    """`; it is called ... now`, `; did you mean ...`, or the list of what there is."""
    known = [name for name in known if name != "self"]
    new = now(word, renamed, known)
    if new:
        return f"; it is now called '{new}'"
    close = difflib.get_close_matches(word, known, 1)
    return f"; did you mean '{close[0]}'?" if close else f"; there are: {', '.join(known)}"


class ReadOnly:
    """Each annotated attribute is set once; assigning to it, or to another, says what to call instead.

    Names that begin with `_` are the class's own. INSTEAD: attribute -> what to call.
    """
    INSTEAD = {}

    def __init_subclass__(cls):
        cls._fields = {name for c in cls.__mro__ for name in inspect.get_annotations(c)}

    def __getattr__(self, name):
        """Only asked for what is not there."""
        new = now(name, ATTRIBUTES, {*dir(type(self)), *self._fields})
        raise AttributeError(f"{type(self).__name__} has no attribute '{name}'" + f"; it is now called '{new}'" * bool(new), name=name, obj=self)

    def __setattr__(self, name, value):
        if not name.startswith("_") and (name in vars(self) or name not in self._fields):
            raise ReadOnlyError(self._refusal(name))
        super().__setattr__(name, value)

    def _refusal(self, name: str) -> str:
        kind = type(self).__name__
        if not hasattr(type(self), name) and name not in self._fields:
            known = [n for n in dir(self) if not n.startswith("_") and n != "INSTEAD"]
            return f"{kind} has no attribute '{name}'{guess(name, known, ATTRIBUTES)}"
        instead = self.INSTEAD.get(name, self.INSTEAD.get("", ""))
        return f"'{name}' of {kind} is read-only" + f": {instead}" * bool(instead)


def html_of(words: str) -> str:
    """For notebooks: a text as it stands, as far as it is short."""
    encoded = words.encode()
    cut = encoded[:WORDS].decode(errors="ignore")
    more = "" if len(encoded) <= WORDS else f"\n.. {len(words) - len(cut)} more characters: print() shows them"
    return f"<pre>{html.escape(cut + more)}</pre>"


def few(names) -> str:
    """The first names, and how many there are when that is not all."""
    names = list(names)
    return ", ".join(names[:SHOWN]) + f", .. ({len(names)})" * (len(names) > SHOWN)
