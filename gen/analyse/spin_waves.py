"""Linear spin waves: the frequencies of small deviations from an equilibrium of any spec on a lattice, from the Hessian of its energy.

    found = smidgen.spin_waves(spec, start="neel", q="0,0 1/2,0 1/2,1/2 0,0")
    found.omega             # (wave vectors, lines), with the lines that S(q, omega) shows at each q

The equilibrium may be any state: its magnetic cell, or the rotation by which a spiral goes on from cell to cell, is found. Formulas stand in
docs/lattices.md.
"""
from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..language.units import ENERGY, TIME
from ..public import ReadOnly, public
from ..read.shipped import SpecLike, spec_or_name
from ..run.fields.field import Field
from ..run.fields.grid import Grid, family_of, of
from ..run.settings import whole
from ..run.step.evaluated import Evaluated
from ..run.step.prepared import asked, scene_of
from ..run.step.start import given_or_at, state_at, wrong_start
from .waves import rows, waves

FLAT = 1e-9         # of the largest curvature: what is lowered less is round-off
GROWS = 1e-6        # of the largest frequency: a rate below that is round-off
SMOOTH = 50         # sites of a magnetic cell up to which lines are computed between the wave vectors of the lattice
SEEN = 1e-9         # of the largest weight: a line below that is not seen


@dataclass(repr=False)
class SpinWaves(ReadOnly):
    """Lines of linear spin waves near an equilibrium, in the units of the spec.

    :ivar q: the wave vectors in units of the reciprocal lattice vectors, shape (waves, directions).
    :ivar omega: the angular frequencies at each wave vector in ascending order, shape (waves, lines); NaN if a wave vector has fewer lines.
        All are 0 or positive: a mode of negative frequency at q is one of positive frequency at -q.
    :ivar weights: the integrals of S_xx, S_yy and S_zz over each line at a temperature, divided by kT, shape (waves, lines, 3). 0 if
        S(q, omega) does not show the line at this q; NaN if there is no such number: at omega = 0, and for states that are not minima of
        the energy.
    :ivar growth: the rate at which each mode grows, shape (waves, lines); 0 at minima of the energy.
    :ivar w: the equilibrium, shape (sites, 3).
    :ivar meta: `cell`, the numbers of cells after which the motion repeats; `turns`, degrees from cell to cell in each direction for an order
        that continues from cell to cell by a rotation, otherwise []; `torque`, the largest |n x g| over the largest |g|; `moved`, by how
        many degrees relaxation turned spins; `energy`; `stable`, whether no mode lowers the energy; `notes`, what the lines leave out.
    """
    INSTEAD = {"": "smidgen.spin_waves(spec, ...) finds others"}
    meta: dict
    q: np.ndarray
    omega: np.ndarray
    weights: np.ndarray
    growth: np.ndarray
    w: np.ndarray

    def __repr__(self) -> str:
        return (f"<SpinWaves {self.meta['spec']}: {self.meta['family']}, {len(self.q)} waves, {self.omega.shape[1]} lines up to "
                f"{np.nanmax(self.omega):.6g}>")

    @property
    def seen(self) -> np.ndarray:
        """Whether S(q, omega) shows each line, shape (waves, lines); True if its weight is not known."""
        total = self.weights.sum(axis=2)
        return ~np.isnan(self.omega) & ~(total < SEEN * np.nan_to_num(total).max(initial=0))


