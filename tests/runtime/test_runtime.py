"""Dense systems, the branch test, the single spin and frames of the C runtime, against numpy."""

import numpy as np
import pytest
from support.filters import (EVERY_BUILD, QUICK, backward_error, compile_filter, copied_runtime, feed, make,
                             positive, random)  # noqa: F401


# ---- dense ------------------------------------------------------------------------------

def solve_dense(program, A, b):
    count, n = b.shape
    out = feed(program, [n, count], np.concatenate([A.reshape(count, -1), b], axis=1))
    out = out.reshape(count, 1 + n)
    return out[:, 0], out[:, 1:]


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("n", [1, 2, 3, 4, 6, 8, 12, 17, 33, 100])
def test_dense_random(make, build, n):
    rng = random(n)
    A, b = rng.normal(size=(20, n, n)), rng.normal(size=(20, n))
    status, x = solve_dense(make(build, "dense"), A, b)
    assert not status.any()
    # Cramer's rule is forward stable only: its residual grows with the condition number.
    bound = 1e-15 * np.linalg.cond(A).max() if n < 4 else 1e-15 * n
    assert backward_error(A, x, b) < bound


@pytest.mark.parametrize("n", [200, 600])
def test_dense_large(make, n):
    rng = random(n)
    A, b = rng.normal(size=(1, n, n)), rng.normal(size=(1, n))
    status, x = solve_dense(make("gcc", "dense"), A, b)
    assert not status.any() and backward_error(A, x, b) < 1e-13


@pytest.mark.quick
@pytest.mark.parametrize("n", [2, 3, 4, 6, 8, 12, 17, 40])
def test_dense_needs_pivoting_and_grading(make, n):
    """Zero diagonal, and columns and rows over 24 decades."""
    rng = random(n + 100)
    cyclic = np.roll(np.eye(n), 1, axis=1) + 1e-20 * rng.normal(size=(n, n))
    graded = rng.normal(size=(n, n)) * np.logspace(-12, 12, n)
    A, b = np.array([cyclic, graded]), rng.normal(size=(2, n))
    status, x = solve_dense(make("gcc", "dense"), A, b)
    assert not status.any()
    expected = np.array([np.linalg.solve(cyclic, b[0]),
                         np.linalg.solve(graded * np.logspace(12, -12, n), b[1]) * np.logspace(12, -12, n)])
    assert np.allclose(x, expected, rtol=1e-9, atol=0)


@pytest.mark.quick
@pytest.mark.parametrize("build", QUICK)
@pytest.mark.parametrize("n", [2, 3, 4, 6, 8, 12, 17, 40])
def test_dense_singular(make, build, n):
    """Exactly and nearly singular matrices, zero and NaN are refused; 1e-8 from singular is not."""
    rng = random(n + 200)
    thin = rng.integers(-9, 9, size=(n, n - 1)).astype(float)
    rank = np.concatenate([thin, thin.sum(1, keepdims=True)], axis=1)
    nan = np.full((n, n), np.nan)
    near = rank + 1e-8 * rng.normal(size=(n, n))
    program = make(build, "dense")
    status, _ = solve_dense(program, np.array([rank, np.zeros((n, n)), nan, near]), np.ones((4, n)))
    assert status[0] == n and status[1] >= 1 and status[2] >= 1 and status[3] == 0


# ---- what a matrix shows of its branch ------------------------------------------------------

def branch_cases(n, rng):
    """Matrices about the identity: near it, far from it, with and without negative eigenvalues."""
    for spread in (0.1, 0.4, 1.0, 3.0):
        yield from np.eye(n) + spread * rng.normal(size=(30, n, n)) / np.sqrt(n)
    for turn in rng.normal(size=(20, n, n)):
        yield np.eye(n) + 5 * (turn - turn.T)           # far from I, and coercive: eigenvalues 1 +- i b


