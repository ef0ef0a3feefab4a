"""Units and dimensions: what a spec with [units] counts its numbers in.

A dimension is four exponents, of energy, time, length and field; of a square root they may be fractions. A model works in a coherent
set of units, one for each of the four, so that formulas need no conversion factor: every value is divided by its unit once, when it is read.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from .unit_table import CODATA, HBAR, MU_B, size_of

BASES = ("energy", "time", "length", "field")
NONE = (Fraction(0),) * 4
ENERGY, TIME, LENGTH, FIELD = (tuple(Fraction(j == k) for j in range(4)) for k in range(4))
ANY = None          # of a literal 0, which is an energy as well as a time


def product(a, b):
    return ANY if ANY in (a, b) else tuple(x + y for x, y in zip(a, b))


def power(a, exponent):
    return ANY if a is ANY else tuple(x * exponent for x in a)


def quotient(a, b):
    """0 divided by anything is 0; what is divided by an unknown dimension has none that is known."""
    return ANY if ANY in (a, b) else product(a, power(b, -1))


MOMENT, ACTION = quotient(ENERGY, FIELD), product(ENERGY, TIME)
RATE = power(TIME, -1)
KINDS = {**dict(zip(BASES, (ENERGY, TIME, LENGTH, FIELD))), "moment": MOMENT, "angular_momentum": ACTION}       # keys of [units]
SAID = {NONE: "a number without a unit", ENERGY: "an energy", TIME: "a time", LENGTH: "a length", FIELD: "a field", MOMENT: "a moment",
        ACTION: "an angular momentum", RATE: "a rate (1/time)", quotient(LENGTH, TIME): "a velocity"}


def said(dimension) -> str:
    """`an energy`; `energy/length^2`."""
    return "any quantity" if dimension is ANY else SAID.get(dimension) or spelt_of(zip(BASES, dimension))


def spelt_of(powers) -> str:
    """(word, exponent), .. -> `meV ps`, `meV/nm/T`, `1/ps^2`."""
    above, below = [], []
    for word, exponent in powers:
        if exponent:
            size = abs(exponent)
            shown = word if size == 1 else f"{word}^{size}" if size.denominator == 1 else f"{word}^({size})"
            (above if exponent > 0 else below).append(shown)
    return "/".join((" ".join(above) or "1", *below))


@dataclass(frozen=True)
class Unit:
    """factor * J^a s^b m^c T^d, the exponents its dimension."""
    factor: Fraction
    dimension: tuple

    def __mul__(self, other: Unit) -> Unit:
        return Unit(self.factor * other.factor, product(self.dimension, other.dimension))

    def __pow__(self, exponent: int) -> Unit:
        return Unit(self.factor ** exponent, power(self.dimension, exponent))


ONE = Unit(Fraction(1), NONE)


def unit(name: str) -> Unit | None:
    """A unit of the table by its name; None where there is none."""
    size = size_of(name)
    return size and Unit(size[0], tuple(map(Fraction, size[1:])))


@dataclass(frozen=True)
class Scale:
    """A unit with its name."""
    text: str
    unit: Unit

    @property
    def factor(self) -> Fraction:
        return self.unit.factor


@dataclass(frozen=True)
class Units:
    """scales: the coherent set, in the order of BASES; named: all that [units] names; dimensions: by (what, name),
    of parameters and of the vectors of families ("name"), and of the momentum and the Casimir of a family."""
    scales: tuple[Scale, ...]
    named: tuple[tuple[str, Scale], ...] = ()
    dimensions: tuple = ()
    codata: str = CODATA

    def size(self, dimension) -> Fraction:
        """The unit of a dimension in SI; the exponents are integers."""
        return math.prod((scale.factor ** int(k) for scale, k in zip(self.scales, dimension)), start=Fraction(1))

    def factor(self, given: Unit) -> Fraction:
        """How many units of the model a given one is."""
        return given.factor / self.size(given.dimension)

    def spelt(self, dimension) -> str:
        """The unit of a dimension: by a name that has just this size, else by those of the four."""
        if all(k.denominator == 1 for k in dimension):
            size = self.size(dimension)
            for scale in (*(scale for _, scale in self.named), *self.scales, *KNOWN):
                if (scale.factor, scale.unit.dimension) == (size, dimension):
                    return scale.text
        return spelt_of((scale.text if scale.text.isidentifier() else f"({scale.text})", k) for scale, k in zip(self.scales, dimension))

    def shown(self, dimension) -> Scale:
        """In which unit an observable of this dimension is told: the one that [units] names for it, else that of the model."""
        for _, scale in self.named:
            if scale.unit.dimension == dimension:
                return scale
        return Scale(self.spelt(dimension), Unit(self.size(dimension) if integral(dimension) else Fraction(1), dimension))

    def share(self, shown: Scale) -> float:
        """How many units of the model that one is, an unknown root of them as 1."""
        return float(self.factor(shown.unit)) if integral(shown.unit.dimension) else 1.0

    def of(self, what: str, name: str):
        """A dimension; none where nothing has this name."""
        return dict(self.dimensions).get((what, name), NONE)


def integral(dimension) -> bool:
    return all(k.denominator == 1 for k in dimension)


KNOWN = tuple(Scale(text, unit(text)) for text in ("hbar", "mu_B", "J", "T"))


def coherent(named: dict[str, Scale]) -> tuple[Scale, ...] | None:
    """The four scales that follow from those that [units] names; None where no energy does.

    energy: as named, else angular momentum/time, else moment*field; time: angular momentum/energy, else hbar/energy; field: energy/moment,
    else energy/mu_B; length: the metre.
    """
    energy = named.get("energy") or ratio(named, "angular_momentum", "time") or times(named, "moment", "field")
    if energy is None:
        return None
    time = named.get("time") or over(named.get("angular_momentum") or Scale("hbar", Unit(HBAR, ACTION)), energy)
    field = named.get("field") or over(energy, named.get("moment") or Scale("mu_B", Unit(MU_B, MOMENT)))
    return energy, time, named.get("length") or Scale("m", unit("m")), field


def ratio(named: dict, above: str, below: str) -> Scale | None:
    return over(named[above], named[below]) if above in named and below in named else None


def times(named: dict, a: str, b: str) -> Scale | None:
    return Scale(f"{named[a].text} {named[b].text}", named[a].unit * named[b].unit) if a in named and b in named else None


def over(a: Scale, b: Scale) -> Scale:
    """a/b, under a name of its own where it has one."""
    found = a.unit * b.unit ** -1
    known = [scale.text for scale in KNOWN if scale.unit == found]
    below = b.text if b.text.isidentifier() else f"({b.text})"
    return Scale(known[0] if known else f"{a.text}/{below}", found)