@public
@spec_or_name
def spin_waves(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | Field | None = None,
               effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None, seed: int | None = None, family: str | None = None, q="all",
               basis=None, relax: bool = False, cell=None, between: int = 1) -> SpinWaves:
    """Compute the lines of linear spin waves near an equilibrium of a spec on a lattice. Arguments not listed here are as for `run`.

    :param start: the equilibrium: the name of a start of the spec, or a state of shape (sites, 3).
    :param family: the family; needed if there are several.
    :param q: as for `spectrum`; wave vectors in an array need not be those of the finite lattice.
    :param basis: as for `spectrum`.
    :param relax: whether to minimise the energy from `start`, rather than to require that `start` is an equilibrium.
    :param cell: the magnetic cell, as numbers of cells in each direction; by default the smallest is found, or the rotation of a
        spiral from cell to cell.
    :param between: the number of steps from one wave vector of the lattice to the next along a path, for smooth lines.
    :raises UsageError: if the state is not an equilibrium, for energies that depend on time, torques, tracers and magnetic cells of more than
        1000 sites.
    :raises MissingTool: for `relax` without scipy.

    The lines follow from the Hessian of the energy. They do not include damping or noise, which is stated in `meta["notes"]`. Formulas are in
    docs/lattices.md.
    """
    if whole(between, "between") < 1:
        raise UsageError("between must be at least 1")
    one = asked(spec, run, None, None, effects, parameters)
    scene = scene_of(spec, one.effects, dict(one.parameters))
    numbers = Evaluated(spec, dict(one.parameters)).of(scene)
    family = family_of(spec, family)
    grid = of(spec, family, dict(one.parameters))
    w = state_of(numbers, one.start if start is None else start, seed)
    return theory(numbers, family, grid, rows_of(grid, q), w, relax=relax, basis=basis, cell=cell, between=between if is_path(q) else 1)


def state_of(numbers: Evaluated, start, seed) -> np.ndarray:
    """The state at a start, given or of the spec. Raises UsageError."""
    if isinstance(start, Field):
        start = start.placed(numbers)
    if not isinstance(start, np.ndarray):
        return state_at(numbers, start, seed)
    count = sum(number for _, number in numbers.places.values())
    if start.shape != (count, 3):
        raise UsageError(f"a state of {numbers.spec.name} has shape ({count}, 3), not {start.shape}")
    w = given_or_at(numbers, start)
    if why := wrong_start(numbers, w):
        raise UsageError(f"the state cannot be used as a start{why}")
    return w


def is_path(q) -> bool:
    return isinstance(q, str) and q.strip() != "all"


def rows_of(grid: Grid, q) -> np.ndarray:
    """Wave vectors in units of the reciprocal lattice: those of the finite lattice by name, or any."""
    if isinstance(q, str):
        return waves(grid, q) / np.array(grid.size)
    return rows(grid, q)


def refined(q, between: int) -> np.ndarray:
    """Rows with between - 1 others on the way to the next."""
    at = np.arange((len(q) - 1) * between + 1) / between
    return np.stack([np.interp(at, np.arange(len(q)), column) for column in q.T], axis=1)


def theory(numbers: Evaluated, family: str, grid: Grid, q, w, relax: bool = False, basis=None, cell=None, between: int = 1) -> SpinWaves:
    """The lines near w, or near the equilibrium below it. numbers: those of the scene; between: steps from q to q, in small magnetic cells."""
    from .equilibrium import checked, relaxed, turned        # these need sympy
    from .hessian import Energy
    from .linear import Linear
    from .magnetic_cell import Sites, order_of
    from .modes import Modes
    notes = obstacles(numbers)
    sites, energy = Sites(grid, numbers), Energy(numbers)
    state = relaxed(numbers, energy, w) if relax else w
    torque = checked(numbers, energy, state)
    linear = Linear(numbers, energy, state)
    order = order_of(linear, sites, cell)
    modes = Modes(linear, order, sites, fractions_of(sites, family, grid.basis(basis)))
    smooth = between if len(modes.base) <= SMOOTH else 1
    lines = Lines(modes, order, family, refined(q, smooth))
    turns = [] if order.turns is None else np.degrees(angles(order.turns)).tolist()
    meta = {"spec": numbers.spec.name, "family": family, "cell": list(order.size), "turns": turns, "torque": torque,
            "moved": float(np.degrees(turned(w, state))), "energy": energy.at(state), "stable": lines.stable, "between": smooth,
            "units": units_of(numbers.spec), "notes": notes + lines.notes()}
    return SpinWaves(meta, lines.q, lines.omega, lines.weights, lines.growth, state)


def fractions_of(sites, family: str, basis) -> np.ndarray:
    """Where the members of a cell are, (members, directions): those of the family as `basis` has them; of others nothing is seen."""
    found = np.zeros((sites.at.shape[1], basis.shape[1]))
    found[sites.members[family]] = basis
    return found


