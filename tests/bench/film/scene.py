"""The film: its equation in numbers, its start, and what the three programs are given (numpy alone).

    ds/dt = s x dH/ds,   H = - sum_bonds (J s.s' + D.(s x s')) - sum_sites (K_i s_z^2 + B(t) s_z)

on a square lattice of n x n sites, periodic, with D = D z x e of a bond along e. All rates are in rad/ps. A fourth of the sites, at random places of a cell of 8 x 8
that repeats, have a harder axis; B stays the same for an eighth of a ps and then jumps, so that programs that know constant fields alone can have it.
"""
import numpy as np

J, D = 10.0, 2.5
GAMMA = 0.17608595995168     # rad/(ps T), of the field
K = (0.5, 2.0)            # most sites, and the harder ones
PIECE = 0.125             # ps in which B stays
CELL = 8


def harder() -> np.ndarray:
    """Which sites of a cell are, [y, x]."""
    places = np.random.default_rng(7).permutation(CELL * CELL) < CELL * CELL // 4
    return places.reshape(CELL, CELL)


def pattern(n: int) -> np.ndarray:
    """Which of n x n sites are, site x + n y."""
    return np.tile(harder(), (n // CELL, n // CELL)).ravel()


def tesla(piece: int) -> float:
    """The field in that piece of time."""
    return 16.0 + 2.0 * abs(piece % 8 - 4)


def field(piece: int) -> float:
    """The same as a rate, B."""
    return GAMMA * tesla(piece)


def start(n: int) -> np.ndarray:
    """A spiral along x with some disorder, shape (n n, 3)."""
    x = np.tile(np.arange(n), n) * (2 * np.pi * 16 / n)
    w = np.stack([np.sin(x), np.zeros_like(x), np.cos(x)], axis=1) + 0.3 * np.random.default_rng(3).normal(size=(n * n, 3))
    return w / np.linalg.norm(w, axis=1)[:, None]
