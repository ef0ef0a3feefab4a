"""Block-band systems of the C runtime (chains and rings) against numpy, and mutants of their closure."""

import numpy as np
import pytest
from support.filters import (EVERY_BUILD, QUICK, backward_error, block_pivots, copied_runtime,
                             compile_filter, feed, make, positive, random)  # noqa: F401


# ---- block band --------------------------------------------------------------------------

def dense_band(A, periodic):
    """The n*bs square matrix of the blocks A[i, d + k]."""
    n, width, bs, _ = A.shape
    k, full = width // 2, np.zeros((n, bs, n, bs))
    for i in range(n):
        for d in range(-k, k + 1):
            if periodic or 0 <= i + d < n:
                full[i, :, (i + d) % n, :] = A[i, d + k]
    return full.reshape(n * bs, n * bs)


def band_system(n, k, bs, rng, shift=1.5):
    A = rng.normal(size=(n, 2 * k + 1, bs, bs)) / np.sqrt(bs * (2 * k + 1))
    A[:, k] += shift * np.eye(bs)
    return A, rng.normal(size=(n, bs))


def solve_band(program, A, b, periodic):
    n, width, bs, _ = A.shape
    out = feed(program, [n, width // 2, periodic, 1], A, b)
    return out[0], out[1], out[2:].reshape(n, bs)


def band_error(program, A, b, periodic):
    status, _, x = solve_band(program, A, b, periodic)
    assert status == 0
    full = dense_band(A, periodic)
    return backward_error(full, x.ravel(), b.ravel())


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("periodic", [0, 1])
def test_band_random(make, build, bs, periodic):
    """All widths and the shortest rings (n = 2k+1) included."""
    rng = random(bs)
    for k in (1, 2, 3, 4):
        for n in (2 * k + 1, 2 * k + 2, 2 * k + 3, 3 * k, 3 * k + 1, 20, 101):
            if n >= 2 * k + 1:
                A, b = band_system(n, k, bs, rng)
                assert band_error(make(build, "band", bs), A, b, periodic) < 1e-12


@pytest.mark.quick
@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("k", [1, 2])
def test_band_short_open_chains(make, n, k):
    A, b = band_system(n, k, 2, random(n))
    assert band_error(make("gcc-sanitized", "band"), A, b, 0) < 1e-14


@pytest.mark.quick
@pytest.mark.parametrize("k", [1, 2, 4])
def test_open_chain_ignores_blocks_beyond_its_ends(make, k):
    A, b = band_system(12, k, 2, random(k))
    for i in range(12):
        for d in range(-k, k + 1):
            if not 0 <= i + d < 12:
                A[i, d + k] = np.nan
    assert band_error(make("gcc-sanitized", "band"), A, b, 0) < 1e-14


@pytest.mark.quick
@pytest.mark.parametrize("build", QUICK)
@pytest.mark.parametrize("k", [1, 2, 3])
def test_long_ring_drops_decayed_fill(make, build, k):
    """Long and strongly dominant: the fill dies out on the way and comes back at the end."""
    A, b = band_system(1500, k, 2, random(k), shift=8)
    status, ok, x = solve_band(make(build, "band"), A, b, 1)
    n, i = 1500, np.arange(1500)
    residual = sum(np.einsum("nij,nj->ni", A[:, d + k], x[(i + d) % n]) for d in range(-k, k + 1)) - b
    assert status == 0 and ok == 1 and np.abs(residual).max() < 1e-14


def heisenberg_jacobian(n, h, rng, bs):
    """J = I - (h/2) D(X o P) of the smooth Heisenberg chain, in tangent or in plain coordinates."""
    t = 2 * np.pi * np.arange(n) / n
    theta = 0.7 + 0.3 * np.sin(3 * t) + 0.05 * np.cos(9 * t)
    m = np.stack([np.sin(theta) * np.cos(t), np.sin(theta) * np.sin(t), np.cos(theta)], axis=1)
    hat = lambda v: np.cross(np.eye(3), v)  # hat(v) u = v x u, up to the transpose taken below
    F = np.roll(m, 1, 0) + np.roll(m, -1, 0)
    P = np.eye(3) - m[:, :, None] * m[:, None, :]
    E = np.stack([np.linalg.svd(p)[0][:, :2] for p in P]) if bs == 2 else np.tile(np.eye(3), (n, 1, 1))
    A = np.zeros((n, 3, bs, bs))
    for i in range(n):
        A[i, 1] = np.eye(bs) - h / 2 * E[i].T @ -hat(F[i]).T @ E[i]
        for d in (-1, 1):
            A[i, d + 1] = -h / 2 * E[i].T @ hat(m[i]).T @ E[(i + d) % n]
    return A, rng.normal(size=(n, bs))


@pytest.mark.quick
@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("n", [100, 300])
def test_stiff_chain(make, n, bs):
    """h/ds^2 up to 16: no breakdown, and far better than the 1e-8 that a Newton step needs."""
    for h in (0.1, 1, 4, 16, -16):
        A, b = heisenberg_jacobian(n, h, random(n), bs)
        status, _, x = solve_band(make("gcc", "band", bs), A, b, 1)
        expected = np.linalg.solve(dense_band(A, 1), b.ravel())
        assert status == 0
        assert np.abs(x.ravel() - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.quick
@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("k", [1, 2])
def test_band_pivots_ok(make, k, bs):
    rng, seen = random(k), set()
    for trial in range(60):
        A, b = band_system(9, k, bs, rng, shift=rng.uniform(0.2, 2))
        for periodic in (0, 1):
            expected = all(positive(p)[0] for p in block_pivots(dense_band(A, periodic), bs))
            assert solve_band(make("gcc", "band", bs), A, b, periodic)[1] == expected
            seen.add(expected)
    assert seen == {True, False}


@pytest.mark.quick
@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("k", [1, 2])
def test_two_negative_pivots_do_not_cancel(make, k, bs):
    """Two far-apart blocks with one negative eigenvalue each: det > 0, the branch test fails."""
    A = np.zeros((20, 2 * k + 1, bs, bs))
    A[:, k] = np.eye(bs)
    A[3, k, 0, 0] = A[15, k, 0, 0] = -3
    status, ok, _ = solve_band(make("gcc", "band", bs), A, np.ones((20, bs)), 1)
    assert np.linalg.det(dense_band(A, 1)) > 1 and status == 0 and ok == 0


@pytest.mark.quick
@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("k", [1, 2, 3, 4])
@pytest.mark.parametrize("row", [0, 1, 5, 18, 19])
def test_band_names_the_singular_row(make, k, bs, row):
    A = np.zeros((20, 2 * k + 1, bs, bs))
    A[:, k] = np.eye(bs)
    A[row, k, -1] = 0
    for periodic in (0, 1):
        status, ok, _ = solve_band(make("gcc-sanitized", "band", bs), A, np.ones((20, bs)), periodic)
        assert status == 1 + row and ok == 0


@pytest.mark.quick
def test_singular_ring_is_refused(make):
    """The periodic Laplacian, in one component or in both: its last pivot is round-off."""
    for B in (np.eye(2), np.diag([1.0, 0.0])):
        A = np.tile(-B, (50, 3, 1, 1))
        A[:, 1] = 2 * B + np.diag([0.0, 1.0]) * (B[1, 1] == 0)
        assert solve_band(make("gcc", "band"), A, np.ones((50, 2)), 1)[0] == 50


MUTANTS = {
    "border column off by one": ("q->E[c < 0 ? c + k : c - m]",
                                 "q->E[c < 0 ? (c + k + 1) % k : c - m]"),
    "wrap to the wrong side": ("q->E[c < 0 ? c + k : c - m]", "q->E[c < 0 ? -1 - c : c - m]"),
    "border window one column late": ("const int64_t next = i + 1 + k;", "const int64_t next = i + k;"),
    "ring indices do not wrap": ("if (d < -k) d += n;", "(void)n;"),
    "border rows miss their wrapped blocks": ("smg_band_open_border(n, k, 0, A, q);",
                                              "smg_band_open_border(n, k, 1, A, q);"),
    "border's own blocks transposed": ("t - s + k) * SMG_BB", "s - t + k) * SMG_BB"),
    "fill dropped too early": ("#define SMG_NEGLIGIBLE (SMG_EPS * SMG_EPS * SMG_EPS)",
                               "#define SMG_NEGLIGIBLE 1e3"),
}


@pytest.mark.parametrize("mutant", [pytest.param(m, marks=pytest.mark.long) if k % 2 else m for k, m in enumerate(MUTANTS)])
def test_band_mutants_are_caught(mutant, tmp_path):
    """A wrong index or sign in the ring's closure shows in the residual."""
    old, new = MUTANTS[mutant]
    copied = copied_runtime(tmp_path)
    header = copied / "smg_band.h"
    text = header.read_text()
    assert text.count(old) == 1
    header.write_text(text.replace(old, new))
    program = compile_filter("gcc", "band", 2, tmp_path, copied)
    rng, worst = random(1), 0.0
    for k in (1, 2, 3):
        for n in (2 * k + 1, 11, 200):
            A, b = band_system(n, k, 2, rng, shift=1)
            status, _, x = solve_band(program, A, b, 1)
            error = backward_error(dense_band(A, 1), x.ravel(), b.ravel())
            worst = max(worst, 1.0 if status or not np.isfinite(error) else error)
    assert worst > 1e-8


@pytest.mark.parametrize("other", ["clang", "g++", "clang++"])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_same_bits_from_every_compiler(make, other, k):
    A, b = band_system(200, k, 2, random(k))
    first, last = (solve_band(make(build, "band"), A, b, 1)[2] for build in ("gcc", other))
    assert np.array_equal(first, last)
