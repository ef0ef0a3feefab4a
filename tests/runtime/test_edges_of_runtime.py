"""Edges of the C runtime that no step comes to by itself: fills that decay on one side, matrices at the edge of
what is coercive, curves that cannot be followed, numbers beyond the numbers."""
import itertools

import numpy as np
import pytest
from support.filters import feed, make, random  # noqa: F401

INF = np.inf


# -- rings --------------------------------------------------------------------------------------

def ring(n, k, bs, below, above):
    """A ring of diagonal blocks I, blocks `below` and `above` times I at the distances 1 .. k; and the full matrix."""
    A, full = np.zeros((n, 2 * k + 1, bs, bs)), np.zeros((n, bs, n, bs))
    for i in range(n):
        for d in range(-k, k + 1):
            A[i, d + k] = np.eye(bs) * (1 if d == 0 else below / k if d < 0 else above / k)
            full[i, :, (i + d) % n] += A[i, d + k]
    return A, full.reshape(n * bs, n * bs)


@pytest.mark.parametrize("below, above", [(1e-3, 0.9), (0.9, 1e-3), (1e-3, 1e-3)])
@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_a_fill_that_decays_on_one_side_only_is_kept(make, k, bs, below, above):
    A, full = ring(200, k, bs, below, above)
    b = random(k).normal(size=(200, bs))
    found = feed(make("gcc-sanitized", "band", bs), [200, k, 1, 1], A, b)
    assert list(found[:2]) == [0, 1]
    assert np.abs(full @ found[2:] - b.ravel()).max() < 1e-13 * np.abs(found[2:]).max()


@pytest.mark.parametrize("bs", [2, 3])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_a_long_ring_names_its_singular_row(make, k, bs):
    for row in (0, 10, 150, 199):
        A, _ = ring(200, k, bs, 0, 0)
        A[row, k, 0, 0] = 0
        assert feed(make("gcc-sanitized", "band", bs), [200, k, 1, 1], A, np.ones((200, bs)))[0] == 1 + row


# -- matrices -----------------------------------------------------------------------------------

def shown(program, shape, A):
    """(bound, coercive, pivots)"""
    return feed(program, shape, A)


SHAPES = {"ring": [1, 6, 1, 1], "open": [1, 6, 1, 0], "wide ring": [1, 6, 2, 1],
          "graph": [2, 6, 6, *range(7), *range(6), *range(6)]}


def diagonal(shape, bs, entries):
    """The blocks of a diagonal matrix of six rows of blocks."""
    blocks = np.array([np.diag(e) for e in entries.reshape(6, bs)])
    if shape[0] == 2:
        return blocks
    A = np.zeros((6, 2 * shape[2] + 1, bs, bs))
    A[:, shape[2]] = blocks
    return A


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("bs", [2, 3])
def test_an_eigenvalue_of_a_quarter_is_not_coercive(make, bs, shape):
    """The matrix less I/4 is singular then, and is found so."""
    entries = np.full(6 * bs, 2.0)
    assert list(shown(make("gcc-sanitized", "shown", bs), SHAPES[shape], diagonal(SHAPES[shape], bs, entries))) == [1, 1, 1]
    entries[2 * bs + 1] = 0.25
    assert list(shown(make("gcc-sanitized", "shown", bs), SHAPES[shape], diagonal(SHAPES[shape], bs, entries))) == [1, 0, 1]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("place", [0, 1, 5])
@pytest.mark.parametrize("bs", [2, 3])
def test_one_nan_is_enough(make, bs, place, shape):
    """Wherever it stands: what comes after it does not cover it."""
    entries = np.full(6 * bs, 2.0)
    entries[place * bs] = np.nan
    bound, coercive, pivots = shown(make("gcc-sanitized", "shown", bs), SHAPES[shape], diagonal(SHAPES[shape], bs, entries))
    assert np.isnan(bound) and coercive == 0 and pivots == 0


def test_a_cubic_whose_minimum_rounds_to_nothing(make):
    """det(s I + D) = s^3 + s^2 - 1e-30 s + 1 is positive for all s >= 0."""
    D = np.array([[1, 1, 0], [1e-30, 0, 1], [1, 0, 0]])
    assert feed(make("gcc-sanitized", "shown", 3), [0], D)[2] == 1


# -- curves -------------------------------------------------------------------------------------

OK, NO_CONVERGENCE = 0, 1


def followed(program, n=6, s=1.0, b=0.0, part=1.0, sign=1):
    """(status, reached, how far the first component went)"""
    return feed(program, [n, s, b, part, sign])


@pytest.mark.parametrize("part", [1, 0.95, 0.81, 0.5])
def test_a_slow_correction_takes_shorter_paces(make, part):
    """The end is found to the tolerance of a landing, however many corrections it took."""
    status, reached, far = followed(make("gcc-sanitized", "curve"), b=1.0, part=part)
    assert (status, reached) == (OK, 1) and far == pytest.approx(2, abs=1e-8)


