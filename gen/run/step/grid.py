"""The grid of MPI ranks that `--grid` asks for: into how many parts each direction of a lattice is cut (runtime/lattice/smg_row_grid.h)."""
from __future__ import annotations

from itertools import product
from math import prod

from ... import ranks
from ...compile.plan.colouring import VECTOR, keeps_apart, seam
from ...compile.plan.contributions import contributions_of
from ...errors import UsageError
from ...language.evaluate import integer
from ...language.spec import Lattice
from ...language.sublattice import together
from ...methods import METHODS

NOT_BY_ROWS = "--grid: only lattices processed by rows with a midpoint method can be cut into blocks"


def grid_flags(prepared) -> tuple[str, ...]:
    """For the compiler, where a grid was asked for and there are several ranks. Raises UsageError for a lattice that cannot be cut so."""
    if ranks.grid is None or (ranks.grid == "auto" and ranks.count() == 1):
        return ()
    found = grid_of(Rows(prepared), ranks.grid, ranks.count())
    return (f"-DSMG_MPI_GRID={','.join(map(str, found))}",)


def check_grid(notes: dict) -> None:
    """Raises UsageError for a compiled model whose steps ranks do not share."""
    if ranks.grid is not None and ranks.count() > 1 and not notes.get("ranks"):
        raise UsageError(NOT_BY_ROWS)


class Rows:
    """size: cells of each direction; slots: of a row; step: cells along a row from one slot to the next; reach: of couplings, in cells."""

    def __init__(self, prepared):
        overs = lattices(prepared)
        colours = prepared.plan.colours
        if colours is None or not METHODS[prepared.method].of_midpoints:
            raise UsageError(NOT_BY_ROWS)
        self.size = [integer(n, prepared.numbers.values, "the size of a lattice") for n in overs[0].size]
        self.meet = not keeps_apart(colours, overs)
        self.step = colours.step
        self.slots = colours.row_length(self.size[0])
        pairs = [(a, b) for over in overs for bond in over.bonds for (_, a), (_, b) in product(bond, bond)]
        self.reach = [max((abs(a[d] - b[d]) for a, b in pairs), default=0) for d in range(len(self.size))]
        self.seam = seam(colours, overs, self.size)

    def refused(self, grid) -> str:
        """Why the lattice cannot be cut so; "" where it can."""
        cut = [d for d, n in enumerate(grid) if n > 1]
        if len(grid) != len(self.size):
            return f"this lattice has {len(self.size)} directions"
        if self.meet:
            return "no small number of colours separates all neighbours and fits the periodic directions"
        if self.seam is not None:
            return f"the size of the periodic direction {self.seam} is not a multiple of the number of colours"
        if cut and (below := prod((self.slots, *self.size[1:])[:max(1, cut[0])])) % VECTOR:
            return f"direction {cut[0]} cannot be cut, because {below} slots of a colour, no multiple of {VECTOR}, stand between its cells"
        return next(filter(None, (self.short(d, grid[d]) for d in cut)), "")

    def short(self, d: int, n: int) -> str:
        """Why a direction cannot be cut into n parts."""
        if d == 0:
            vectors = self.slots // VECTOR      # of the last one some slots may be empty
            least = min((vectors // n * VECTOR - 1) * self.step, self.size[0] - vectors * (n - 1) // n * VECTOR * self.step)
            return "" if least >= max(1, self.reach[0]) else f"a row of {self.slots} slots has too few vectors of {VECTOR} for {n} parts"
        return "" if self.size[d] // n >= max(1, self.reach[d]) else f"direction {d} has {self.size[d]} cells, too few for {n} parts"

    def surface(self, grid) -> float:
        """Cells of the faces of a block."""
        block = [size / n for size, n in zip(self.size, grid)]
        return sum(prod(block) / block[d] for d, n in enumerate(grid) if n > 1)


def lattices(prepared) -> list:
    """Those of all bonds, with the sites of all families in a cell."""
    names = [family.name for family in prepared.scene.families]
    return [together(c.over, names) for c in contributions_of(prepared.scene, METHODS[prepared.method]) if isinstance(c.over, Lattice)]


def grid_of(rows: Rows, asked: str, count: int) -> tuple:
    """AxBxC, or for `auto` that of the smallest surface, which cuts slow directions first."""
    if asked != "auto":
        grid = tuple(map(int, asked.split("x")))
        why = f"these are {prod(grid)} blocks, but the number of ranks is {count}" if prod(grid) != count else rows.refused(grid)
        if why:
            raise UsageError(f"--grid {asked}: {why}")
        return grid
    fit = [grid for grid in grids(count, len(rows.size)) if not rows.refused(grid)]
    if not fit:
        raise UsageError(f"--grid auto: there is no grid of {count} ranks for this lattice; {rows.refused((1,) * (len(rows.size) - 1) + (count,))}")
    return min(fit, key=lambda grid: (rows.surface(grid), grid))


def grids(count: int, directions: int):
    """All ways to write a number as a product."""
    if directions == 1:
        yield (count,)
        return
    for first in (n for n in range(1, count + 1) if count % n == 0):
        yield from ((first, *others) for others in grids(count // first, directions - 1))
