"""The specs that come with smidgen, and how a SPEC on the command line is found."""
from __future__ import annotations

import difflib
import functools
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Protocol, TypeVar, Union, runtime_checkable

from .. import read
from ..errors import UsageError
from ..language.spec import Spec
from ..public import public
from ..resources import scenes, shipped

F = TypeVar("F", bound=Callable)


@runtime_checkable
class Written(Protocol):
    """What can be read as a spec: a Model."""
    def spec(self) -> Spec: ...


SpecLike = Union[Spec, str, os.PathLike, Written]       # a Spec, the path of a file or the name of a spec that comes with smidgen, a Model


def find_spec(word: str) -> Path:
    """The file that `word` means: a path, or the name of a shipped spec."""
    path, known = Path(word), {**shipped(), **scenes()}
    if path.is_file() or os.sep in word or word.endswith(".toml"):
        return path
    if word in known:
        return known[word]
    close = difflib.get_close_matches(word, known, 1)
    hint = f"did you mean '{close[0]}'?" if close else "`smidgen list` shows the specs that come with smidgen"
    raise UsageError(f"'{word}' is neither a file nor a shipped spec; {hint}")


@public
def load(spec: str | os.PathLike, library: Iterable[str | os.PathLike] = ()) -> Spec:
    """Read a spec.

    :param spec: the path of a TOML file, or the name of a spec that comes with smidgen.
    :param library: additional folders in which to look for files that the spec names; its own folder is searched first.
    :raises UsageError: if there is no such file or name.
    :raises SpecError: if the file cannot be read or contains errors; the exception lists up to ten of them.
    """
    return read.load(find_spec(spec) if isinstance(spec, str) else spec, library)


@public
def flat(spec: str | os.PathLike, library: Iterable[str | os.PathLike] = ()) -> str:
    """The text of a scene as a single spec, with everything it takes from its bases and pieces and a comment on where each value comes
    from.

    The arguments and errors are those of `load`. Reading the text, next to the same data files, gives the same model.
    """
    return read.shown(find_spec(spec) if isinstance(spec, str) else spec, library)


load_spec = load        # under the name that the commands use


def spec_or_name(function: F) -> F:
    """`function` of a Spec, which also takes what `load` takes, and a Model."""
    @functools.wraps(function)
    def called(spec: SpecLike, *args, **given):
        return function(spec_of(spec), *args, **given)
    return called


def spec_of(spec: SpecLike):
    """The Spec that is meant; what is none of SpecLike is left to who asks."""
    return load(spec) if isinstance(spec, (str, os.PathLike)) else spec.spec() if isinstance(spec, Written) else spec
