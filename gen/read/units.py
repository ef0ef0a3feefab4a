"""[units], and values with units: `energy = "meV"`, `J = "5.7 meV"`."""
from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np

from ..language import codes, limits
from ..language.units import KINDS, NONE, Scale, Unit, Units, coherent, said
from .parse import Parser
from .problems import Problems
from .quantities import exact, fits, whole_quantity, whole_unit
from .source import Span, Text
from .tree import Node

KEYS = (*KINDS, "dimensionless")
NEEDED = 'give an energy, `energy = "meV"`, or an angular momentum and a time'


class UnitsReader:
    """Reads [units]; None where numbers have none."""

    def __init__(self, problems: Problems):
        self.problems = problems

    def read(self, section: Node) -> Units | None:
        section.table(*KEYS)
        if section.has("dimensionless") and section.get("dimensionless").flag():
            return self.plain(section)
        named = dict(self.problems.together(*(lambda k=kind: (k, self.scale(section.get(k), k)) for kind in KINDS if section.has(kind))))
        scales = coherent(named)
        if scales is None and section.raw:
            self.problems.fail(codes.MISSING, section.key, "[units] does not determine a unit of energy", NEEDED)
        return scales and Units(scales, tuple(named.items()))

    def plain(self, section: Node) -> None:
        for child in section.items():
            if child.name in KINDS:
                child.wrong(codes.CONFLICT, f"`{child.label}` is a unit, but `dimensionless` means that there are none", "keep one of them")

    def scale(self, node: Node, kind: str) -> Scale:
        return Scale(node.string().strip(), of_dimension(node, KINDS[kind], f"the unit of {said(KINDS[kind])}"))


def of_dimension(node: Node, dimension, what: str) -> Unit:
    """The unit that a text names, of this dimension."""
    found = unit_of(node.text(), node.problems)
    if found.dimension != dimension:
        node.wrong(codes.DIMENSION, f"`{node.raw}` cannot be {what}: it is {said(found.dimension)}", f"{said(dimension)} is needed here")
    return found


def unit_of(text: Text, problems: Problems) -> Unit:
    """`meV`, `kg m^2`, `4 meV`."""
    return read_by(whole_unit, text, problems)


def quantity_of(text: Text, problems: Problems) -> Unit:
    """`1.5 meV`, as the factor and the dimension of a unit."""
    return read_by(whole_quantity, text, problems)


def read_by(reader, text: Text, problems: Problems) -> Unit:
    fits(text, problems)
    parser = Parser(text, problems)
    if parser.now.kind == "end":
        problems.fail(codes.SYNTAX, text.whole, "the text is empty", "write a unit, such as `meV`")
    parser.text = "the value"
    return reader(parser)


class Measure:
    """Reads numbers that have one dimension, those of a parameter or of a list: bare ones count in its `unit`, texts have their own.

    unit: the key of that name, None where there is none; dimension: None as long as it is not known.
    """

    bare = ""       # why a number of no dimension needs a unit

    def __init__(self, units: Units | None, unit: Node | None = None):
        self.units = units
        self.unit = unit_of(unit.text(), unit.problems) if units and unit is not None else None
        self.dimension = self.unit and self.unit.dimension

    def needed(self, unit: Node | None, dimension, what: str) -> None:
        """Only numbers of this dimension from now on."""
        if self.unit and self.dimension != dimension:
            unit.wrong(codes.DIMENSION, f"`{unit.raw}` cannot be {what}: it is {said(self.dimension)}", f"{said(dimension)} is needed here")
        self.dimension = dimension

    def rows(self, node: Node, rows: list[tuple]) -> list[tuple]:
        """The numbers of a table, which have the unit of `unit`, in the units of the model, each rounded once."""
        if self.units is not None and self.unit is None:
            self.same(node, NONE)
        factor = Fraction(1) if self.units is None or self.unit is None else self.units.factor(self.unit)
        if factor == 1:
            return [tuple(map(float, row)) for row in rows]
        above, below = factor.as_integer_ratio()

        def scaled(value) -> float:
            n, d = Decimal(repr(value)).as_integer_ratio()
            return n * above / (d * below) if n else float(value)       # a quotient of integers is rounded once
        return self.fitting(node, lambda: [tuple(map(scaled, row)) for row in rows])

    def fitting(self, node: Node, made) -> list[tuple]:
        """made(), which is refused if a number is out of range."""
        try:
            found = made()
            sizes = np.abs(np.array(found, float))
        except OverflowError:
            sizes = np.array([np.inf])
        if np.any(sizes > limits.LARGEST) or np.any((sizes > 0) & (sizes < limits.SMALLEST)):
            out_of_range(node.span, node.problems)
        return found

    def number(self, node: Node):
        """A value in the units of the model."""
        if self.units is None:
            return node.number()
        if isinstance(node.raw, str):
            return self.scaled(node, quantity_of(node.text(), node.problems))
        value = node.number()
        if self.bare and self.dimension == NONE and value:
            node.wrong(codes.MEASURE, self.bare, "write a unit after the number, such as `30 deg`")
        if self.unit is not None:
            return self.scaled(node, Unit(exact(value), NONE) * self.unit)
        if value != 0:
            self.same(node, NONE)
        return value

    def scaled(self, node: Node, found: Unit) -> float:
        self.same(node, found.dimension)
        return in_units(found, self.units, node.span, node.problems)

    def same(self, node: Node, dimension) -> None:
        if self.dimension not in (None, dimension):
            hint = "write it without a unit, or the others with one" if self.dimension == NONE else f"give {said(self.dimension)}, with its unit"
            node.wrong(codes.DIMENSION, f"`{node.label}` is {said(dimension)} where {said(self.dimension)} is needed", hint)
        self.dimension = dimension

    @property
    def of_angles(self) -> str:
        """`rad` where bare numbers count in another unit without a dimension, such as degrees."""
        return "rad" if self.unit is not None and self.unit.dimension == NONE and self.unit.factor != 1 else ""

    @property
    def found(self) -> tuple:
        return self.dimension or NONE


def in_units(found: Unit, units: Units, span: Span, problems: Problems) -> float:
    """How many units of the model a quantity is, rounded once."""
    exact_value = units.factor(found)
    if abs(exact_value) > limits.LARGEST or 0 < abs(exact_value) < limits.SMALLEST:
        out_of_range(span, problems)
    return float(exact_value)


def out_of_range(span: Span, problems: Problems) -> None:
    problems.fail(codes.NUMBER, span, f"in the units of this spec this is not between {limits.SMALLEST:g} and {limits.LARGEST:g} in absolute value",
                  "choose other units in [units]")
