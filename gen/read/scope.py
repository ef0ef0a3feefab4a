"""What a name means where a formula stands."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Optional

from ..language.expr import Expr, Num
from ..language.spec import Family, Parameter
from ..language.units import NONE, Units
from .source import Span
from .syntax import Syntax


@dataclass(frozen=True)
class Typed:
    """A resolved expression with its kind ('s', 'v', 'b') and size.

    nodes and depth count the expanded tree; value is the number that a constant has; dimension: with [units], ANY of a 0.
    """
    expr: Expr
    kind: str
    nodes: int = 1
    depth: int = 1
    value: Optional[float] = None
    dimension: Optional[tuple] = NONE


@dataclass(frozen=True)
class Formula:
    """A named sub-formula: its arguments and its syntax tree."""
    name: str
    args: tuple[str, ...]
    body: Syntax
    span: Span


@dataclass
class Declared:
    """All that the sections declare; one name space."""
    parameters: dict[str, Parameter] = field(default_factory=dict)
    vectors: set[str] = field(default_factory=set)      # array parameters used as vectors
    lists: set[str] = field(default_factory=set)        # array parameters whose entries are vectors
    families: dict[str, Family] = field(default_factory=dict)
    formulas: dict[str, Formula] = field(default_factory=dict)
    broken: set[str] = field(default_factory=set)       # declared, but with errors
    pending: set[str] = field(default_factory=set)      # declared, not read yet
    hollow: bool = True                                 # the space is missing or has errors
    nameless: bool = False                              # a family has a name that it cannot have
    rough: set[str] = field(default_factory=set)        # families whose radius or C has errors
    unread: set[str] = field(default_factory=set)       # families whose count is not known
    tables: dict[str, tuple[float, ...]] = field(default_factory=dict)
    units: Optional[Units] = None
    dimensions: dict[str, tuple] = field(default_factory=dict)      # of parameters and families; none: a number without a unit
    conserved: dict[str, tuple] = field(default_factory=dict)       # of families: those of kappa w and of the Casimir
    places: object = None                               # `vectors.Places`: where sites stand

    def names(self) -> set[str]:
        return set(self.parameters) | set(self.families) | set(self.formulas)


@dataclass(frozen=True)
class Scope:
    """The declared names, and what holds at one place.

    indices maps a bound index to its family ("" if it is only a number); weights are the
    columns of a graph; numbers those of bonds; args the values of a formula's arguments; whole names families
    that stand for their single vector (inside C).
    """
    declared: Declared
    place: str
    families: bool = True
    time: bool = False
    indices: dict[str, str] = field(default_factory=dict)
    weights: frozenset = frozenset()
    numbers: frozenset = frozenset()
    args: dict[str, Typed] = field(default_factory=dict)
    inside: tuple[str, ...] = ()        # formulas being expanded
    whole: str = ""
    over: object = None                 # the index family of a term
    site: str = ""                      # the family whose sites an index that is only a number runs over

    def enter(self, formula: Formula, args: dict[str, Typed]) -> "Scope":
        """The scope of a formula's body: its arguments, and no index of the caller."""
        return replace(self, args=args, indices={}, weights=frozenset(), numbers=frozenset(),
                       inside=self.inside + (formula.name,))

    def known(self) -> set[str]:
        """Every name that may stand here, for guesses."""
        families = set(self.declared.families) if self.families else set()
        return (self.declared.names() - set(self.declared.families) | families
                | set(self.indices) | self.weights | self.numbers | set(self.args)
                | {"pi"} | ({"t"} if self.time else set()))


def is_single(family: Family) -> bool:
    """Does the plain name of `family` mean its only vector."""
    return family.count == Num(1)
