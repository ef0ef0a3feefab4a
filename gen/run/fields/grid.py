"""The lattice on which a family lies: its cells, their numbers and places.

Where a lattice of the spec has vectors and positions, sites stand there. Otherwise cell (c0, c1, ..) stands at the integers c0, c1, .., and site s of
the p sites of a cell at the fraction s/p of its diagonal, unless other fractions are given.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ...errors import UsageError
from ...language.evaluate import integer
from ...language.places import placed_on
from ...language.spec import Lattice, Places, Spec
from ...language.units import LENGTH
from ...public import public
from ..files.recorded import spec_of
from ..step.evaluated import Evaluated


@dataclass(frozen=True)
class Grid:
    """A lattice. Cell (c0, c1, ..) has the number c0 + size0*(c1 + size1*(..)); the sites of a cell follow each other.

    :ivar size: the number of cells in each direction.
    :ivar periodic: for each direction, whether it is periodic.
    :ivar sites: the number of sites in a cell.
    :ivar places: the vectors of the lattice and the positions of the sites in a cell; None if the spec does not give them.
    :ivar unit: the unit of length of the places; "" if they have none.
    """
    size: tuple[int, ...]
    periodic: tuple[bool, ...]
    sites: int = 1
    places: Places | None = field(default=None, compare=False)
    unit: str = field(default="", compare=False)

    @property
    def count(self) -> int:
        """All sites."""
        return math.prod(self.size) * self.sites

    def cells(self, w) -> np.ndarray:
        """States (.., count, 3) as (.., last direction, .., first direction, sites, 3). Raises UsageError for another shape."""
        w = np.asarray(w)
        if w.shape[-2:] != (self.count, 3):
            raise UsageError(f"states on this lattice must have shape (.., {self.count}, 3), not {w.shape}")
        return w.reshape(*w.shape[:-2], *self.size[::-1], self.sites, 3)

    def positions(self, basis=None) -> np.ndarray:
        """Where the sites stand, (count, directions), in cells. basis: of the sites of a cell, (sites, directions)."""
        cells = np.indices(self.size[::-1]).reshape(len(self.size), -1)[::-1].T
        return (cells[:, None] + self.basis(basis)).reshape(-1, len(self.size))

    def basis(self, given=None) -> np.ndarray:
        """Fractions (sites, directions) of a cell: those given, else those of the spec, else site s at s/sites of the diagonal."""
        if given is None and self.places is not None:
            return self.fractions()
        diagonal = np.repeat(np.arange(self.sites)[:, None] / self.sites, len(self.size), axis=1)
        basis = diagonal if given is None else np.asarray(given, float)
        if basis.shape != diagonal.shape or not np.all(np.isfinite(basis)):
            raise UsageError(f"a basis must have {self.sites} rows of {len(self.size)} finite numbers")
        return basis

    def fractions(self) -> np.ndarray:
        """Where the sites of a cell stand, in fractions of the vectors along which cells follow each other; what is across them has none."""
        vectors = np.array(self.places.vectors, float)
        return np.array(self.places.positions, float) @ vectors @ np.linalg.pinv(vectors[:len(self.size)])

    def where(self) -> np.ndarray | None:
        """The places of all sites in space, (count, 3). None without places."""
        if self.places is None:
            return None
        vectors = np.array(self.places.vectors, float)
        cells = np.indices(self.size[::-1]).reshape(len(self.size), -1)[::-1].T @ vectors[:len(self.size)]
        return (cells[:, None] + np.array(self.places.positions, float) @ vectors).reshape(-1, 3)

    def spacing(self) -> tuple[float, float, float] | None:
        """Of a mesh: one site a cell, at its corner, and vectors along x, y, z. None of any other lattice."""
        if self.places is None or self.sites > 1 or len(self.size) > 3:
            return None
        vectors, own = np.array(self.places.vectors, float)[:len(self.size)], np.array(self.places.positions, float)
        steps = np.diag(np.pad(vectors, ((0, 3 - len(vectors)), (0, 0))))[:len(vectors)]
        straight = np.count_nonzero(vectors) == len(vectors) and np.all(steps > 0) and not own.any()
        return (*map(float, steps), *(float(steps[0]),) * 2)[:3] if straight else None

    def reciprocal(self) -> np.ndarray | None:
        """Rows b_1, b_2, .. with a_j.b_k = 2 pi (j = k): q = q_1 b_1 + .. in units of 1/length. None without places."""
        return None if self.places is None else 2 * np.pi * np.linalg.pinv(np.array(self.places.vectors, float)[:len(self.size)]).T


@public
def of(source, family: str | None = None, parameters: dict | None = None) -> Grid:
    """The lattice on which the sites of a family are coupled, found from the effects and observables of a spec.

    :param source: a Spec, or a Result, which contains its parameters.
    :param family: the family; needed if there are several.
    :param parameters: values by name that replace the defaults of the spec.
    :raises UsageError: if there is no lattice, or if two have the most directions.

    If there are several lattices, the one with the most directions is returned. A direction is periodic if all its bonds are.
    """
    spec, parameters = with_parameters(source, parameters)
    name = family_of(spec, family)
    found = grids_of(Evaluated(spec, parameters), name)
    most = [grid for grid in found if len(grid.size) == max(len(g.size) for g in found)]
    if not most:
        raise UsageError(f"no lattice joins the sites of '{name}' in {spec.name}")
    if len(most) > 1:
        raise UsageError(f"'{name}' of {spec.name} is on lattices of different sizes: {', '.join(said(g.size) for g in most)} cells")
    return most[0]


def grids_of(numbers: Evaluated, family: str, called=None) -> list[Grid]:
    """All lattices that join the sites of a family, or those of the effects `called`; those that differ in their ends alone are one."""
    spec, count, found = numbers.spec, numbers.places[family][1], {}
    terms = (*spec.energies, *spec.observables) if called is None else [e for e in spec.energies if e.name in called]
    for over in (term.over for term in terms):
        if isinstance(over, Lattice) and over.family == family:
            key = tuple(integer(e, numbers.values, "the size of a lattice") for e in over.size), over.sites
            found[key] = tuple(a and b for a, b in zip(over.periodic, found.get(key, over.periodic)))
    home = placed_on(spec, family)
    grids = [placed(Grid(size, periodic, per_cell), home, spec.units) for (size, per_cell), periodic in found.items()]
    for grid in grids:
        if min(grid.size) < 1 or grid.count != count:
            raise UsageError(f"a lattice of {said(grid.size)} cells does not fit the {count} sites of '{family}'")
    return grids


def placed(grid: Grid, home, units) -> Grid:
    """The grid with the places of its family, if `home`, where the family stands, is a lattice of as many directions and sites a cell."""
    if not isinstance(home, Lattice) or (len(home.size), home.sites) != (len(grid.size), grid.sites) or home.places is None:
        return grid
    return replace(grid, places=home.places, unit=units.spelt(LENGTH) if units and home.places.measured else "")


def with_parameters(source, parameters: dict | None) -> tuple[Spec, dict]:
    """Of a Spec, or of a Result, whose parameters are its own. Raises UsageError, SpecError."""
    if isinstance(source, Spec):
        return source, dict(parameters or {})
    if not hasattr(source, "meta"):
        raise UsageError(f"expected a spec or a result, not a {type(source).__name__}")
    return spec_of(source.meta["sources"], source.meta["spec"]), {**source.meta["set"], **(parameters or {})}


def family_of(spec: Spec, family: str | None) -> str:
    """The name given, or that of the only family."""
    names = [f.name for f in spec.families]
    if family is None and len(names) == 1:
        return names[0]
    if family not in names:
        wrong = f"{spec.name} has several families" if family is None else f"{spec.name} has no family '{family}'"
        raise UsageError(f"{wrong}: choose one of {', '.join(names)}")
    return family


def said(size) -> str:
    """`8 x 8`."""
    return " x ".join(map(str, size))
