"""Writes runtime/method/tables/smg_gauss_table.h: Gauss collocation with 1 to 8 stages (Hairer, Norsett, Wanner, Solving Ordinary
Differential Equations I, II.7), from 70 digits.

    python tests/coefficients/gauss.py > runtime/method/tables/smg_gauss_table.h
"""
from columns import unformatted
from mpmath import legendre, lu_solve, matrix, mp, mpf, polyroots, taylor

mp.dps = 70
MOST = 8

HEAD = """\
/* smidgen method: coefficients of Gauss collocation. Written by tests/coefficients/gauss.py; do not edit.
 *
 * Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.7: the nodes c_i are the zeros of the s-th
 * Legendre polynomial on [0, 1], b_j and a_ij the integrals of Lagrange's polynomials l_j over [0, 1] and [0, c_i].
 *
 *   smg_gauss_node[i]      c_i, where H depends on time
 *   smg_gauss_weight[i]    b_i
 *   smg_gauss_share[j][i]  a_ij / b_j, and what is not below the diagonal as 1 less its mirror image: that difference
 *                          is exact,
 *                          so b_i a_ij + b_j a_ji = b_i b_j holds without any error, whatever b was rounded to
 *                          (Antonana,
 *                          Makazaga, Murua 2017)
 *   smg_gauss_cross[i][j]  (a_ij/b_j + a_ij'/b_j' - 1)/2, j' = s + 1 - j, for i, j in the first half and j in the
 *                          middle. From the
 *                          symmetries of the nodes, a_ij/b_j - 1/2 is this one plus beta, a_ij'/b_j' - 1/2 this one
 *                          less beta,
 *                          where beta = -smg_gauss_cross[j][i], and for i' both with the other sign: with these numbers
 *                          b_i a_ij + b_j a_ji = b_i b_j holds without any error too
 *   smg_gauss_ahead[j][i]  (b_i / b_j) l_j(1 + c_i): the polynomial through the stages, one step on
 *
 * Stages fill whole blocks of SMG_LANES lanes: SMG_PADDED of them, the last one again (SMG_LAST) after the s-th; where
 * the lanes are sites (SMG_ROW_STAGES) there are as many as they are.
 * SMG_PAIR: high and low part, right to 1e-32; SMG_MIRROR: 1 less that. */
#ifndef SMG_GAUSS_TABLE_H
#define SMG_GAUSS_TABLE_H

#include "smg_lanes.h"

#define SMG_STAGE_BLOCKS ((SMG_STAGES + SMG_LANES - 1) / SMG_LANES)
#if SMG_ROW_STAGES
#define SMG_PADDED SMG_STAGES
#else
#define SMG_PADDED (SMG_STAGE_BLOCKS * SMG_LANES)
#endif
#if SMG_PADDED - SMG_STAGES == 0
#define SMG_LAST(x) x
#elif SMG_PADDED - SMG_STAGES == 1
#define SMG_LAST(x) x, x
#elif SMG_PADDED - SMG_STAGES == 2
#define SMG_LAST(x) x, x, x
#else
#define SMG_LAST(x) x, x, x, x
#endif

#if SMG_LANES > 1
#define SMG_ALIGNED __attribute__((aligned(sizeof(smg_lanes))))
#else
#define SMG_ALIGNED
#endif

#define SMG_PAIR(high, low) ((smg_real)(high) + (smg_real)(low))
#define SMG_MIRROR(high, low) (1 - SMG_PAIR(high, low))
"""


def nodes(s):
    """The zeros of P_s(2 c - 1), symmetric about 1/2."""
    if s == 1:
        return [mpf(1) / 2]
    roots = polyroots(taylor(lambda x: legendre(s, x), 0, s)[::-1], maxsteps=500, extraprec=400)
    found = sorted((1 + x.real) / 2 for x in roots)
    return [(a + 1 - b) / 2 for a, b in zip(found, reversed(found))]


def lagrange(c):
    """Coefficients of l_j, lowest power first, as rows."""
    s = len(c)
    powers = matrix([[x**k for x in c] for k in range(s)])          # sum_j l_j(t) c_j^k = t^k
    return [[lu_solve(powers, matrix([int(k == q) for q in range(s)]))[j] for k in range(s)] for j in range(s)]


def gauss(s):
    """(c, b, a, l(1 + c)) of s stages: l[i][j] = l_j(1 + c_i)."""
    c = nodes(s)
    rows = lagrange(c)

    def integral(row, x):
        return sum(p * x**(k + 1) / (k + 1) for k, p in enumerate(row))

    b = [integral(row, mpf(1)) for row in rows]
    b = [(x + y) / 2 for x, y in zip(b, reversed(b))]
    a = [[integral(row, x) for row in rows] for x in c]
    ahead = [[sum(p * (1 + x)**k for k, p in enumerate(row)) for row in rows] for x in c]
    return c, b, a, ahead


def pair(x, name="SMG_PAIR"):
    high = float(x)
    return f"{name}({high!r}, {float(x - mpf(high))!r})"


def share(a, b, i, j):
    """a_ij / b_j in C."""
    if i == j:
        return "(smg_real)0.5"
    if i > j:
        return pair(a[i][j] / b[j])
    near = a[j][i] / b[i]
    assert 0.5 < near < 2                                           # there 1 - near is exact (Sterbenz)
    return pair(near, "SMG_MIRROR")


def crossed(a, b):
    """(a_ij/b_j + a_ij'/b_j' - 1)/2 of the first half of the stages, j' = s + 1 - j; a_ij/b_j - 1/2 in the column of the middle one."""
    s = len(b)
    shares = [[a[i][j] / b[j] for j in range(s)] for i in range(s)]
    return [[(shares[i][j] + shares[i][s - 1 - j] - 1) / 2 for j in range((s + 1) // 2)] for i in range(s // 2)]


def table(s):
    c, b, a, ahead = gauss(s)
    every = range(s)

    def listed(items, indent="    "):
        return "{\n" + ",\n".join(indent + x for x in items) + "}"

    def filled(items):
        return "{" + ", ".join([*items[:-1], f"SMG_LAST({items[-1]})"]) + "}"

    shares = [filled([share(a, b, i, j) for i in every]) for j in every]
    far = [filled([f"(smg_real){float(b[i] / b[j] * ahead[i][j])!r}" for i in every]) for j in every]
    weights = filled([pair(x) for x in b])
    crosses = [", ".join(pair(x) for x in row) for row in crossed(a, b)] or ["0"]
    return (f"\n#if SMG_STAGES == {s}\n"
            f"#if SMG_TIMED\nstatic const smg_real smg_gauss_node[{s}] = {listed(pair(x) for x in c)};\n#endif\n"
            f"SMG_ALIGNED static const smg_real smg_gauss_weight[SMG_PADDED] = {weights};\n"
            f"SMG_ALIGNED static const smg_real smg_gauss_share[{s}][SMG_PADDED] = {listed(shares)};\n"
            f"SMG_ALIGNED static const smg_real smg_gauss_ahead[{s}][SMG_PADDED] = {listed(far)};\n"
            f"#if SMG_ROW_STAGES\nstatic const smg_real smg_gauss_cross[{max(1, s // 2)}][{(s + 1) // 2}] = {listed('{' + x + '}' for x in crosses)};\n#endif\n"
            "#endif\n")


def header():
    return f"{HEAD}\n{unformatted(''.join(table(s) for s in range(1, MOST + 1)))}\n#endif\n"


if __name__ == "__main__":
    print(header(), end="")
