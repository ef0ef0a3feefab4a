"""Units in formulas and in texts: `1.5 meV`, `2 kg m^2`, and where names that are declared do not stand in the way `0.2 rad/ps`.

    quantity = number term {term}           in a formula; further terms follow by `*` or `/`, where nothing has their name
    unit     = [number] term {["*" | "/"] term}
    term     = name ["^" ["-"] digits]
"""
from __future__ import annotations

import difflib
from fractions import Fraction

from ..language import codes, limits
from ..language.unit_table import PLAIN, PREFIXED
from ..language.units import ONE, Unit, unit
from .source import Span, Text
from .syntax import Name, Number, Operation, Quantity

WORDS = ("and", "or", "not", "of", "on")        # no units
COMMON = (*PLAIN, *PREFIXED, "meV", "ueV", "nm", "um", "ps", "fs", "ns", "us", "ms", "mT", "kg", "THz", "GHz", "MHz", "km", "cm", "mm")
MEANT = {"tesla": "T", "kelvin": "K", "second": "s", "seconds": "s", "joule": "J", "ev": "eV", "mev": "meV", "MEV": "MeV",
         "ang": "angstrom", "Ang": "angstrom", "degree": "deg", "degrees": "deg", "muB": "mu_B", "uB": "mu_B", "kB": "k_B", "Hbar": "hbar", "gauss": "G",
         "metre": "m", "meter": "m", "sec": "s",
         "Nm": "N m", "newton": "N", "hour": "h", "day": "d", "Celsius": "K", "degC": "K"}


def at_unit(parser) -> bool:
    return parser.now.kind == "name" and parser.now.text not in WORDS


def quantity(parser, value, span: Span) -> Quantity:
    """The units that follow a number in a formula."""
    found, end, count = ONE, span, 0
    while at_unit(parser):
        one, end = term(parser)
        found, count = found * one, count + 1
        bounded(parser, count, end)
    return Quantity(value, found, Span(span.start, end.end))


def term(parser) -> tuple[Unit, Span]:
    """One unit and its exponent, with their place."""
    name = parser.take()
    found, exponent, span = known(parser, name), 1, name.span
    if parser.at("^", "**"):
        parser.take()
        sign = -1 if parser.at("-") else 1
        if sign < 0:
            parser.take()
        if parser.now.kind != "number" or not parser.now.text.isdigit():
            parser.fail("the exponent of a unit must be an integer", "such as `s^-1` or `m^2`")
        digits = parser.take()
        span = Span(name.span.start, digits.span.end)
        exponent = sign * bounded_exponent(parser, digits)
    return found ** exponent, span


def bounded_exponent(parser, digits) -> int:
    if len(digits.text) > 4 or int(digits.text) > limits.UNIT_EXPONENT:
        parser.problems.fail(codes.LIMIT, digits.span, f"the exponent of a unit must be at most {limits.UNIT_EXPONENT} in absolute value",
                             "choose another unit")
    return int(digits.text)


def bounded(parser, count: int, span: Span) -> None:
    if count > limits.UNIT_FACTORS:
        parser.problems.fail(codes.LIMIT, span, f"a unit may have at most {limits.UNIT_FACTORS} factors", "choose a simpler unit")


def known(parser, name) -> Unit:
    found = unit(name.text)
    if found is None:
        parser.problems.fail(codes.UNIT, name.span, f"there is no unit `{name.text}`", guess(parser, name.text))
    return found


def guess(parser, name: str) -> str:
    """The unit that was meant, or a product."""
    before = parser.tokens[max(parser.k - 2, 0)]
    times = f"a product is written with `*`: `{before.text}*{name}`" if before.kind == "number" else ""
    near = MEANT.get(name) or "".join(difflib.get_close_matches(name, sorted(COMMON), 1, 0.6))
    if near:
        return f"did you mean the unit `{near}`?"
    return times or "units are written as in `meV`, `ps`, `kg m^2` or `rad/ps`; docs/spec.md lists them"


def whole_quantity(parser) -> Unit:
    """A text that is a number with a unit and nothing else, `-1.5 meV`: how much it is in SI, with its sign, and its dimension."""
    sign = -1 if parser.at("-") else 1
    if parser.at("-", "+"):
        parser.take()
    if parser.now.kind != "number":
        parser.fail(f"a number is missing: {parser.here()}", "a value is a number, followed by a unit: `1.5 meV`")
    value = parser.number_value(parser.take())
    return terms(parser, Unit(sign * exact(value), ONE.dimension))


def whole_unit(parser) -> Unit:
    """A text that is a unit and nothing else, perhaps with a number before it: `4 meV`, `N m s`, `1/ps`."""
    if parser.now.kind != "number":
        return terms(parser, ONE)
    found = whole_quantity(parser)
    if found.factor <= 0:
        parser.problems.fail(codes.NUMBER, parser.tokens[0].span, "a unit must be positive", "such as `meV` or `4 meV`")
    return found


def terms(parser, found: Unit) -> Unit:
    """Times the units that are left."""
    count = 0
    while parser.now.kind != "end":
        sign = -1 if parser.at("/") else 1
        if parser.at("*", "/"):
            parser.take()
        if not at_unit(parser):
            parser.fail(f"the name of a unit is missing: {parser.here()}", "such as `meV`, `kg m^2` or `rad/ps`")
        one, span = term(parser)
        found, count = found * one ** sign, count + 1
        bounded(parser, count, span)
    return found


def exact(value) -> Fraction:
    """A number as it is written: 5.7 is 57/10."""
    return Fraction(value) if isinstance(value, int) else Fraction(repr(value))


def fits(text: Text, problems) -> None:
    """Refuse a text that is too long to be a unit."""
    if len(text.value) > limits.UNIT:
        problems.fail(codes.LIMIT, text.whole, f"the quantity has {len(text.value)} characters; at most {limits.UNIT} are allowed",
                      "choose a simpler unit")


# A unit that goes on behind `*` or `/`

def continued(node, taken) -> Quantity | None:
    """The quantity that a product or quotient is where its left side is one, and its right side a unit whose name nothing has.

    taken: is a name declared here?
    """
    sides, left = [], node
    while isinstance(left, Operation) and left.op in ("*", "/") and len(sides) < limits.UNIT_FACTORS:
        sides.append((left.args[1], 1 if left.op == "*" else -1))
        left = left.args[0]
    if not isinstance(left, Quantity):
        return None
    found = left.unit
    for side, sign in sides:
        one = factor(side, taken)
        if one is None:
            return None
        found *= one ** sign
    return Quantity(left.value, found, node.span)


def factor(node, taken) -> Unit | None:
    """`ps`, `s^2`."""
    exponent = 1
    if isinstance(node, Operation) and node.op == "^":
        node, exponent = node.args[0], whole(node.args[1])
    if not isinstance(node, Name) or exponent is None or abs(exponent) > limits.UNIT_EXPONENT or taken(node.name):
        return None
    found = unit(node.name)
    return found and found ** exponent


def whole(node) -> int | None:
    """The value of an integer literal, with its sign."""
    if isinstance(node, Operation) and node.op == "neg":
        inner = whole(node.args[0])
        return None if inner is None else -inner
    return node.value if isinstance(node, Number) and isinstance(node.value, int) else None
