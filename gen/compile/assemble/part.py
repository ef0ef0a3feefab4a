"""A part: what a layout, a method, a feature or an effect adds to the C of a model. `parts.py` lists them; nothing else knows one by its name."""
from __future__ import annotations

from dataclasses import dataclass

from ..lower.code import Call, Member, Name, Unary
from ..lower.integers import Int, whole

MOST_LANES = 8      # of a row or an ensemble: the widest registers there are


@dataclass(frozen=True)
class Buffer:
    """An array of the state: how many numbers, and what they mean."""
    name: str
    size: Int
    meaning: str


def buffer(name: str, size, meaning: str) -> Buffer:
    return Buffer(name, whole(size), meaning)


def placed(b: Buffer, used) -> Call:
    """It begins behind `used` numbers; how many there are with it."""
    return Call("smg_place_array", (Unary("&", Member("s", b.name)), Name("mem"), used, Unary("(size_t)", b.size)))


class Part:
    """A model that has the part holds what `made` found under `name`, None without it; all else is asked of models that have it."""
    name = ""
    layout = ""     # that a model may have with it, of gen/compile/plan/layout.py
    templates: dict = {}    # what it adds to the shell of a model: "structs" (before the state), "between" (functions between steps), "public" (others) of
    #                         the header, "bodies" of their bodies, "flat" of the functions for ctypes -> the file of templates/
    divides = False         # sums of all sites among ranks
    types: tuple = ()       # of the header, which runtime headers call smg_<word>

    def made(self, model, low):
        """What the part is made of, its kernels first; None where the model has no use for it. low: where what is computed before steps is kept."""
        raise NotImplementedError

    def first(self, model) -> list:
        """Definitions that kernels mention."""
        return []

    def held(self, model) -> list:
        """Members of the coefficients, (declaration, meaning)."""
        return []

    def fits(self, model) -> None:
        """Raises UsageError where the model cannot have it."""

    def functions(self, model) -> list:
        """Definitions, each behind those that it mentions."""
        return []

    def headers(self, model) -> list:
        """Of the runtime, that its functions are written with."""
        return []

    def included(self, model) -> list:
        """Headers of the runtime that the public header needs."""
        return []

    def settings(self, model) -> dict:
        """Macros that are not 0, and those that C itself reads, whatever they are."""
        return {}

    def buffers(self, model) -> list:
        """Arrays of the state."""
        return []

    def members(self, model) -> list:
        """Other members of the state, (declaration, meaning)."""
        return []

    def slots(self, model) -> dict:
        """What its templates are filled with."""
        return {}

    def first_members(self, model) -> list:
        """Members of the state behind its coefficients: declarations."""
        return []

    def around(self, model) -> list:
        """Arrays of a map around the step, or of all methods, by whatever layout."""
        return []

    def instead(self, model) -> list:
        """Arrays in place of those of the method."""
        return []

    def laid_out(self, model) -> tuple:
        """Statements before the arrays are laid out one after the other."""
        return ()

    def history(self, model) -> int:
        """Increments that are kept; 0: as the method has it."""
        return 0

    def sizes(self, model, value) -> dict:
        """Function of the runtime that an array of its is as large as -> how large that is, of the arguments; value: the number that a size is."""
        return {}

    def numbers(self, model, value) -> int:
        """Those of its arrays by a layout of its own, at most; 0: by the other arrays alone."""
        return 0

    def own_history(self, model) -> bool:
        """Does the history stand in a buffer of the part, in place of rows of its own?"""
        return False

    def step(self, model) -> str:
        """The header of the step of a midpoint; "": as others have it."""
        return ""

    def behind(self, model) -> list:
        """Headers behind that of the step."""
        return []

    def most(self, model, step):
        """The most that a step, or a stage, can take (`effort.py`), of what it takes without the part."""
        return step

    def most_around(self, model, step):
        """The same of what is around the stages of a step."""
        return step

    def lanes(self, model) -> int:
        """The most lanes that its functions take; 0: none."""
        return 0


def where_true(**settings) -> dict:
    """Those that are not 0."""
    return {name: value for name, value in settings.items() if value}