def test_another_curve_is_not_followed(make):
    """The sign of det J tells the curves apart: with the wrong one no point is taken."""
    status, reached, far = followed(make("gcc-sanitized", "curve"), sign=-1)
    assert status == NO_CONVERGENCE and (reached, far) == (0, 0)


def test_where_no_sign_is_known_the_curve_is_followed_all_the_same(make):
    """By the angle between its tangents alone."""
    status, reached, far = followed(make("gcc-sanitized", "curve"), b=1.0, sign=0)
    assert (status, reached) == (OK, 1) and far == pytest.approx(2, abs=1e-8)


def test_a_large_system_runs_out_of_points(make):
    """600 000 components leave eleven points, too few for eighty natural steps; 6 have all that are needed."""
    assert followed(make("gcc", "curve"), s=80.0)[0] == OK
    status, reached, _ = followed(make("gcc", "curve"), n=600_000, s=80.0)
    assert status == NO_CONVERGENCE and 0 < reached < 1


S_CURVE = (3, -4.1, 1.6, 0)         # p = 3x - 4.1 x^2 + 1.6 x^3 turns back at p = 0.677, and forth again at p = 0.460
NO_SOLUTION, WRONG_BRANCH = 2, 3


def along(program, curve, n=6):
    """The status, and how far p came, of a curve p(x) that tests/runtime/follow.c knows."""
    return feed(program, [n, 0, 1, 1, *curve, 1e300])[:2]


def dip(depth):
    """p' = 12 ((x - 1/2)^2 - depth): two folds at 1/2 +- sqrt(depth), or none; p = 1 at about x = 1."""
    return 12 * (0.25 - depth), -6, 4, 0


@pytest.mark.parametrize("depth, status", [(1e-2, WRONG_BRANCH), (1e-4, WRONG_BRANCH), (1e-6, WRONG_BRANCH), (-1e-6, OK),
                                           (-1e-4, OK), (-1e-2, OK)])
def test_two_folds_close_to_each_other_are_seen(make, depth, status):
    """However flat the curve is there, and no fold is claimed where it just rises slowly."""
    found = along(make("gcc-sanitized", "follow"), dip(depth))
    fold = 0.5 - 6 * depth + 8 * max(depth, 0) ** 1.5
    assert found[0] == status and found[1] == pytest.approx(1 if status == OK else fold, abs=0.005)


def test_a_branch_that_gives_out_behind_its_fold_has_no_solution(make):
    """The 27 points of a large system end between the folds; a small one comes to p = 1 behind them."""
    assert along(make("gcc", "follow"), S_CURVE)[0] == WRONG_BRANCH
    status, reached = along(make("gcc", "follow"), S_CURVE, n=225_000)
    assert status == NO_SOLUTION and reached == pytest.approx(0.677, abs=0.01)


def test_what_runs_into_the_centre(make):
    """So near that it is there; or nearer than 2e-5 and straight towards it, within a hundredth: not beside, not away."""
    y, near = [1e-5, 0, 0], [1e-7, 0, 0]
    rows = [[*near, 0, 1, 0, 1], [*y, -1, 0, 0, 1], [*y, -1, 0.005, 0, 1], [*y, -1, 0.05, 0, 1], [*y, 1, 0, 0, 1], [*y, 0, 1, 0, 1],
            [*y, -1, 0, 0, 0.1]]
    assert list(feed(make("gcc-sanitized", "inward"), [len(rows)], rows)) == [1, 1, 1, 0, 0, 0, 0]


def test_a_curve_ends_in_the_centre_when_it_is_about_to_arrive(make):
    """|y| q/|t| natural steps to go, at most a hundredth of the 4 p that it has come."""
    far = [[1e-7, 0, 0, -1, 0, 0, 1, 0.5, 0.9], [2e-7, 0, 0, -2, 0, 0, 2, 0.5, 0.9]]        # 5e-8 to go: it ends
    slow = [[1e-7, 0, 0, -2.6e-6, 0, 0, 1, 1, 0.9], [1e-7, 0, 0, -2.9e-6, 0, 0, 1, 1, 0.9]]  # .0385 and .0345 of .036
    still = [[1e-7, 0, 0, 0, 0, 0, 1, 1, 0.9]]
    rows = [*far, *slow, *still]
    assert list(feed(make("gcc-sanitized", "curve_end"), [len(rows)], rows)) == [2, 2, 1, 2, 1]


# -- wide numbers -------------------------------------------------------------------------------

