"""Random numbers of formulas, one at a time: Philox from `thermal.philox`, normal ones by Box and Muller, whose logarithm, cosine and sine are
truncated series: the numbers are defined by them, to the bit, and any other program that sums them in the same order has them.
"""
from __future__ import annotations

import math

from . import thermal

UNIFORM, NORMAL = 64, 65    # uses of the counter


def number(kind: str, seed: int, *sites: int) -> float:
    """That of a seed and a site, or of two sites in either order."""
    step, site = (0, sites[0]) if len(sites) == 1 else (max(sites) + 1 or 2**47, min(sites))    # step 0 belongs to single sites
    use = UNIFORM if kind == "uniform" else NORMAL
    word = step % 2**48 + (site % 2**40 << 48) + (use << 88)
    random = [int(x) for x in thermal.philox([[word >> s & 0xFFFFFFFF for s in (0, 32, 64, 96)]], seed % 2**64)[0]]
    if kind == "uniform":
        return ((random[0] * 2**32 + random[1]) // 2**12 + 0.5) / 2.0**52
    return box_muller(random[0], random[1])


def box_muller(k: int, turn: int) -> float:
    """sqrt(-2 ln((k + 1/2)/2^32)) cos(2 pi turn/2^32)."""
    r, quarter = math.sqrt(minus_two_log(k)), (turn + 2**29) // 2**30
    x = float(turn - quarter * 2**30) * 1.4629180792671596e-9
    if quarter % 2:
        value = r * (x * series(x * x, 17))
    else:
        value = r * (1.0 - x * x * series(x * x, 18))
    return -value if quarter % 4 in (1, 2) else value


def series(y: float, last: int) -> float:
    """.. + y^2/(last - 4)! - y/(last - 2)! + 1/last!, each sign unlike the next, by Horner's rule from there."""
    total = 0.0
    while last > 0:
        total = 1.0 / math.factorial(last) - y * total
        last -= 2
    return total


def minus_two_log(k: int) -> float:
    """-2 ln((k + 1/2)/2^32) = 2 e ln 2 - 4 (f + f^3/3 + .. + f^19/19), f = (m - 1)/(m + 1), m = 2^e (k + 1/2)/2^32 from sqrt(1/2) on."""
    m, e = (k + 0.5) / 2.0**32, 0
    while m < 0.70710678118654752:
        m, e = 2.0 * m, e + 1
    f = (m - 1.0) / (m + 1.0)
    total = 1.0 / 19
    for n in range(17, 0, -2):
        total = 1.0 / n + f * f * total
    return 1.3862943611198906 * e - 4.0 * f * total
