"""Shells of neighbours by their distance: one rule for every lattice that has vectors and positions."""
from __future__ import annotations

import numpy as np

from . import limits

SHELLS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")
SAME = 1e-6         # relative: closer distances are equal
APART = 1e-4        # relative: distances that differ by less, and are not equal, are a slip of digits


class Unclear(ValueError):
    """What vectors and positions do not decide, or cannot have."""


def shell(vectors, positions, directions: int, number: int) -> tuple:
    """The bonds of the shell `number`, from 0, in the form of `Lattice.bonds`: each once, in the order of `once`. Raises Unclear.

    vectors: rows (x, y, z), the first `directions` of which repeat the cell; positions: rows of fractions of all vectors.
    """
    reach = np.linalg.norm(np.asarray(vectors, float), axis=1).min()
    while True:
        bonds, lengths = within(vectors, positions, directions, reach)
        steps = np.flatnonzero(np.diff(lengths) > SAME * lengths[1:]) + 1
        if len(steps) > number:     # the last shell may be cut off at the reach
            break
        reach *= 1.5
    first, last = [0, *steps][number], steps[number]
    clear(lengths[:last + 1])
    return once(bonds[first:last])


def within(vectors, positions, directions: int, reach: float):
    """((from, to, *offset) of all bonds up to the length `reach`, their lengths), by rising length; a bond and its reverse both."""
    a, f = np.asarray(vectors, float), np.asarray(positions, float)
    most = np.floor(reach * np.linalg.norm(np.linalg.pinv(a), axis=0)[:directions] + np.ptp(f, axis=0)[:directions] + SAME).astype(int)
    if np.prod(2 * most + 1.0) * len(f) ** 2 > limits.LOOKED_AT:
        raise Unclear(f"too many cells lie within {reach:.6g} of a site: the lattice vectors have very different lengths or are nearly parallel")
    cells = np.indices(2 * most + 1).reshape(directions, -1).T - most
    steps = np.zeros((len(cells), len(a)))
    steps[:, :directions] = cells
    length = np.linalg.norm((steps[None, None] + (f[None, :] - f[:, None])[:, :, None]) @ a, axis=-1)
    length[np.arange(len(f)), np.arange(len(f)), len(cells) // 2] = np.inf      # a site and itself
    first, second, cell = np.nonzero(length <= reach * (1 + SAME))
    length = length[first, second, cell]
    order = np.argsort(length, kind="stable")
    return np.column_stack([first, second, cells[cell]])[order], length[order]


def clear(lengths) -> None:
    """Raise Unclear for distances that are nearly the same, and for sites at one place."""
    if lengths[0] <= APART * lengths[-1]:
        raise Unclear(f"two sites are at the same position: they are {lengths[0]:.6g} apart")
    jumps = np.diff(lengths) / lengths[1:]
    for k in np.flatnonzero((jumps > SAME) & (jumps < APART)):
        raise Unclear(f"bonds of lengths {lengths[k]:.9g} and {lengths[k + 1]:.9g} are nearly one shell")


def once(bonds) -> tuple:
    """One of each bond and its reverse: from the lower site of a cell to the higher, or forward; by sites, then by cells, the first direction fastest."""
    kept = [(a, b, *offset) for a, b, *offset in bonds.tolist() if a < b or a == b and tuple(offset[::-1]) > (0,) * len(offset)]
    kept.sort(key=lambda bond: (bond[0], bond[1], bond[:1:-1]))
    return tuple(((a, (0,) * len(offset)), (b, tuple(offset))) for a, b, *offset in kept)
