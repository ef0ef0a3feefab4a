"""The waves of a lattice: wave vectors q by name, and the components of a state that go with them.

q is in units of the reciprocal lattice: the phase of a wave at the position r (in cells) is 2 pi q.r. On n cells around a
ring, q is a multiple of 1/n. Corners of the zone of a lattice by name have names: "Gamma K M Gamma".
"""
from __future__ import annotations

import math

import numpy as np

from ..errors import UsageError
from ..language.crystals import CRYSTALS
from ..read.given import constant
from ..run.fields.grid import Grid

WHOLE = 1e-9        # how far q n may be from an integer


def waves(grid: Grid, q) -> np.ndarray:
    """Integers m (count, directions) with q = m/size: "all", a path "0,0 1/2,0 1/2,1/2", or rows of q. Raises UsageError."""
    if isinstance(q, str):
        return every_wave(grid) if q.strip() == "all" else along(corners(grid, q))
    return whole(grid, rows(grid, q))


def rows(grid: Grid, q) -> np.ndarray:
    """Wave vectors (count, directions) that are given as numbers. Raises UsageError."""
    try:
        found = np.atleast_2d(np.asarray(q, float))
    except (TypeError, ValueError):
        raise UsageError("q must be \"all\", a path such as \"0,0 1/2,0\", or rows of numbers") from None
    if found.ndim != 2 or not len(found) or found.shape[1] != len(grid.size) or not np.all(np.abs(found) < 2 ** 20):
        raise UsageError(f"a wave vector of this lattice must consist of {len(grid.size)} finite numbers, such as {example(grid).split()[1]}")
    return found


def every_wave(grid: Grid) -> np.ndarray:
    """All of the first zone, -n/2 < m <= n/2, the first direction fastest."""
    ranges = [np.arange(n) - (n - 1) // 2 for n in grid.size[::-1]]
    return np.stack([m.ravel() for m in np.meshgrid(*ranges, indexing="ij")][::-1], axis=1)


def corners(grid: Grid, text: str) -> np.ndarray:
    """The points that a path names, by numbers or as corners of the zone."""
    points = [list(named(grid, point)) if point.isidentifier() and point != "pi" else [constant(number, "a wave vector") for number in point.split(",")] for point in text.split()]
    if not points or len({len(point) for point in points}) > 1:
        raise UsageError(f"a path consists of points of {len(grid.size)} numbers each, such as \"{example(grid)}\", not \"{text}\"")
    return whole(grid, rows(grid, points))


def zone(grid: Grid) -> dict[str, tuple]:
    """The corners of its zone, by name."""
    crystal = CRYSTALS.get(grid.places.name) if grid.places is not None else None
    return dict(crystal.corners) if crystal else {"Gamma": (0,) * len(grid.size)}


def named(grid: Grid, point: str) -> tuple:
    """A corner of the zone. Raises UsageError."""
    known = zone(grid)
    if point not in known:
        raise UsageError(f"the Brillouin zone of this lattice has no point '{point}'; it has: {', '.join(known)}, or give numbers, such as {example(grid).split()[1]}")
    return known[point]


def name_of(grid: Grid, m) -> str:
    """Of a wave, where it is a corner of the zone; else ""."""
    return next((name for name, q in zone(grid).items() if np.allclose(np.array(q) * grid.size, m, rtol=0, atol=WHOLE)), "")


def example(grid: Grid) -> str:
    return " ".join(",".join(["0"] * k + [end] + ["0"] * (len(grid.size) - 1 - k)) for k, end in ((0, "0"), (0, "1/2")))


def whole(grid: Grid, q) -> np.ndarray:
    """m = q size. Raises UsageError for a q that is no wave of the lattice."""
    m = np.rint(q * grid.size)
    off = np.abs(q * grid.size - m) > WHOLE * np.maximum(1, np.abs(m))
    if off.any():
        row, k = np.argwhere(off)[0]
        n, low = grid.size[k], math.floor(q[row, k] * grid.size[k])
        raise UsageError(f"q = {q[row, k]:.10g} is not a wave vector of {n} cells; the nearest are {low}/{n} and {low + 1}/{n}")
    return m.astype(np.int64)


def along(points) -> np.ndarray:
    """The waves on the straight lines from point to point."""
    found = [points[:1]]
    for a, b in zip(points, points[1:]):
        steps = math.gcd(*map(int, b - a))
        found.append(a + np.outer(np.arange(1, steps + 1), (b - a) // max(1, steps)))
    return np.concatenate(found)


class Components:
    """S_q = (1/sqrt N) sum_j w_j exp(-2 pi i q.r_j) of states (N, 3), by an FFT over the cells."""

    def __init__(self, grid: Grid, m, basis=None):
        self.grid, self.at = grid, tuple((m % grid.size).T[::-1])
        self.phases = np.exp(-2j * np.pi * (m / grid.size) @ grid.basis(basis).T) / math.sqrt(grid.count)

    def of(self, w) -> np.ndarray:
        """(waves, 3) of one state."""
        cells = self.grid.cells(w)
        found = np.zeros((len(self.phases), 3), complex)
        for site in range(self.grid.sites):
            for k in range(3):
                found[:, k] += self.phases[:, site] * np.fft.fftn(cells[..., site, k])[self.at]
        return found
