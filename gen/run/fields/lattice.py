"""What one state on a lattice tells, computed where it is called for and nowhere else.

    grid = smidgen.lattice.of(spec)
    smidgen.lattice.charge(result.w["w"], grid)         # of every output
"""
from __future__ import annotations

import math

import numpy as np

from ...errors import UsageError
from ...public import public
from .grid import Grid, of

__all__ = ["Grid", "charge", "correlation", "magnetisation", "of"]


@public
def magnetisation(w) -> np.ndarray:
    """The mean vector (1/N) sum_i w_i of states of shape (..., N, 3), as an array of shape (..., 3).

    :raises UsageError: for another shape.
    """
    if np.ndim(w) < 2 or np.shape(w)[-1] != 3 or not np.shape(w)[-2]:
        raise UsageError(f"states must have shape (.., N, 3), not {np.shape(w)}")
    return np.mean(np.asarray(w), axis=-2)


@public
def correlation(w, grid: Grid) -> np.ndarray:
    """The correlation function C(r) = (1/cells) sum_c w_c.w_(c+r) of states on a periodic lattice with one site per cell.

    Computed by FFT: the transform of C is |S(q)|^2 (Wiener and Khinchin).

    :param w: states of shape (..., N, 3).
    :returns: an array of shape (..., last direction, ..., first direction); r is counted in cells, modulo the size.
    :raises UsageError: if a direction is open.
    """
    if not all(grid.periodic) or grid.sites > 1:
        raise UsageError("correlations in space are defined only for a periodic lattice with one site per cell")
    axes = tuple(range(-1 - len(grid.size), -1))
    q = np.fft.fftn(grid.cells(w)[..., 0, :], axes=axes)
    power = np.sum(np.abs(q) ** 2, axis=-1)
    return np.fft.ifftn(power, axes=tuple(a + 1 for a in axes)).real / math.prod(grid.size)


@public
def charge(w, grid: Grid):
    """The topological charge Q of states on a two-dimensional lattice with one site per cell.

    Each cell is divided along its diagonal into two triangles. The directions a, b, c of the spins at the corners of a triangle,
    counter-clockwise, span the solid angle Omega with

        tan(Omega/2) = a.(b x c)/(1 + a.b + b.c + c.a),     Q = sum Omega/(4 pi)

    (B. Berg and M. Luscher, Nucl. Phys. B 190 (1981) 412; A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125). In the
    continuum, Q = (1/4 pi) int w.(dw/dx x dw/dy), which is -1 for a skyrmion whose core points down. If both directions are periodic, Q is
    an integer.

    :param w: states of shape (..., N, 3).
    :returns: an array of shape (...).
    :raises UsageError: for another kind of lattice.
    """
    if len(grid.size) != 2 or grid.sites > 1:
        raise UsageError("a topological charge is defined only for a two-dimensional lattice with one site per cell")
    u = grid.cells(np.asarray(w, float))[..., 0, :]
    with np.errstate(invalid="ignore", divide="ignore"):        # a zero vector has no direction, and the charge is nan
        u = u / np.linalg.norm(u, axis=-1, keepdims=True)
    a, b, c, d = (corner(u, grid, step) for step in ((0, 0), (1, 0), (1, 1), (0, 1)))
    q = (solid_angles(a, b, c) + solid_angles(a, c, d)).sum(axis=(-1, -2)) / (4 * np.pi)
    return np.rint(q) + 0.0 if all(grid.periodic) else q        # no -0


def corner(u, grid: Grid, step) -> np.ndarray:
    """The spins `step` cells away, for every cell that has all its corners."""
    u = np.roll(u, [-step[1], -step[0]], axis=(-3, -2))
    return u[..., :grid.size[1] - (not grid.periodic[1]), :grid.size[0] - (not grid.periodic[0]), :]


def solid_angles(a, b, c) -> np.ndarray:
    """Of spherical triangles, between -2 pi and 2 pi."""
    def dot(x, y):
        return np.sum(x * y, axis=-1)
    return 2 * np.arctan2(dot(a, np.cross(b, c)), 1 + dot(a, b) + dot(b, c) + dot(c, a))
