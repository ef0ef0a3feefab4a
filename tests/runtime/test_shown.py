"""What the matrix of a step shows of its branch, for every shape of matrix, against numpy.

The bound is the largest row sum of abs(A - I). Coercive: x.A x >= x.x/4, that is all eigenvalues of
(A + A^T)/2 at or above 1/4. The pivots tell the sign of det A, and whether each of them is free of
eigenvalues <= 0.
"""
import numpy as np
import pytest
from support.filters import EVERY_BUILD, block_pivots, feed, make, positive, random  # noqa: F401

from smidgen.compile.plan import ordering


def told(full, bs):
    """(bound, coercive, pivots) of a full matrix by numpy, and whether all verdicts are clear."""
    lowest = np.linalg.eigvalsh((full + full.T) / 2).min() - 0.25
    pivots = [positive(p) for p in block_pivots(full, bs)]
    sign = 1 if np.linalg.det(full) > 0 else -1
    clear = abs(lowest) > 1e-9 and all(gap > 1e-9 for _, gap in pivots)
    return np.abs(full - np.eye(len(full))).sum(axis=1).max(), lowest > 0, 1 if all(p for p, _ in pivots) else 2 * sign, clear


def agrees(found, full, bs):
    """The verdicts that are clear; returns (coercive, pivots)."""
    bound, coercive, pivots, clear = told(full, bs)
    assert found[0] == pytest.approx(bound, rel=1e-14)
    if clear:
        assert found[1] == coercive and found[2] == pivots
    return coercive, pivots


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("bs", [2, pytest.param(3, marks=pytest.mark.long)])
def test_one_block(make, build, bs):
    rng, seen = random(bs), set()
    for shift in np.linspace(-1, 3, 30):
        A = rng.normal(size=(bs, bs)) / 2 + shift * np.eye(bs)
        seen.add(agrees(feed(make(build, "shown", bs), [0], A), A, bs))
    assert {c for c, _ in seen} == {True, False} and {p for _, p in seen} == {1, 2, -2}


@pytest.mark.parametrize("bs", [2, 3])
def test_the_edge_of_coercive_is_a_quarter(make, bs):
    """Eigenvalues turned into every direction: the least of them at 0.26 passes, at 0.24 does not."""
    for seed in range(20):
        turn = np.linalg.qr(random(seed).normal(size=(bs, bs)))[0]
        skew = random(seed).normal(size=(bs, bs))
        for least, expected in ((0.26, 1), (0.24, 0)):
            A = turn @ np.diag([least, 1.5, 3][:bs]) @ turn.T + skew - skew.T
            assert feed(make("gcc", "shown", bs), [0], A)[1] == expected


@pytest.mark.parametrize("bs", [2, 3])
def test_what_is_no_number_shows_nothing(make, bs):
    for place in range(bs * bs):
        A = np.eye(bs)
        A.flat[place] = np.nan
        bound, coercive, _ = feed(make("gcc", "shown", bs), [0], A)
        assert np.isnan(bound) and coercive == 0


def banded(n, k, bs, wrap, rng, shift):
    """Blocks A[i, d + k] with nothing beyond open ends, and the full matrix."""
    A, full = np.zeros((n, 2 * k + 1, bs, bs)), np.zeros((n, bs, n, bs))
    for i in range(n):
        for d in range(-k, k + 1):
            if wrap or 0 <= i + d < n:
                A[i, d + k] = rng.normal(size=(bs, bs)) / (2 * k + 1) / 2 + (d == 0) * shift * np.eye(bs)
                full[i, :, (i + d) % n, :] += A[i, d + k]
    return A, full.reshape(n * bs, n * bs)


@pytest.mark.parametrize("wrap", [0, 1])
@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_a_band(make, k, bs, wrap):
    """Its bound is that of the blocks, taken after the factorisation, which leaves them alone."""
    rng, seen = random(10 * k + wrap), set()
    for shift in np.linspace(-0.5, 2, 25):
        A, full = banded(2 * k + 4, k, bs, wrap, rng, shift)
        seen.add(agrees(feed(make("gcc-sanitized", "shown", bs), [1, len(A), k, wrap], A), full, bs))
    assert {c for c, _ in seen} == {True, False} and len({p for _, p in seen}) > 1


@pytest.mark.parametrize("bs", [2, 3])
def test_a_graph(make, bs):
    edges = [(i, (i + 1) % 9) for i in range(9)] + [(0, 4), (2, 7)]
    pattern, rng, seen = ordering.symbolic(9, edges), random(bs), set()
    for shift in np.linspace(-0.5, 2, 25):
        full = np.zeros((9, bs, 9, bs))
        A = np.zeros((pattern.blocks, bs, bs))
        for i, j in [*((i, i) for i in range(9)), *edges, *((j, i) for i, j in edges)]:
            full[pattern.place[i], :, pattern.place[j], :] = rng.normal(size=(bs, bs)) / 8 + (i == j) * shift * np.eye(bs)
            A[pattern.position([i], [j])[0]] = full[pattern.place[i], :, pattern.place[j], :]
        found = feed(make("gcc-sanitized", "shown", bs), [2, 9, pattern.blocks], pattern.rowptr, pattern.col, pattern.diag, A)
        seen.add(agrees(found, full.reshape(9 * bs, 9 * bs), bs))
    assert {c for c, _ in seen} == {True, False} and len({p for _, p in seen}) > 1
