"""What a spec says, after reading: plain immutable data, no text, no behaviour.

Sites are numbered family by family in the order of `[space]`; a state is an array of
shape (sites, 3). `Expr` fields marked [int] are integer formulas in int parameters.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import Optional, Union

from ..public import few
from .expr import Expr, Num, Spin, walk
from .units import Units


@dataclass(frozen=True)
class Parameter:
    """A named number. kind: 'real', 'int' or 'array' (of reals; `size` [int] entries).

    fixed: its value is compiled in; otherwise it is a member of the params struct.
    fill: every entry of the array has the one value that the spec gives. vector: formulas use its entries by threes.
    """
    name: str
    kind: str
    default: Union[int, float, tuple[float, ...]]
    size: Optional[Expr] = None
    unit: str = ""
    meaning: str = ""
    fixed: bool = False
    fill: bool = False
    vector: bool = False

    @property
    def too_few(self) -> str:
        """Why a single number is no value of a vector."""
        return f"'{self.name}' is a vector: it needs three numbers, not one" if self.size == Num(3) else f"'{self.name}' is an array of vectors: it needs three numbers for each, not one"


@dataclass(frozen=True)
class Family:
    """`count` [int] equal factors of the phase space.

    kind 'sphere': radius r, w' = (1/kappa) w x grad H.
    kind 'r3': Lie-Poisson R^3, the same bracket at any |w| (extended method).
    kind 'nambu': w' = (1/kappa) grad C x grad H, C = w.(casimir w)/2, casimir symmetric 3x3.
    kappa (and radius) are formulas in the site's index Idx('i').
    tracer: feels others and acts on none; its kappa scales its own energy only.
    fixed: no site of it moves. lattice: the lattice or graph on whose sites it lies, where [space] says so.
    """
    name: str
    kind: str
    count: Expr
    kappa: Expr
    radius: Optional[Expr] = None
    casimir: Optional[tuple[tuple[Expr, ...], ...]] = None
    tracer: bool = False
    fixed: bool = False
    lattice: Optional[Union["Lattice", "Graph"]] = field(default=None, compare=False)


@dataclass(frozen=True)
class Once:
    """A single term; its Spin slots are integers."""
    bound: tuple[str, ...] = ()


@dataclass(frozen=True)
class Sites:
    """One term for each site of `family`: `site(i) of w`."""
    index: str
    family: str

    @property
    def bound(self):
        return (self.index,)


@dataclass(frozen=True)
class Pairs:
    """All pairs i < j of one family: `pair(i, j) of w`."""
    first: str
    second: str
    family: str

    @property
    def bound(self):
        return (self.first, self.second)


@dataclass(frozen=True)
class Each:
    """All index combinations of different families: `each(i of p, j of w)`."""
    indices: tuple[str, ...]
    families: tuple[str, ...]

    @property
    def bound(self):
        return self.indices


@dataclass(frozen=True)
class Places:
    """Where the sites of a lattice stand. vectors: rows (x, y, z), of its directions, then of those that measure positions alone;
    positions: of the sites of a cell, fractions of all vectors; name: of a lattice of `language.crystals`; assumed: from that name alone, which any other
    lattice with places overrules; measured: the vectors are lengths with a unit; unit: its name in the lattice constant; names: of the sites of a cell."""
    vectors: tuple[tuple[float, ...], ...]
    positions: tuple[tuple[float, ...], ...]
    name: str = ""
    assumed: bool = False
    measured: bool = False
    unit: str = ""
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Lattice:
    """Bonds of a lattice: `bond(i, j) of chain(n, periodic)`.

    Cell (c0, c1, ..) of a lattice of `size` [int] has number c0 + size0*(c1 + size1*(..));
    site = cell*sites + sub. One term for each cell and each member of `bonds`; a bond names,
    for each bound index, (sub, offset per dimension). Open directions drop bonds that leave.
    number: the name of the number of a bond, from 0 on: one after the other of `bonds`, each in all cells in which it is, in their order.
    families: where the ends are not all of one family, that of each; every family has a site for each of the lattice, and `family` is "".
    With a single index it runs over the sites of one place of the cell.
    columns: numbers of each member of `bonds`, by name: components of its vector.
    """
    indices: tuple[str, ...]
    size: tuple[Expr, ...]
    periodic: tuple[bool, ...]
    sites: int
    bonds: tuple[tuple[tuple[int, tuple[int, ...]], ...], ...]
    family: str = ""
    places: Optional[Places] = field(default=None, compare=False)
    number: str = ""
    families: tuple[str, ...] = ()
    columns: tuple[tuple[str, tuple[float, ...]], ...] = ()

    @property
    def bound(self):
        return (*self.indices, self.number) if self.number else self.indices


@dataclass(frozen=True)
class Graph:
    """Edges of a file: `edge(i, j, J) of g`; one term for each edge, columns by name. places: (x, y, z) of its sites, where it gives them."""
    first: str
    second: str
    edges: tuple[tuple[int, int], ...]
    columns: tuple[tuple[str, tuple[float, ...]], ...] = ()
    family: str = ""
    places: Optional[tuple[tuple[float, ...], ...]] = field(default=None, compare=False)

    @property
    def bound(self):
        return (self.first, self.second)

    def __hash__(self):
        return self.hashed

    @cached_property
    def hashed(self) -> int:
        """Computed once, since a million edges take a tenth of a second; of numbers alone, so that it is the same in every process."""
        return hash(self.edges)

    @cached_property
    def ends(self):
        """The edges as an array, shape (edges, 2)."""
        import numpy as np                  # for graphs alone
        return np.fromiter(chain.from_iterable(self.edges), np.int64, 2 * len(self.edges)).reshape(-1, 2)

    @cached_property
    def highest(self) -> int:
        """The largest number of a site that an edge meets; -1 without edges."""
        return int(self.ends.max(initial=-1))


Over = Union[Once, Sites, Pairs, Each, Lattice, Graph]


def families_of(over: Over) -> dict[str, str]:
    """Bound index -> the family whose sites it runs over."""
    if isinstance(over, Sites):
        return {over.index: over.family}
    if isinstance(over, Each):
        return dict(zip(over.indices, over.families))
    if isinstance(over, Lattice):
        return dict(zip(over.indices, over.families or (over.family,) * len(over.indices)))
    if isinstance(over, (Pairs, Graph)):
        return dict.fromkeys(over.bound, over.family)
    return {}


@dataclass(frozen=True)
class Term:
    """A named sum over an index family: of an energy, of an observable (key `value`)."""
    name: str
    over: Over
    value: Expr
    meaning: str = ""
    unit: str = ""
    names: tuple[str, ...] = ()

    key = "value"       # of its formula in a spec

    @property
    def moved(self) -> tuple:
        """Slots that it moves, beside those that it names."""
        return ()

    @property
    def formulas(self) -> dict[str, Expr]:
        """By their keys."""
        return {self.key: self.value}

    @property
    def families(self) -> set[str]:
        """Those that it runs over or names."""
        return {e.family for e in walk(self.value) if isinstance(e, Spin)} | set(families_of(self.over).values())

    def mapped(self, over, formula):
        """The same with another index family, `over` of its own, and other formulas, `formula` of each."""
        return replace(self, over=over(self.over), value=formula(self.value))

    @property
    def untitled(self):
        """Without its texts."""
        return replace(self, meaning="", unit="")


class Effect:
    """A part of the motion that a scene calls for by its name. Each kind is a class in a file of gen/effects, with name, over, meaning,
    and what a `Term` has: formulas, families, mapped, untitled; beside that:

    told_by: keys of a spec by which the kind is known; keys: those that exclude the keys of other kinds; reader: what reads one
    (`gen/effects/kinds.py`); moves: does it move sites where there is no other effect? conservative: is it the gradient of an energy?
    not_negative: key of a formula -> why it may not be negative; gives_up: of what is not conservative, "symplectic", "energy" and "momentum" -> why not, and
    "by" and "as", what gives it up, as a noun and as a sentence; work: (operations, bytes) for each site that it moves, of what is no sum of terms.
    """
    told_by: tuple = ()
    keys: tuple = ()
    moves = True
    conservative = False
    gone = False
    not_negative: dict = {}
    gives_up: dict = {}
    work: tuple | None = None

    @property
    def lost(self) -> dict[str, str]:
        """What it alone takes from a motion by energies that rotations and time leave unchanged -> why; of energies their symmetries tell."""
        return {}

    @property
    def pushes(self) -> tuple[str, ...]:
        """The families whose sites it moves in a way that no energy could."""
        return ()

    @property
    def damps(self) -> tuple[str, ...]:
        """The families whose sites lose energy."""
        return ()

    @property
    def heats(self) -> tuple[str, ...]:
        """The families whose sites noise turns."""
        return ()

    @property
    def holds(self) -> tuple | None:
        """(a family, the condition on Idx("i") that a site of it does not move) of an effect that holds sites; `gone`: they are not there."""
        return None

    @property
    def calm(self) -> "Effect":
        """The same without noise."""
        return self

    @property
    def note(self) -> str:
        """What the C says of it beside the bracket."""
        return ""

    def contribution(self, spec: "Spec", method):
        """How it moves sites (`gen/effects/motion.py`), for a method; None: for any."""
        raise NotImplementedError


@dataclass(frozen=True)
class FamilyStart:
    """Where one family starts.

    kind 'vectors': value = tuple of (x, y, z) numbers; 'formula': value = three Exprs in
    Idx('i') and parameters (angles theta, phi are turned into these by the reader);
    'random': value = seed (int), uniform on the sphere; 'file': value = path of a table.
    """
    family: str
    kind: str
    value: object
    normalise: bool = False


@dataclass(frozen=True)
class Start:
    name: str
    families: tuple[FamilyStart, ...]


LOOSEST = 1e-2      # a tolerance beyond this tells nothing of a step


@dataclass(frozen=True)
class Averages:
    """Of numbers over the outputs of a run: their names, () for the energy and all observables; from which time on; bins of a histogram, None for the usual."""
    what: tuple[str, ...] = ()
    after: Optional[Expr] = None
    bins: Optional[int] = None


@dataclass(frozen=True)
class Run:
    """A named run. h and time are Exprs in the parameters (h may be negative)."""
    name: str
    start: str
    method: str
    h: Expr
    time: Optional[Expr] = None
    steps: Optional[Expr] = None
    every: int = 1
    period: Optional[Expr] = None       # of outputs: at its multiples only (stroboscopic)
    what: tuple[str, ...] = ("states", "energy")
    effects: Optional[tuple[str, ...]] = None   # None: all
    solver: str = "auto"
    parameters: tuple[tuple[str, object], ...] = () # values that this run sets
    meaning: str = ""
    checkpoint: Optional[int] = None    # steps between checkpoints of a run that writes a file
    substeps: bool = False              # take a step that fails as smaller ones
    tolerance: Optional[float] = None   # of a step; None: round-off
    averages: Optional[Averages] = None


@dataclass(frozen=True)
class Spec:
    """A spec after it has been read and checked. Use `load`, `load_text` or `Model` to make one."""

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    families: tuple[Family, ...]
    effects: tuple[Effect, ...]     # of all kinds, in their order in gen/effects/kinds.py
    observables: tuple[Term, ...] = ()
    tables: tuple[tuple[str, tuple[float, ...]], ...] = ()   # constant lists, e.g. kappa = [1, 2]
    starts: tuple[Start, ...] = ()
    runs: tuple[Run, ...] = ()
    orientation: int = +1        # +1: the paper's sign; -1: every bracket reversed
    path: str = ""
    digest: str = ""             # sha256 of the text and of the files it names
    sources: tuple[tuple[str, str], ...] = ()
    units: Optional[Units] = None       # what numbers count in; None: they have no units

    def of(self, kind) -> tuple:
        """The effects of one kind."""
        return tuple(e for e in self.effects if isinstance(e, kind))

    @property
    def energies(self) -> tuple[Term, ...]:
        """The terms of H."""
        return tuple(e for e in self.effects if e.conservative and isinstance(e, Term))

    @property
    def effect_names(self) -> tuple[str, ...]:
        """The names of all effects."""
        return tuple(e.name for e in self.effects)

    @property
    def conservative(self) -> bool:
        """Whether there are only energies: no damping, noise or torques."""
        return all(e.conservative for e in self.effects)

    @property
    def pushed(self) -> tuple[str, ...]:
        """The families on which torques act, in the order of `[space]`."""
        found = {family for e in self.effects for family in e.pushes}
        return tuple(f.name for f in self.families if f.name in found)

    def given_up(self, what: str, default: str = "") -> str:
        """A property that is lost, such as conservation of energy, with the reason, for all kinds of effects that destroy it."""
        return " and ".join(dict.fromkeys(e.gives_up[what] for e in self.effects if what in e.gives_up)) or default

    @property
    def damped(self) -> tuple[str, ...]:
        """The families with damping."""
        return tuple(family for e in self.effects for family in e.damps)

    @property
    def heated(self) -> tuple[str, ...]:
        """The families with thermal noise."""
        return tuple(family for e in self.effects for family in e.heats)

    @property
    def calm(self) -> "Spec":
        """The same spec without noise: the part of the step between the two halves of the noise."""
        return replace(self, effects=tuple(e.calm for e in self.effects)) if self.heated else self

    def __repr__(self) -> str:
        held = ("parameters", "families", "effects", "observables", "starts", "runs")
        parts = [f"{name} {few(x.name for x in getattr(self, name))}" for name in held if getattr(self, name)]
        return f"<Spec {self.name}: {'; '.join(parts)}>"
