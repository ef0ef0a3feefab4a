"""Formulas that come from outside a spec: `--h 2*pi/n`, `--set B=pi/4`.

They are read by the grammar of the spec language; nothing else ever interprets them.
"""
from __future__ import annotations

from ..errors import SpecError, UsageError
from ..language import limits
from ..language.evaluate import evaluate
from ..language.expr import Expr
from .formulas import Formulas
from .problems import Problems
from .scope import Declared, Scope
from .source import Source, Text


def formula(text: str, what: str, parameters=()) -> Expr:
    """A scalar formula of `parameters` (of a spec). Raises UsageError with a caret."""
    if len(text) > limits.STRING:
        raise UsageError(f"{what}: a formula has at most {limits.STRING} characters")
    declared = Declared(parameters={p.name: p for p in parameters}, hollow=False)
    problems = Problems(Source(text, what))
    place = Text(text, tuple(range(len(text) + 1)))
    try:
        with problems.guard():
            return Formulas(declared, problems).scalar(place, Scope(declared, what, families=False))
        problems.finish()
    except SpecError as error:
        raise UsageError(str(error)) from None


def constant(text: str, what: str):
    """The value of a formula without names: an int when written as one, else a float."""
    digits = text.strip()
    if digits.lstrip("+-").isdecimal() and digits.isascii() and len(digits) < 20:
        return int(digits)
    return float(evaluate(formula(text.strip(), what), {}))
