"""The magnetic cell of a state: the translations of the lattice, with rotations of all spins or without, that leave the linearised motion
near it unchanged."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..run.fields.grid import Grid, said
from ..run.settings import whole
from ..run.step.evaluated import Evaluated
from .linear import Linear

SAME = 1e-5         # of spins, of their length, and of blocks, of the largest: what is taken for equal


class Sites:
    """Where the sites of all families are: cell (sites, directions), of each; member: its number within the cell; at (cells, members): the
    site; members: family -> slice.

    Raises UsageError for a family that does not have the same number of sites in every cell."""

    def __init__(self, grid: Grid, numbers: Evaluated):
        self.grid, self.cells, within, number, offset = grid, math.prod(grid.size), [], [], 0
        self.members: dict = {}
        for name, (first, count) in numbers.places.items():
            if count % self.cells:
                raise UsageError(f"'{name}' has {count} sites, which cannot be divided equally among the {self.cells} cells of the lattice")
            each = count // self.cells
            within.append(offset + np.arange(count) % each)
            number.append(np.arange(count) // each)
            self.members[name] = slice(offset, offset + each)
            offset += each
        self.member, flat = np.concatenate(within), np.concatenate(number)
        self.cell = np.stack(np.unravel_index(flat, grid.size[::-1])[::-1], axis=1)
        self.at = np.empty((self.cells, offset), int)
        self.at[flat, self.member] = np.arange(len(flat))

    def shifted(self, direction: int, by: int) -> np.ndarray:
        """Of each site the one `by` cells farther, around the lattice."""
        return self.site(self.cell + by * np.eye(len(self.grid.size), dtype=int)[direction], self.member)

    def site(self, cell, member) -> np.ndarray:
        """The site at a cell, around the lattice."""
        return self.at[np.ravel_multi_index(tuple(cell.T[::-1]), self.grid.size[::-1], mode="wrap"), member]


@dataclass(frozen=True)
class Order:
    """size: cells in each direction after which the motion repeats. turns: by one cell of each direction, (directions, 3, 3), of an order
    that repeats in every cell but for a rotation; None where it repeats as it is."""
    size: tuple[int, ...]
    turns: np.ndarray | None = None

    def waves(self) -> list:
        """[(theta, P)]: the rotation by c cells is the sum over P exp(i theta.c)."""
        return [(np.zeros(len(self.size)), np.eye(3))] if self.turns is None else decomposed(self.turns)

    def rotations(self, cells) -> np.ndarray:
        """(cells, 3, 3), of cells (cells, directions)."""
        return np.real(sum(np.exp(1j * cells @ theta)[:, None, None] * p for theta, p in self.waves()))


def order_of(linear: Linear, sites: Sites, given=None) -> Order:
    """The smallest, or the one that is given. Raises UsageError for one that the state does not have."""
    if given is not None:
        return given_order(linear, sites, given)
    return turning(linear, sites) or Order(tuple(period(linear, sites, d) for d in range(len(sites.grid.size))))


def given_order(linear: Linear, sites: Sites, given) -> Order:
    size = tuple(whole(n, "the magnetic cell") for n in np.atleast_1d(given))
    if len(size) != len(sites.grid.size) or any(not 1 <= s <= n or n % s for s, n in zip(size, sites.grid.size)):
        raise UsageError(f"the magnetic cell of this lattice must divide its {said(sites.grid.size)} cells, as {list(sites.grid.size)} does; "
                         f"{list(size)} does not")
    for d, by in enumerate(size):
        if by < sites.grid.size[d] and (why := difference(linear, sites, d, by)):
            raise UsageError(f"the state does not repeat after {by} cells of direction {d + 1}: {why}")
    return Order(size)


def period(linear: Linear, sites: Sites, direction: int) -> int:
    """The smallest shift that changes nothing; all cells of an open direction."""
    n = sites.grid.size[direction]
    if not sites.grid.periodic[direction]:
        return n
    return next((by for by in range(1, n) if n % by == 0 and not difference(linear, sites, direction, by)), n)


def turning(linear: Linear, sites: Sites) -> Order | None:
    """The order of a spiral: each cell is the one before, rotated, and so are the blocks. None where it is no such order."""
    size = sites.grid.size
    turns = [fitted(linear.w, linear.w[sites.shifted(d, 1)]) if n > 1 else np.eye(3) for d, n in enumerate(size)]
    if not all(sites.grid.periodic) or any(t is None for t in turns) or np.allclose(turns, np.eye(3), rtol=0, atol=SAME):
        return None
    commute = all(np.allclose(a @ b, b @ a, rtol=0, atol=SAME) for a in turns for b in turns)
    if not commute or any(difference(linear, sites, d, 1, t) for d, t in enumerate(turns)):
        return None
    return Order((1,) * len(size), np.array(turns))


def fitted(before, after) -> np.ndarray | None:
    """The rotation from some vectors to others that fits best (W. Kabsch, Acta Cryst. A 32 (1976) 922).

    None where vectors on one line leave it open."""
    u, strength, v = np.linalg.svd(after.T @ before)
    if strength[1] < SAME * strength[0]:
        return None
    return u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v


def difference(linear: Linear, sites: Sites, direction: int, by: int, turn=None) -> str:
    """What changes with a shift, turned back; "" where nothing does."""
    there, turn = sites.shifted(direction, by), np.eye(3) if turn is None else turn
    numbers, w, count = linear.numbers, linear.w, len(linear.w)
    off = np.linalg.norm(w[there] - w @ turn.T, axis=1) / np.linalg.norm(w, axis=1).max()
    if not off.max() <= SAME:
        return f"a spin differs by {off.max():.3g} of its length"
    alike = np.array_equal(numbers.moving, numbers.moving[there])
    if not alike or not np.allclose(linear.rate, linear.rate[there], rtol=SAME, atol=0):
        return "some sites are pinned or have a different kappa"
    pairs, shifted = linear.i * count + linear.j, there[linear.i] * count + there[linear.j]
    (keys, here), (others, other) = summed(pairs, linear.blocks), summed(shifted, turn @ linear.blocks @ turn.T)
    if not np.array_equal(keys, others):
        return "different pairs interact"
    gap = np.abs(here - other).max(initial=0.0) / np.abs(here).max(initial=1e-300)
    return "" if gap <= SAME else f"the Hessian differs by {gap:.3g} of its largest entry"


def summed(pairs, blocks) -> tuple:
    """(pairs in their order, each once; the sum of the blocks of each)."""
    keys, place = np.unique(pairs, return_inverse=True)
    total = np.zeros((len(keys), 3, 3))
    np.add.at(total, place, blocks)
    return keys, total


def decomposed(turns) -> list:
    """[(theta, P)] of rotations that commute: R_d = sum P exp(i theta_d), by the vectors that all of them leave along themselves.

    Those of equal theta are joined."""
    mixed = sum((d + 1) ** 0.5 * (t + t.T) + 1j * (d + 2) ** (1 / 3) * (t - t.T) for d, t in enumerate(turns))
    found: list = []
    for v in np.linalg.eigh(mixed)[1].T:
        theta = np.angle(np.einsum("a,dab,b->d", v.conj(), turns, v))
        same = [k for k, (other, _) in enumerate(found) if np.abs(np.exp(1j * theta) - np.exp(1j * other)).max() <= SAME]
        joined = found.pop(same[0]) if same else (theta, 0)
        found.append((joined[0], joined[1] + np.outer(v, v.conj())))
    return found