def branch_expected(A):
    """(coercive, sign of the determinant, bound) by numpy, and how clear the verdicts are."""
    least = np.linalg.eigvalsh((A + A.T) / 2).min() - 0.25
    sign, size = np.linalg.slogdet(A)
    return (least > 0, sign, np.abs(A - np.eye(len(A))).sum(axis=1).max()), min(abs(least), np.exp(size))


def branch_wrong(program, n):
    """How many verdicts differ from numpy's, where these are clear."""
    cases = np.array(list(branch_cases(n, random(n))))
    found = feed(program, [n, len(cases)], cases).reshape(-1, 3)
    expected, clear = zip(*(branch_expected(A) for A in cases))
    expected, clear = np.array(expected, float), np.array(clear) > 1e-9
    assert clear.mean() > 0.9 and 0.1 < expected[:, 0].mean() < 0.9 and -0.9 < expected[:, 1].mean() < 0.9
    same = (found[:, :2] == expected[:, :2]).all(axis=1) & (np.abs(found[:, 2] - expected[:, 2]) < 1e-12 * n)
    return int(np.sum(~same & clear))


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("n", [2, 3, 4, 5, 8, 13, 24])
def test_what_a_matrix_shows_of_its_branch(make, build, n):
    assert branch_wrong(make(build, "branch"), n) == 0


@pytest.mark.quick
def test_nan_shows_nothing(make):
    A = np.eye(5)
    A[3, 1] = np.nan
    coercive, _, bound = feed(make("gcc", "branch"), [5, 1], A)
    assert coercive == 0 and np.isnan(bound)


# ---- one spin ----------------------------------------------------------------------------

def own_spin(program, w, g):
    out = feed(program, [len(w)], np.concatenate([w, g], axis=1)).reshape(-1, 4)
    return out[:, 0], out[:, 1:]


def directions(rng, count):
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("radius", [1, 1e-3, 1e5])
def test_own_spin_solves_its_step(make, build, radius):
    """W = w + 2 m x g lies on the sphere and m along w + W, for weak and strong fields."""
    rng = random(int(radius))
    w = radius * directions(rng, 400)
    g = directions(rng, 400) * 10 ** rng.uniform(-6, 4, size=(400, 1))
    found, m = own_spin(make(build, "spin"), w, g)
    mbar = w + np.cross(m, g)
    W = 2 * mbar - w
    unit = mbar / np.linalg.norm(mbar, axis=1, keepdims=True)
    strong = 1 + np.linalg.norm(g, axis=1)
    assert found.all()
    assert np.all(np.abs(np.linalg.norm(m, axis=1) / radius - 1) < 1e-15)
    assert np.all(np.abs(np.linalg.norm(W, axis=1) / radius - 1) < 4e-15 * strong)
    # the direction of mbar is lost with its length, which falls like 1/|g|
    rho = np.linalg.norm(mbar, axis=1) / radius
    assert np.all(np.linalg.norm(m / radius - unit, axis=1) < 4e-15 * strong / rho)
    assert np.all(np.einsum("ij,ij->i", m, mbar) > 0)


@pytest.mark.quick
def test_own_spin_turns_by_the_exact_angle(make):
    """sin^2(phi/2) = [(4+a) - sqrt((4+a)^2 - 16 r^2 a)]/(8 r^2), a = (lambda h)^2, r the sine of
    the angle between spin and field."""
    lam, theta = np.meshgrid([0.1, 1, 1.9, 2, 3, 30], [0.3, 1.0, 1.4, 1.57])
    lam, theta = lam.ravel(), theta.ravel()
    w = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    g = np.stack([0 * lam, 0 * lam, lam / 2], axis=1)
    found, m = own_spin(make("gcc", "spin"), w, g)
    W = w + 2 * np.cross(m, g)
    half = np.linalg.norm(W - w, axis=1) / (2 * np.sin(theta))
    a, r2 = lam**2, np.sin(theta)**2
    root = np.sqrt((4 + a)**2 - 16 * r2 * a)
    assert found.all() and np.allclose(half**2, 2 * a / ((4 + a) + root), rtol=1e-12)
    assert np.all(W[:, 1] * np.sin(theta) * (W[:, 0] < 2) <= 0)  # w' = w x b turns clockwise about b


