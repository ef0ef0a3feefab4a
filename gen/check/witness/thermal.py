"""Thermal noise by numpy: the map around a step, from Philox as its authors give it, with the functions of numpy.

Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
"""
from __future__ import annotations

import numpy as np

MULTIPLIERS = np.array([0xD2511F53, 0xCD9E8D57], np.uint64)
WEYL = np.array([0x9E3779B9, 0xBB67AE85], np.uint64)
LOW = np.uint64(0xFFFFFFFF)
MOST = 31.5         # of D h/2, beyond which directions are forgotten


def philox(counter, key: int) -> np.ndarray:
    """Ten rounds of Philox4x32: (n, 4) words of 32 bits from counters of the same shape, under a key of 64 bits."""
    x, k = np.array(counter, np.uint64), np.array([key & 0xFFFFFFFF, key >> 32], np.uint64)
    for _ in range(10):
        a, b = (MULTIPLIERS * x[:, ::2]).T
        x = np.stack([(b >> np.uint64(32)) ^ x[:, 1] ^ k[0], b & LOW, (a >> np.uint64(32)) ^ x[:, 3] ^ k[1], a & LOW], 1)
        k = (k + WEYL) & LOW
    return x


def normals(seed: int, step: int, sites: int, use: int, member: int = 0) -> np.ndarray:
    """Three normal numbers of each site, (sites, 3), by Box and Muller. Counter: step 48 bits, site 40, use 8, member 32."""
    word = [step + (k << 48) + (use << 88) + (member << 96) for k in range(sites)]
    u = philox([[n >> s & 0xFFFFFFFF for s in (0, 32, 64, 96)] for n in word], seed).astype(float)
    r, turn = np.sqrt(-2 * np.log((u[:, ::2] + 0.5) / 2**32)), 2 * np.pi * u[:, 1::2] / 2**32
    return np.stack([r[:, 0] * np.cos(turn[:, 0]), r[:, 0] * np.sin(turn[:, 0]), r[:, 1] * np.cos(turn[:, 1])], 1)


def turned(w, theta) -> np.ndarray:
    """Each w about theta by |theta| (Rodrigues)."""
    angle = np.linalg.norm(theta, axis=1)[:, None]
    axis = theta / np.where(angle > 0, angle, 1)
    return w * np.cos(angle) + np.cross(axis, w) * np.sin(angle) + axis * (axis * w).sum(1)[:, None] * (1 - np.cos(angle))


def turns(diffusion, h: float, seed: int, step: int, half: int, member: int = 0) -> list:
    """The Gaussian vectors of N(h/2), one array (sites, 3) after the other, of the variance 2 (x - x^2/6), x = D h/2; D = diffusion, (sites,). Where a site
    has no more turns, zeros."""
    x = np.minimum(MOST, diffusion * h / 2)
    count = np.floor(x).astype(int) + 1
    part = x / count
    deviation = np.sqrt(2 * (part - part**2 / 6))
    return [np.where(count > j, deviation, 0)[:, None] * normals(seed, step, len(x), 2 * j + half, member) for j in range(count.max(initial=1))]


def heat(w, diffusion, h: float, seed: int, step: int, half: int, member: int = 0) -> np.ndarray:
    """N(h/2): w (sites, 3) turned about the vectors of `turns`."""
    for theta in turns(diffusion, h, seed, step, half, member):
        w = np.where((theta != 0).any(axis=1)[:, None], turned(w, theta), w)
    return w
