"""Formulas that come from outside a spec: `--h 2*pi/n`, `--set B=pi/4`.

They are read by the grammar of the spec language; nothing else ever interprets them.
"""
from __future__ import annotations

import re
from collections.abc import Mapping

from ..errors import SpecError, UsageError
from ..language import codes, limits
from ..language.evaluate import evaluate
from ..language.expr import Expr
from ..language.spec import Spec
from ..language.units import ANY, NONE, TIME, Units, said, unit
from .formulas import Formulas
from .problems import Problems
from .scope import Declared, Scope
from .source import Source, Text
from .units import in_units, quantity_of


QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+|(?![eE][-+]?\d)))\s*(([A-Za-z][A-Za-z_0]*)[^=]*)\Z", re.ASCII)


class Bare(float):
    """A number of the command line, which stands there without a unit."""


class BareInteger(int):
    """The same of an integer."""


def parts_of(text: str) -> tuple[str, str] | None:
    """(the number, the unit) of a text that begins as a quantity does; None of any other."""
    found = QUANTITY.match(text)
    return (found[1], found[2].strip()) if found and unit(found[3]) else None


def formula(text: str, what: str, parameters=()) -> Expr:
    """A scalar formula of `parameters` (of a spec). Raises UsageError with a caret."""
    return read(text, what, Declared(parameters={p.name: p for p in parameters}, hollow=False), ANY)


def time(text: str, what: str, spec: Spec) -> Expr:
    """A formula of the parameters of a spec: a time, where numbers have units."""
    declared = Declared(parameters={p.name: p for p in spec.parameters}, hollow=False, units=spec.units)
    declared.dimensions = {p.name: spec.units.of("name", p.name) for p in spec.parameters} if spec.units else {}
    return read(text, what, declared, TIME)


def read(text: str, what: str, declared: Declared, wanted) -> Expr:
    if len(text) > limits.STRING:
        raise UsageError(f"{what}: a formula has at most {limits.STRING} characters")
    scope = Scope(declared, what, families=False)
    return told(text, what, lambda place, problems: Formulas(declared, problems).scalar(place, scope, what, wanted), declared.units is not None)


def told(text: str, what: str, reader, measured: bool = True):
    """What a reader makes of a text; its errors as a UsageError with a caret."""
    problems = Problems(Source(text, what))
    problems.measured = measured
    try:
        with problems.guard():
            return reader(Text(text, tuple(range(len(text) + 1))), problems)
        problems.finish()
    except SpecError as error:
        raise UsageError(str(error)) from None


# Values of parameters

def scaled(spec: Spec, parameters: dict) -> dict:
    """Values by name, those in texts, `"1.5 meV"`, in the units of the spec; whatever else is wrong with them is found elsewhere."""
    if not isinstance(parameters, Mapping):
        raise UsageError(f"parameters must be a dictionary of values by name, not {parameters!r}")
    units, known = spec.units, {p.name: p.unit for p in spec.parameters} if spec.units else {}
    return {name: number_of(units, name, value, units.of("name", name), known[name]) if name in known else value for name, value in parameters.items()}


def number_of(units: Units, name: str, value, dimension, unit: str):
    if isinstance(value, (list, tuple)):
        return [number_of(units, name, entry, dimension, unit) for entry in value]
    if isinstance(value, str):
        return told(value, name, lambda text, problems: quantity(text, problems, units, dimension))
    if isinstance(value, (Bare, BareInteger)) and value and unit:
        what = said(dimension) if dimension != NONE else f"in {unit}"
        raise UsageError(f"`{name}` is {what}, but {value} has no unit: write {name}=\"{value} {unit}\"")
    return value


def quantity(text: Text, problems: Problems, units: Units, dimension) -> float:
    found = quantity_of(text, problems)
    if found.dimension != dimension:
        problems.fail(codes.DIMENSION, text.whole, f"{said(dimension)} is needed here, but this is {said(found.dimension)}",
                      f"such as `1 {units.spelt(dimension)}`")
    return in_units(found, units, text.whole, problems)


def constant(text: str, what: str):
    """The value of a formula without names: an int when written as one, else a float."""
    digits = text.strip()
    if digits.lstrip("+-").isdecimal() and digits.isascii() and len(digits) < 20:
        return int(digits)
    return float(evaluate(formula(text.strip(), what), {}))