@pytest.mark.quick
@pytest.mark.parametrize("build", QUICK)
def test_own_spin_perpendicular(make, build):
    """Exactly perpendicular: the exact angle 2 asin(|g|) below |g| = 1, no solution from there."""
    size = np.array([0, 1e-300, 0.5, 1 - 2**-53, 1, 1 + 2**-52, 2, 1e10])
    w, g = np.tile([0.0, 0, 1], (8, 1)), size[:, None] * [1.0, 0, 0]
    found, m = own_spin(make(build, "spin"), w, g)
    assert list(found) == [1, 1, 1, 1, 0, 0, 0, 0]
    W = w[2] + 2 * np.cross(m[2], g[2])
    assert np.allclose(W, [0, np.sin(np.pi / 3), np.cos(np.pi / 3)], atol=1e-15)


@pytest.mark.quick
@pytest.mark.parametrize("build", QUICK)
def test_own_spin_nasty(make, build):
    """Zero field, along the field, a hair off perpendicular at and beyond the limit, huge fields."""
    w = np.array([[0.0, 0, 1]] * 6)
    g = np.array([[0.0, 0, 0], [0, 0, 3], [1, 0, 1e-300], [3, 0, 1e-200], [1, 0, 1e-17], [1e100, 0, 1e90]])
    found, m = own_spin(make(build, "spin"), w, g)
    assert found.all() and np.isfinite(m).all()
    assert np.allclose(m[:2], w[:2], atol=0)
    assert np.allclose(np.linalg.norm(m, axis=1), 1, atol=1e-15)
    bad = np.array([[np.nan, 0, 0], [0, np.inf, 0], [0, 0, np.nan]])
    assert not np.isfinite(own_spin(make(build, "spin"), w[:3], bad)[1]).all(axis=1).any()


# ---- frames of the tangent plane ----------------------------------------------------------

AXES = np.array([s * np.eye(3)[a] for a in range(3) for s in (1.0, -1.0)])
EDGES = np.array([[0, 0, -1], [-0.0, -0.0, -0.0 - 1], [1e-8, 0, -1], [1e-300, -1e-300, -1],
                  [1, 1, 0], [1, 1, -0.0], [1e-160, 0, 1e-160 * 0 + 1], [-1, 1e-17, -1e-17]])


def frames(program, m, n):
    out = feed(program, [len(m)], np.concatenate([m, n], axis=1)).reshape(-1, 3, 2, 3)
    return out[:, 0], out[:, 1], out[:, 2]


@pytest.mark.parametrize("build", EVERY_BUILD)
def test_frame_is_orthonormal_and_right_handed(make, build):
    """e1 x e2 = m/|m| for any length of m, along the axes and next to the poles."""
    rng = random(4)
    m = np.concatenate([AXES, EDGES, directions(rng, 200) * 10 ** rng.uniform(-9, 9, size=(200, 1))])
    e, _, _ = frames(make(build, "frame"), m, m)
    unit = m / np.linalg.norm(m, axis=1, keepdims=True)
    assert np.allclose(np.einsum("nri,nsi->nrs", e, e), np.eye(2), atol=1e-15)
    assert np.allclose(np.cross(e[:, 0], e[:, 1]), unit, atol=2e-15)