def units_of(scene) -> dict | None:
    """The units of time and energy; None where numbers have none."""
    return None if scene.units is None else {"time": scene.units.spelt(TIME), "energy": scene.units.spelt(ENERGY)}


def angles(turns) -> np.ndarray:
    """Of rotations, in radians from 0 to pi."""
    return np.arccos(np.clip((np.trace(turns, axis1=1, axis2=2) - 1) / 2, -1, 1))


def obstacles(numbers: Evaluated) -> list:
    """What the lines do not tell. Raises UsageError where the energies do not decide on the motion."""
    scene = numbers.spec
    if scene.pushed:
        raise UsageError(f"linear spin waves are defined for energies only, but a torque acts on '{scene.pushed[0]}': leave it out (effects=..)")
    if tracer := next((f.name for f in scene.families if f.tracer), None):
        raise UsageError(f"linear spin waves are defined for energies only, but '{tracer}' is a tracer, which has none")
    if not numbers.moving.any():
        raise UsageError("no site moves: all of them are pinned or absent")
    notes = ["the lines are computed without damping, which broadens them and lowers their frequencies"] if scene.damped else []
    return notes + ["the lines are computed without noise; a temperature broadens and shifts them"] * bool(scene.heated)


class Lines:
    """Lines at each q. A rotation from cell to cell is a sum over theta: a mode of k is seen at q = k + theta/2 pi."""

    def __init__(self, modes, order, family: str, q):
        self.q, self.modes, self.parts, self.lowest = q, modes, order.waves(), np.inf
        self.own, self.count = modes.of_family(family)
        found = [self.of(k) for k in q]
        self.lines = max(len(omega) for omega, _, _ in found)
        self.omega, self.weights, self.growth = (np.stack([self.padded(row[k]) for row in found]) for k in range(3))
        if not self.stable:
            self.weights[:] = np.nan        # no thermal equilibrium

    @property
    def stable(self) -> bool:
        return bool(self.lowest >= -FLAT * self.modes.scale)

    def of(self, q) -> tuple:
        """(omega, weights, growth) of one wave vector: the upper half of the modes of each part, and others above 0."""
        rows = []
        for theta, p in self.parts:
            found = self.modes.at(q - theta / (2 * np.pi))
            phases = np.exp(-1j * self.modes.fractions @ theta) / np.sqrt(self.count)
            weights = np.abs(np.einsum("s,msb,cb->mc", phases[self.own], found.waves[:, self.own], p)) ** 2
            first = min(len(found.omega) // 2, np.searchsorted(found.omega, self.modes.zero, side="right"))
            rows.append((np.where(found.omega > self.modes.zero, found.omega, 0)[first:], weights[first:], found.growth[first:]))
            self.lowest = min(self.lowest, found.lowest)
        omega, weights, growth = (np.concatenate(parts) for parts in zip(*rows))
        order = np.argsort(omega, kind="stable")
        return omega[order], weights[order], growth[order]

    def padded(self, row) -> np.ndarray:
        return np.concatenate([row, np.full((self.lines - len(row), *row.shape[1:]), np.nan)])

    def notes(self) -> list:
        """Modes that lower the energy or grow, by their wave vectors."""
        if self.stable:
            return []
        growth = np.nan_to_num(self.growth)
        at, line = np.unravel_index(growth.argmax(), growth.shape)
        if growth[at, line] <= GROWS * max(np.nanmax(self.omega), growth[at, line], 1e-300):
            return [f"the state is not a minimum of the energy: some modes lower it, by up to {-self.lowest / self.modes.scale:.2g} of the largest "
                    "curvature, but none grows"]
        some = np.flatnonzero((growth > GROWS * np.nanmax(self.omega)).any(axis=1))
        q = ", ".join(f"{x:.4g}" for x in self.q[at])
        return [f"the state is unstable: modes grow at {len(some)} of {len(self.q)} wave vectors, fastest at q = {q}, "
                f"at the rate {growth[at, line]:.6g}"]


# Files

ARRAYS = ("q", "omega", "weights", "growth", "w")


def packed(found: SpinWaves | None) -> dict:
    """Arrays of a file."""
    if found is None:
        return {}
    return {**{f"theory_{name}": getattr(found, name) for name in ARRAYS}, "theory_meta": np.array(json.dumps(found.meta))}
