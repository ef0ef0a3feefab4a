"""Elimination order and block-sparse LU of the C runtime, against numpy."""
import numpy as np
import pytest
from support.filters import (BUILDS, EVERY_BUILD, backward_error, block_pivots, feed, make,
                             positive, random)  # noqa: F401

from smidgen.compile.plan import ordering


# ---- block-sparse ------------------------------------------------------------------------

def grid(side):
    site = np.arange(side * side).reshape(side, side)
    return [*zip(site[:, :-1].ravel(), site[:, 1:].ravel()), *zip(site[:-1].ravel(), site[1:].ravel())]


def random_graph(n, m, rng):
    return [tuple(rng.choice(n, size=2, replace=False)) for _ in range(m)]


GRAPHS = {
    "no edges": (5, []),
    "one site": (1, []),
    "path": (30, [(i, i + 1) for i in range(29)]),
    "ring, repeated edges": (12, [(i, (i + 1) % 12) for i in range(12)] + [((i + 1) % 12, i) for i in range(12)]),
    "star": (20, [(0, i) for i in range(1, 20)]),
    "complete": (9, [(i, j) for i in range(9) for j in range(i)]),
    "grid": (64, grid(8)),
    "random": (60, random_graph(60, 120, random(3))),
    "two parts": (10, [(0, 1), (1, 2), (7, 8), (8, 9), (7, 9)]),
}


def sparse_system(n, edges, bs, rng):
    """Blocks by pair of sites, and the full matrix."""
    pairs = sorted({(i, i) for i in range(n)} | {(int(i), int(j)) for i, j in edges}
                   | {(int(j), int(i)) for i, j in edges})
    degree = len(edges) * 2 / n + 1
    blocks = {p: rng.normal(size=(bs, bs)) / (bs * degree) + (p[0] == p[1]) * np.eye(bs) for p in pairs}
    full = np.zeros((n, bs, n, bs))
    for (i, j), block in blocks.items():
        full[i, :, j, :] = block
    return blocks, full.reshape(n * bs, n * bs)


def solve_sparse(program, pattern, blocks, b):
    n, bs = b.shape
    A = np.zeros((pattern.blocks, bs, bs))
    pairs = np.array(list(blocks))
    A[pattern.position(pairs[:, 0], pairs[:, 1])] = list(blocks.values())
    out = feed(program, [n, pattern.blocks], pattern.rowptr, pattern.col, pattern.diag, A, b[pattern.perm])
    x = np.empty_like(b)
    x[pattern.perm] = out[2:].reshape(n, bs)
    return out[0], out[1], x


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("bs", [2, 3])
def test_sparse_solves(make, build, bs):
    for name, (n, edges) in GRAPHS.items():
        rng = random(n)
        blocks, full = sparse_system(n, edges, bs, rng)
        b = rng.normal(size=(n, bs))
        status, ok, x = solve_sparse(make(build, "sparse", bs), ordering.symbolic(n, edges), blocks, b)
        order = ordering.symbolic(n, edges).perm
        rows = (order[:, None] * bs + np.arange(bs)).ravel()
        assert ok == all(positive(p)[0] for p in block_pivots(full[np.ix_(rows, rows)], bs)), name
        assert status == 0 and backward_error(full, x.ravel(), b.ravel()) < 1e-13, name


@pytest.mark.quick
@pytest.mark.parametrize("bs", [2, 3])
def test_sparse_names_the_singular_row(make, bs):
    n, edges = GRAPHS["grid"]
    pattern = ordering.symbolic(n, edges)
    blocks = {(i, i): np.eye(bs) * (i != 17) for i in range(n)}
    status, ok, _ = solve_sparse(make("gcc", "sparse", bs), pattern, blocks, np.ones((n, bs)))
    assert status == 1 + pattern.place[17] and ok == 0


@pytest.mark.quick
@pytest.mark.parametrize("name", GRAPHS)
def test_pattern_is_that_of_the_factors(name):
    """Against the elimination game on a full matrix of ones: exactly the blocks that fill."""
    n, edges = GRAPHS[name]
    pattern = ordering.symbolic(n, edges)
    full = np.eye(n, dtype=bool)
    for i, j in edges:
        full[pattern.place[i], pattern.place[j]] = full[pattern.place[j], pattern.place[i]] = True
    original = full.sum()
    for p in range(n):
        full[p + 1:, p + 1:] |= np.outer(full[p + 1:, p], full[p, p + 1:])
    mine = np.zeros((n, n), dtype=bool)
    for i in range(n):
        row = pattern.col[pattern.rowptr[i]:pattern.rowptr[i + 1]]
        assert np.all(np.diff(row) > 0) and pattern.col[pattern.diag[i]] == i
        mine[i, row] = True
    assert np.array_equal(mine, full) and pattern.fill == full.sum() - original
    assert np.array_equal(np.sort(pattern.perm), np.arange(n))


@pytest.mark.quick
def test_trees_do_not_fill_and_grids_fill_little():
    n, edges = GRAPHS["star"]
    assert ordering.symbolic(n, edges).fill == 0
    rng = random(8)
    tree = [(i, int(rng.integers(i))) for i in range(1, 300)]
    assert ordering.symbolic(300, tree).fill == 0
    side = 24  # minimum degree: O(n log n); the natural order fills n^1.5 = 2*24^3
    assert ordering.symbolic(side * side, grid(side)).fill < 0.6 * 2 * side**3


@pytest.mark.quick
def test_fill_limit():
    n, edges = GRAPHS["grid"]
    blocks = ordering.symbolic(n, edges).blocks
    assert ordering.symbolic(n, edges, limit=blocks).blocks == blocks
    with pytest.raises(ordering.TooMuchFill):
        ordering.symbolic(n, edges, limit=blocks - 1)


@pytest.mark.quick
def test_ordering_refuses_what_it_does_not_know():
    with pytest.raises(ValueError):
        ordering.symbolic(3, [(0, 3)])
    with pytest.raises(KeyError):
        ordering.symbolic(4, [(0, 1), (2, 3)]).position([0], [2])