@pytest.mark.parametrize("build", EVERY_BUILD)
def test_leaf_frame_and_its_dual(make, build):
    """n.E = 0, F.E = 1, F.m = 0: coordinates of v = E a + s m are F v, on hyperboloids too."""
    rng = random(5)
    casimirs = [np.diag(d) for d in ([1.0, 2, 4], [1, 1, -1], [1, -1, -1], [1, 0, 0], [-2, 3, 0])]
    m = directions(rng, 300) * rng.uniform(0.1, 10, size=(300, 1))
    n = np.array([casimirs[i % 5] @ m[i] for i in range(300)])
    clear = np.abs(np.einsum("ni,ni->n", m, n)) > 0.05 * np.linalg.norm(m, axis=1) * np.linalg.norm(n, axis=1)
    m, n = m[clear], n[clear]
    _, E, F = frames(make(build, "frame"), m, n)
    assert len(m) > 200
    assert np.allclose(np.einsum("nri,ni->nr", E, n) / np.linalg.norm(n, axis=1)[:, None], 0, atol=1e-15)
    assert np.allclose(np.einsum("nri,nsi->nrs", F, E), np.eye(2), atol=1e-13)
    assert np.allclose(np.einsum("nri,ni->nr", F, m), 0, atol=1e-12)


# ---- the tests' own teeth, and the bits ---------------------------------------------------

MUTANTS = {
    "no pivoting": ("dense", "smg_dense.h", "if (p != c) smg", "if (p < c) smg"),
    "panel update misses a column": ("dense", "smg_dense.h", "l[7] * u[7 * n + j]", "l[6] * u[7 * n + j]"),
    "only the lower half looked at": ("branch", "smg_dense.h", "(A[i * n + j] + A[j * n + i]) / 2 -", "A[i * n + j] -"),
    "swaps forgotten": ("branch", "smg_dense.h", "if ((p != c) != (A[p * n + c] < 0))", "if (A[p * n + c] < 0)"),
    "the diagonal kept": ("branch", "smg_dense.h", "smg_abs(row[i] - 1)", "smg_abs(row[i])"),
    "spin turns backwards": ("spin", "smg_spin.h", "(w[1] * g[2] - w[2] * g[1])", "(w[2] * g[1] - w[1] * g[2])"),
    "spin forgets the sign of g.w": ("spin", "smg_spin.h", "d < 0 ? -t : t;", "t;"),
}


def worst_dense(program):
    rng = random(11)
    sizes = {n: rng.normal(size=(4, n, n)) for n in (4, 8, 40)}
    for n, A in sizes.items():
        A[0] = np.roll(np.eye(n), 1, axis=1)
    found = {n: solve_dense(program, A, np.ones((4, n))) for n, A in sizes.items()}
    return any(s.any() or not backward_error(sizes[n], x, np.ones((4, n))) < 1e-12
               for n, (s, x) in found.items())


def worst_branch(program):
    return any(branch_wrong(program, n) for n in (4, 8))


def worst_spin(program):
    rng = random(12)
    w, g = directions(rng, 50), 2 * directions(rng, 50)
    _, m = own_spin(program, w, g)
    return not np.all(np.linalg.norm(np.cross(m, w + np.cross(m, g)), axis=1) < 1e-12)


JUDGES = {"dense": worst_dense, "branch": worst_branch, "spin": worst_spin}


@pytest.mark.parametrize("mutant", MUTANTS)
def test_mutants_are_caught(mutant, make, tmp_path):
    """Each wrong line fails the comparison that the right one passes."""
    name, header, old, new = MUTANTS[mutant]
    copied = copied_runtime(tmp_path)
    text = (copied / header).read_text()
    assert text.count(old) == 1
    (copied / header).write_text(text.replace(old, new))
    assert not JUDGES[name](make("gcc", name))
    assert JUDGES[name](compile_filter("gcc", name, 2, tmp_path, copied))


@pytest.mark.parametrize("other", ["clang", "g++", "clang++"])
def test_same_bits_from_every_compiler(make, other):
    rng = random(13)
    A, b = rng.normal(size=(5, 20, 20)), rng.normal(size=(5, 20))
    w, g = directions(rng, 50), directions(rng, 50)
    for build in ("gcc", other):
        last = (solve_dense(make(build, "dense"), A, b)[1], own_spin(make(build, "spin"), w, g)[1],
                frames(make(build, "frame"), w, g)[2])
        first = last if build == "gcc" else first
    assert all(np.array_equal(a, b) for a, b in zip(first, last))
