"""The normal modes of the motion near an equilibrium, wave vector by wave vector.

On one magnetic cell of p sites that move, a(r, t) = v exp(i(2 pi k.r - omega t)), so that omega v = i G J A(k) v with the matrix A(k),
2p x 2p, of `linear`. Where A(k) has no eigenvalues of both signs, i A^(1/2) G J A^(1/2) is Hermitian and omega real; otherwise omega may
be complex. Wave vectors that differ by one of the reciprocal lattice of the magnetic cell have the same modes.
"""
from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..errors import UsageError
from ..run.fields.grid import said
from .linear import Linear, frames_of
from .magnetic_cell import Order, Sites

LARGEST_CELL = 1000     # sites of a magnetic cell: matrices of 64 MB
FLAT = 1e-9             # of the largest curvature: an eigenvalue of A(k) below that is 0
SLOW = 1e-7             # of rate times curvature: omega below that is 0, since it is the root of a curvature that is


class Found(NamedTuple):
    """Of one k: omega, rising (2p,); growth, the rate at which a mode grows; waves (2p, sites, 3): the deviations of the sites of the cell
    at a temperature, over the root of kT, NaN where there are none; lowest: the smallest eigenvalue of A(k)."""
    omega: np.ndarray
    growth: np.ndarray
    waves: np.ndarray
    lowest: float


class Modes:
    """The matrices A(k) of a state, and their modes."""

    def __init__(self, linear: Linear, order: Order, sites: Sites, basis):
        size, grid = np.array(order.size), sites.grid
        self.base = np.flatnonzero(np.all(sites.cell < size, axis=1) & linear.numbers.moving)
        if len(self.base) > LARGEST_CELL:
            raise UsageError(f"the magnetic cell, {said(order.size)} cells, has {len(self.base)} sites, more than {LARGEST_CELL}: linear "
                             "spin waves need a state that repeats in smaller cells, or a smaller lattice")
        home = sites.site(sites.cell % size, sites.member)
        frames = framed(linear, order, sites, home)
        self.connect(linear, frames, home, sites, basis)
        self.frames, self.rate, self.scale = frames[self.base], linear.rate[self.base], np.abs(linear.blocks).max(initial=0)
        self.zero = SLOW * self.scale * np.abs(self.rate).max(initial=0)
        self.sites, self.order, self.fractions = sites, order, basis[sites.member[self.base]]
        self.places, self.known = sites.cell[self.base] + self.fractions, {}

    def connect(self, linear: Linear, frames, home, sites: Sites, basis) -> None:
        """rows, columns, blocks: what joins the sites of the cell to others; far: by which vectors."""
        number = np.full(len(home), -1)
        number[self.base] = np.arange(len(self.base))
        mine = np.isin(linear.i, self.base)
        blocks, i, j = linear.tangent(frames)[mine], linear.i[mine], linear.j[mine]
        steps, share, which = images(sites.cell[j] - sites.cell[i], sites.grid)
        self.rows, self.columns = number[i[which]], number[home[j[which]]]
        self.blocks = blocks[which] * share[:, None, None]
        self.far = steps + (basis[sites.member[j]] - basis[sites.member[i]])[which]

    def of_family(self, family: str) -> tuple:
        """(which of the sites that move are of it, how many sites of it there are in a magnetic cell)."""
        members = self.sites.members[family]
        member = self.sites.member[self.base]
        return (member >= members.start) & (member < members.stop), (members.stop - members.start) * math.prod(self.order.size)

    def matrix(self, k) -> np.ndarray:
        """A(k), Hermitian."""
        p = len(self.base)
        found = np.zeros((p, p, 2, 2), complex)
        np.add.at(found, (self.rows, self.columns), self.blocks * np.exp(2j * np.pi * self.far @ k)[:, None, None])
        a = found.transpose(0, 2, 1, 3).reshape(2 * p, 2 * p)
        return (a + a.conj().T) / 2

    def at(self, k) -> Found:
        """The modes of a wave vector, in units of the reciprocal lattice."""
        around = np.rint(k * self.order.size) / self.order.size
        first = np.where(self.sites.grid.periodic, k - around, 0)
        key = tuple(np.round(first, 9) + 0.0)
        if key not in self.known:
            self.known[key] = self.found(first)
        found = self.known[key]
        return found._replace(waves=found.waves * np.exp(2j * np.pi * self.places @ (first - k))[:, None])

    def found(self, k) -> Found:
        """The same, computed."""
        a = self.matrix(k)
        curvature, vectors = np.linalg.eigh(a)
        largest = max(np.abs(curvature).max(), 1e-300)
        sign = 1 if curvature[0] >= -FLAT * largest else -1
        if sign * curvature.min() >= -FLAT * largest and sign * curvature.max() >= -FLAT * largest:
            root = (vectors * np.sqrt(np.clip(sign * curvature, 0, None))) @ vectors.conj().T
            omega, y = np.linalg.eigh(sign * 1j * root @ self.turned(root))
            with np.errstate(all="ignore"):
                waves = self.turned(root @ y) / np.where(np.abs(omega) > self.zero, omega, np.nan)
            return Found(omega, np.zeros(len(omega)), self.in_space(waves), float(curvature[0]))
        values = 1j * np.linalg.eigvals(self.turned(a))
        values = values[np.lexsort((values.imag, np.round(values.real / self.zero)))]
        return Found(values.real, values.imag, np.full((len(values), len(self.base), 3), np.nan), float(curvature[0]))

    def turned(self, a) -> np.ndarray:
        """G J a, for the columns of a."""
        pairs = a.reshape(len(self.rate), 2, -1)
        return (self.rate[:, None, None] * np.stack([-pairs[:, 1], pairs[:, 0]], axis=1)).reshape(a.shape)

    def in_space(self, waves) -> np.ndarray:
        """(2p, sites, 3) of columns in the frames."""
        return np.einsum("sam,sab->msb", waves.reshape(len(self.base), 2, -1), self.frames)


def framed(linear: Linear, order: Order, sites: Sites, home) -> np.ndarray:
    """Frames (sites, 2, 3): of the first magnetic cell, and those of others as they repeat or turn from there."""
    frames = frames_of(linear.normal)[home]
    return frames if order.turns is None else np.einsum("sab,scb->sac", frames, order.rotations(sites.cell))


def images(steps, grid) -> tuple:
    """(steps, share, number of each): the shortest ways around a periodic lattice; two ways of the same length share."""
    steps, share, which = steps.astype(float), np.ones(len(steps)), np.arange(len(steps))
    for d, (n, periodic) in enumerate(zip(grid.size, grid.periodic)):
        if not periodic:
            continue
        steps[:, d] -= n * np.ceil(steps[:, d] / n - 0.5)
        tie = np.flatnonzero(2 * steps[:, d] == n)
        share[tie] /= 2
        other = steps[tie]
        other[:, d] -= n
        steps, share, which = np.concatenate([steps, other]), np.concatenate([share, share[tie]]), np.concatenate([which, which[tie]])
    return steps, share, which
