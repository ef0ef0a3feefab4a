"""What all that is public shares: misspelt keywords, arguments of a wrong type, attributes that are only read, short reprs."""
from __future__ import annotations

import difflib
import functools
import html
import inspect
import numbers
import os
import re
from collections.abc import Iterable, Mapping
from typing import Callable, TypeVar

from .errors import KeywordError, ReadOnlyError, UsageError
from .renamed import ATTRIBUTES, KEYWORDS, now

F = TypeVar("F", bound=Callable)
SHOWN = 6       # names that a repr lists
WORDS = 2000    # bytes of text that a notebook shows of one object


def public(function: F) -> F:
    """`function`, which answers a keyword that it has not with the present word for it, or with the nearest that it has, and an argument
    of a wrong type with what is accepted."""
    known = {name: words(name, p.annotation) for name, p in inspect.signature(function).parameters.items() if p.kind != p.VAR_KEYWORD}

    @functools.wraps(function)
    def called(*args, **given):
        for word in given:
            if word not in known:
                raise KeywordError(f"{function.__qualname__}() has no keyword '{word}'{guess(word, known, KEYWORDS)}")
        least = min(len(args), len(known))
        return function(*map(taken, known, args, known.values()), *args[least:], **{name: taken(name, value, known[name]) for name, value in given.items()})
    return called


# Arguments: what they must be, by the words of their annotations

def is_number(value) -> bool:
    """Whether it is finite, real or an integer is asked by who takes it."""
    return hasattr(value, "__float__") and getattr(value, "ndim", 0) == 0


def is_flag(value) -> bool:
    return isinstance(value, numbers.Real) and value in (0, 1) or type(value).__name__ in ("bool", "bool_")      # those of numpy


def are_names(value) -> bool:
    return isinstance(value, tuple) and all(isinstance(name, str) for name in value)


def are_paths(value) -> bool:
    return isinstance(value, tuple) and all(isinstance(name, (str, os.PathLike)) for name in value)


def is_dictionary(value) -> bool:
    return isinstance(value, Mapping) and all(isinstance(name, str) for name in value)


ACCEPTED = {        # word of an annotation: what it accepts, and how that is seen
    "None": (("None",), lambda value: value is None), "str": (("a string",), lambda value: isinstance(value, str)), "int": (("an integer",), is_number),
    "float": (("a number",), is_number), "bool": (("True", "False"), is_flag), "os.PathLike": (("a path",), lambda value: isinstance(value, os.PathLike)),
    "dict": (("a dictionary",), is_dictionary),
    "Iterable[str]": (("a list of names",), are_names), "Iterable[str | os.PathLike]": (("a list of folders",), are_paths), "Mapping": (("a dictionary",), is_dictionary), "Callable": (("a function",), callable)}
CLASSES = {"Grid": "a Grid, as smidgen.lattice.of returns it", "Integrator": "an Integrator, as smidgen.build returns it", "Result": "a Result", "Spec": "a Spec"}
RUN = "run"         # given by position most often: its own message knows what else may have been meant (find_run)


def words(name: str, annotation) -> tuple[str, ...]:
    """Of the annotation of an argument, such as "Iterable[str] | None"; () where the function itself looks at it."""
    found = re.split(r" \| (?![^\[]*\])", annotation) if isinstance(annotation, str) and name != RUN else ()
    found = tuple(word if word in ACCEPTED or word in CLASSES else word.partition("[")[0] for word in found)
    return found if all(word in ACCEPTED or word in CLASSES for word in found) else ()


def is_a(value, word: str) -> bool:
    return any(kind.__name__ == word for kind in type(value).__mro__) if word in CLASSES else ACCEPTED[word][1](value)


def taken(name: str, value, accepted: tuple[str, ...]):
    """The value of an argument, with names as a tuple. Raises UsageError that says what is accepted."""
    found = names_in(value) if any(word.startswith("Iterable") for word in accepted) else value
    if accepted and not any(is_a(found, word) for word in accepted):
        *some, last = (said for word in accepted for said in (ACCEPTED[word][0] if word in ACCEPTED else (CLASSES[word],)))
        raise UsageError(f"{name} must be {', '.join(some)}{' or ' * bool(some)}{last}, not {value!r:.100}")
    return found


def names_in(value):
    """Names in a list as a tuple; one name may stand alone. What is no list stays."""
    if isinstance(value, (str, os.PathLike)):
        return (value,)
    return tuple(value) if isinstance(value, Iterable) and getattr(value, "ndim", 1) > 0 else value


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