PAIRS = [((1, 1e-17), (1, -1e-17), 0, 0), ((1, -1e-17), (1, 1e-17), 1, 0), ((1, 1e-17), (1, 1e-17), 0, 1), ((2, 0), (1, 0), 0, 0),
         ((1, 0), (2, 0), 1, 0), ((INF, 0), (1, 0), 0, 0), ((np.nan, 0), (1, 0), 0, 0), ((1, 0), (np.nan, 0), 0, 0)]


@pytest.mark.parametrize("kind", ["wide", "two_doubles"])
def test_pairs_are_compared_by_both_parts(make, kind):
    """A high part decides unless it is the same; what is no number is neither less nor equal."""
    rows = feed(make("gcc", kind), [len(PAIRS)], [[*a, *b] for a, b, _, _ in PAIRS]).reshape(len(PAIRS), -1)
    if kind == "two_doubles" or np.finfo(np.longdouble).nmant > 60:
        assert [tuple(row[-5:-3]) for row in rows] == [(less, equal if kind == "two_doubles" else equal or np.isnan([*a, *b]).any())
                                                       for a, b, less, equal in PAIRS]


def test_pairs_beyond_the_numbers(make):
    """As the C library has it: log inf, an overflow, atan2 of the largest numbers; a series of NaN ends."""
    def at(a, b):
        return feed(make("gcc-sanitized", "two_doubles_edges"), [a, b])
    assert at(INF, 1.0)[0] == INF
    assert at(1e300, 2.0)[1] == INF and at(1e300, -2.0)[1] == 0 and at(-1e300, 3.0)[1] == -INF
    assert at(1.5e308, 1.5e308)[2] == np.pi / 4 and np.isnan(at(np.nan, 1.0)[[0, 2, 3]]).all()


# -- vectors of any length ----------------------------------------------------------------------

def vectors(program, m, scale=1.0):
    """A row (length, unit vector, how much smaller than scale, frame, status and midpoint of a spin) per vector."""
    m = np.atleast_2d(np.array(m, float))
    return feed(program, [len(m)], np.column_stack([m, np.full(len(m), scale)])).reshape(len(m), -1)


@pytest.mark.parametrize("size", [1, 1e-300, 1e-160, 1e-140, 1e140, 1e160, 1e300])
def test_a_vector_of_any_length_has_its_direction(make, size):
    """Also where the squares of its components leave the range of a double."""
    unit = np.array([[2, -3, 6], [0, 0, -7], [6, 2, 3]]) / 7
    rows = vectors(make("gcc-sanitized", "norm"), size * unit)
    assert np.allclose(rows[:, 0], size, rtol=1e-14, atol=0) and np.allclose(rows[:, 1:4], unit, atol=1e-14)
    e1, e2 = rows[:, 5:8], rows[:, 8:11]
    assert np.allclose(np.cross(e1, e2), unit, atol=1e-14)
    assert rows[:, 11].all() and np.allclose(np.linalg.norm(rows[:, 12:] / size, axis=1), 1, atol=1e-14)


def test_no_length_no_direction(make):
    """The axis of z stands in; a spin of no length has nothing to turn; what is no number stays so."""
    rows = vectors(make("gcc-sanitized", "norm"), [[0, 0, 0], [np.nan, 0, 0], [0, 1, np.nan], [INF, 0, 0], [INF, np.nan, 1]])
    assert list(rows[0, :5]) == [0, 0, 0, 1, 1] and list(rows[0, 11:]) == [1, 0, 0, 0]
    assert np.isnan(rows[[1, 2, 4], :4]).all()
    assert rows[3, 0] == INF and not np.isfinite(rows[3, 1:4]).all()


def test_how_much_smaller_a_site_is(make):
    program = make("gcc-sanitized", "norm")
    assert vectors(program, [0, -0.5, 0.25], 8.0)[0, 4] == 16 and vectors(program, [0, 1e-300, 0], 1e10)[0, 4] == 1e290


# -- small matrices ------------------------------------------------------------------------------

def permanents(A):
    """Of |A|: the sum of the terms of the determinant, all taken as positive."""
    n = A.shape[-1]
    return sum(np.prod([np.abs(A[:, i, p[i]]) for i in range(n)], axis=0) for p in itertools.permutations(range(n)))


@pytest.mark.quick
def test_the_terms_of_a_determinant_are_measured(make):
    """Entries of both signs, and matrices of which half is 0."""
    A = random(5).normal(size=(80, 3, 3))
    A[40:] *= random(6).integers(0, 2, (40, 3, 3))
    small = A.reshape(-1, 9)[:, :4].reshape(-1, 2, 2)
    wanted = np.column_stack([np.linalg.det(A), permanents(A), np.linalg.det(small), permanents(small)])
    assert np.abs(feed(make("gcc-sanitized", "small"), [len(A)], A).reshape(-1, 4) - wanted).max() < 1e-13
