"""Extrapolation of the explicit midpoint rule by numpy, the witness's own: by the table of Aitken and Neville, not by weights.

Hairer, Norsett, Wanner, II.9: T_j1 is the end of 2j steps through h, and

    T_j,k+1 = T_jk + (T_jk - T_j-1,k)/((j/(j - k))^2 - 1).
"""
from __future__ import annotations

import numpy as np


def step(witness, w, t: float, h: float, rows: int):
    """States are kept in extended precision: the differences of the table are small."""
    start, table = np.asarray(w, np.longdouble), []
    for j in range(1, rows + 1):
        table.append([midpoints(witness, start, t, h, 2 * j)])
        for k in range(1, j):
            (before, last), ratio = (table[-2][k - 1], table[-1][k - 1]), np.longdouble(j) / (j - k)
            table[-1].append(last + (last - before) / (ratio**2 - 1))
    end = np.asarray(table[-1][-1], float)
    return end if np.all(np.isfinite(end)) else None


def midpoints(witness, start, t: float, h: float, n: int):
    """The end of n steps of the explicit midpoint rule, the first one by Euler's."""
    part = np.longdouble(h) / n
    older, newer = start, start + part * slope(witness, start, t)
    for m in range(1, n):
        older, newer = newer, older + 2 * part * slope(witness, newer, t + m * h / n)
    return newer


def slope(witness, w, t: float):
    return witness.vector_field(np.asarray(w, float), t)
