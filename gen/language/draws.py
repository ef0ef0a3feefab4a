"""Random numbers that a counter gives, without a state: Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3",
SC 2011), and normal ones by Box and Muller, with the operations of runtime/core/smg_random.h in their order: the bits are those of the C.
"""
from __future__ import annotations

import math

import numpy as np

UNIFORM, NORMAL, START = 64, 65, 66     # uses of the counter; smg_random.h lists all
BEFORE = 2 ** 47         # the step of pairs whose larger index is -1; 0 is that of single sites
LOW, HALF = np.uint64(0xFFFFFFFF), np.uint64(32)


def philox(counter, key) -> tuple:
    """Four words of 32 bits, from a counter of four such arrays and a key of 64 bits."""
    key = np.asarray(key, np.uint64)
    x, low, high = tuple(np.asarray(word, np.uint64) for word in counter), key & LOW, key >> HALF
    for k in range(10):
        a, b = np.uint64(0xD2511F53) * x[0], np.uint64(0xCD9E8D57) * x[2]
        x = ((b >> HALF) ^ x[1] ^ (low + np.uint64(k * 0x9E3779B9)) & LOW, b & LOW, (a >> HALF) ^ x[3] ^ (high + np.uint64(k * 0xBB67AE85)) & LOW, a & LOW)
    return x


def words(seed, step, site, use: int, member: int = 0) -> tuple:
    """Those of a counter: step 48 bits, site 40, use 8, member 32. Integers, or arrays of them."""
    n, k = whole(step), whole(site)
    second = n >> HALF & np.uint64(0xFFFF) | (k & np.uint64(0xFFFF)) << np.uint64(16)
    third = k >> np.uint64(16) & np.uint64(0xFFFFFF) | np.uint64(use << 24)
    return philox((n & LOW, second, third, np.uint64(member)), whole(seed))


def whole(x) -> np.ndarray:
    """Integers, those below 0 less 2^64, as C takes them."""
    return np.asarray(x).astype(np.int64).view(np.uint64) if np.asarray(x).dtype.kind != "u" else np.asarray(x, np.uint64)


def of_sites(use: int, seed, i, j=None) -> tuple:
    """The words of a site, or of two in either order."""
    if j is None:
        return words(seed, 0, i, use)
    last = np.maximum(i, j)
    return words(seed, np.where(last == -1, BEFORE, last + 1), np.minimum(i, j), use)


def uniform(seed, *sites) -> np.ndarray:
    """A number in (0, 1) of a site, or of two in either order."""
    x = of_sites(UNIFORM, seed, *sites)
    return ((x[0] << np.uint64(20) | x[1] >> np.uint64(12)).astype(float) + 0.5) / 4503599627370496.0


def normal(seed, *sites) -> np.ndarray:
    """A normal number, of mean 0 and variance 1."""
    x = of_sites(NORMAL, seed, *sites)
    return polar(np.sqrt(minus_two_log(x[0])), x[1])[0]


def directions(seed: int, family: int, count: int, member: int = 0, first: int = 0) -> np.ndarray:
    """Random unit vectors, (count, 3), alike in all directions: of three normal numbers. first: the site of the first of them."""
    x = words(seed, family, np.arange(first, first + count), START, member)
    v = np.stack([*polar(np.sqrt(minus_two_log(x[0])), x[1]), polar(np.sqrt(minus_two_log(x[2])), x[3])[0]], axis=1)
    return v / np.sqrt(v[:, 0] * v[:, 0] + v[:, 1] * v[:, 1] + v[:, 2] * v[:, 2])[:, None]


def minus_two_log(k) -> np.ndarray:
    """-2 ln((k + 1/2)/2^32). With u = m/2^e, m from sqrt(1/2) to sqrt(2), f = (m - 1)/(m + 1), ln u = 2 (f + f^3/3 + ..) - e ln 2."""
    m, e = np.frexp((k.astype(float) + 0.5) / 4294967296.0)
    small = m < 0.70710678118654752
    m, e = np.where(small, 2 * m, m), (small - e).astype(float)
    f = (m - 1) / (m + 1)
    y = f * f
    series = y * (1.0 / 19)
    for n in range(17, 1, -2):
        series = y * (1.0 / n + series)
    return 1.3862943611198906 * e - 4 * f * (1 + series)


def polar(r, k) -> tuple:
    """r (cos, sin)(2 pi k/2^32): the angle is a whole number of quarters and at most an eighth of a turn more."""
    k = k.astype(np.int64)
    quarters = (k + 536870912) // 1073741824
    x = (k - quarters * 1073741824).astype(float) * 1.4629180792671596e-9
    c, s = r * (1 - one_minus_cos(x * x)), r * (x * sine_ratio(x * x))
    odd, turn = quarters % 2 == 1, quarters % 4
    p, q = np.where(odd, s, c), np.where(odd, c, s)
    return np.where((turn == 1) | (turn == 2), -p, p), np.where(turn >= 2, -q, q)


def alternating(y, numbers):
    """1/a! - y (1/b! - y (1/c! - ..)) of numbers a, b, c, .."""
    found = 0
    for n in reversed(numbers):
        found = 1.0 / math.factorial(n) - y * found
    return found


def one_minus_cos(y):
    """1 - cos x from y = x^2."""
    return y * alternating(y, range(2, 19, 2))


def sine_ratio(y):
    """sin(x)/x from y = x^2."""
    return alternating(y, range(1, 18, 2))
