"""What a spec says, after reading: plain immutable data, no text, no behaviour.

Sites are numbered family by family in the order of `[space]`; a state is an array of
shape (sites, 3). `Expr` fields marked [int] are integer formulas in int parameters.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Optional, Union

from ..public import few
from .expr import Expr, Spin


@dataclass(frozen=True)
class Parameter:
    """A named number. kind: 'real', 'int' or 'array' (of reals; `size` [int] entries).

    fixed: its value is compiled in; otherwise it is a member of the params struct.
    fill: every entry of the array has the one value that the spec gives.
    """
    name: str
    kind: str
    default: Union[int, float, tuple[float, ...]]
    size: Optional[Expr] = None
    unit: str = ""
    meaning: str = ""
    fixed: bool = False
    fill: bool = False


@dataclass(frozen=True)
class Family:
    """`count` [int] equal factors of the phase space.

    kind 'sphere': radius r, w' = (1/kappa) w x grad H.
    kind 'r3': Lie-Poisson R^3, the same bracket at any |w| (extended method).
    kind 'nambu': w' = (1/kappa) grad C x grad H, C = w.(casimir w)/2, casimir symmetric 3x3.
    kappa (and radius) are formulas in the site's index Idx('i').
    tracer: feels others and acts on none; its kappa scales its own energy only.
    """
    name: str
    kind: str
    count: Expr
    kappa: Expr
    radius: Optional[Expr] = None
    casimir: Optional[tuple[tuple[Expr, ...], ...]] = None
    tracer: bool = False


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
class Lattice:
    """Bonds of a lattice: `bond(i, j) of chain(n, periodic)`.

    Cell (c0, c1, ..) of a lattice of `size` [int] has number c0 + size0*(c1 + size1*(..));
    site = cell*sites + sub. One term for each cell and each member of `bonds`; a bond names,
    for each bound index, (sub, offset per dimension). Open directions drop bonds that leave.
    """
    indices: tuple[str, ...]
    size: tuple[Expr, ...]
    periodic: tuple[bool, ...]
    sites: int
    bonds: tuple[tuple[tuple[int, tuple[int, ...]], ...], ...]
    family: str = ""

    @property
    def bound(self):
        return self.indices


@dataclass(frozen=True)
class Graph:
    """Edges of a file: `edge(i, j, J) of g`; one term for each edge, columns by name."""
    first: str
    second: str
    edges: tuple[tuple[int, int], ...]
    columns: tuple[tuple[str, tuple[float, ...]], ...] = ()
    family: str = ""

    @property
    def bound(self):
        return (self.first, self.second)

    @cached_property
    def highest(self) -> int:
        """The largest number of a site that an edge meets; -1 without edges."""
        return max(chain.from_iterable(self.edges), default=-1)


Over = Union[Once, Sites, Pairs, Each, Lattice, Graph]


@dataclass(frozen=True)
class Term:
    """A named sum over an index family: an effect (energy) or an observable (value)."""
    name: str
    over: Over
    value: Expr
    meaning: str = ""
    unit: str = ""


@dataclass(frozen=True)
class Torque(Term):
    """An effect that is no energy: it moves the site of `on` by w' = .. + value, a vector that is tangent at w, as it stands: without kappa or
    orientation. Gilbert's damping acts on it as on precession."""
    on: Optional[Spin] = None


FORMS = ("gilbert", "ll")     # of a damping: Gilbert's, and that of Landau and Lifshitz


@dataclass(frozen=True)
class Damping:
    """An effect that is no energy: the sites of `over` lose energy on their spheres.

    alpha: dimensionless, a formula of parameters and of the site's number Idx(over.index). With b = (1/kappa) dH/dw,
    r the radius, o the orientation and s the sign of kappa, form 'll' moves a site by

        w' = o w x b + s (alpha/r) w x (w x b),

    and 'gilbert', w' = o w x b + o s (alpha/r) w x w', by the same divided by 1 + alpha^2. In R^3, where r is the state's, the form is
    'll' and r is 1: alpha has the unit of 1/|w|.

    kT: of a heat bath in the unit of the energy, a formula of the same kind, or None: noise then turns the sites, and the distribution
    exp(-H/kT) is stationary.
    """
    name: str
    over: Sites
    alpha: Expr
    form: str = "gilbert"
    meaning: str = ""
    kT: Optional[Expr] = None

    @property
    def formulas(self) -> dict[str, Expr]:
        """Those that it has, by their keys."""
        return {"damping": self.alpha} if self.kT is None else {"damping": self.alpha, "kT": self.kT}


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


@dataclass(frozen=True)
class Spec:
    name: str
    title: str
    parameters: tuple[Parameter, ...]
    families: tuple[Family, ...]
    effects: tuple[Term, ...]
    observables: tuple[Term, ...] = ()
    tables: tuple[tuple[str, tuple[float, ...]], ...] = ()   # constant lists, e.g. kappa = [1, 2]
    starts: tuple[Start, ...] = ()
    runs: tuple[Run, ...] = ()
    orientation: int = +1        # +1: the paper's sign; -1: every bracket reversed
    path: str = ""
    digest: str = ""             # sha256 of the text and of the files it names
    sources: tuple[tuple[str, str], ...] = ()
    dampings: tuple[Damping, ...] = ()
    torques: tuple[Torque, ...] = ()

    @property
    def effect_names(self) -> tuple[str, ...]:
        """Those of the energies, then those of the dampings and torques: all that a scene may call for."""
        return tuple(e.name for e in (*self.effects, *self.dampings, *self.torques))

    @property
    def conservative(self) -> bool:
        """Do energies alone move its sites?"""
        return not (self.dampings or self.torques)

    @property
    def pushed(self) -> tuple[str, ...]:
        """The families whose sites a torque moves, in the order of the space."""
        return tuple(f.name for f in self.families if f.name in {t.on.family for t in self.torques})

    @property
    def heated(self) -> tuple[str, ...]:
        """The families whose sites noise turns."""
        return tuple(d.over.family for d in self.dampings if d.kT is not None)

    @property
    def calm(self) -> "Spec":
        """The same without noise: what is between its two halves in a step."""
        return replace(self, dampings=tuple(replace(d, kT=None) for d in self.dampings)) if self.heated else self

    def __repr__(self) -> str:
        held = ("parameters", "families", "effects", "dampings", "torques", "observables", "starts", "runs")
        parts = [f"{name} {few(x.name for x in getattr(self, name))}" for name in held if getattr(self, name)]
        return f"<Spec {self.name}: {'; '.join(parts)}>"
