"""Systems by products alone (runtime/newton/smg_krylov.h), beside numpy: solved, or said not to be; coercive or not; the sign of det A."""
import numpy as np
import pytest
from support.filters import feed, make, random  # noqa: F401


def solved(make, A, b=None, tolerance=1e-5, build="gcc-sanitized"):
    """(status, x, coercive, sign, (vectors of the basis for 10 n and 100 n unknowns, room))"""
    n = len(A)
    status, *x, coercive, sign, short, long, room = feed(make(build, "krylov"), [n, tolerance], A, np.ones(n) if b is None else b)
    return status, np.array(x), coercive, sign, (short, long, room)


def near_one(n, spread, seed=1):
    """1 + a matrix of this norm, symmetric."""
    A = random(seed).normal(size=(n, n))
    A = A + A.T
    return np.eye(n) + spread * A / np.linalg.norm(A, 2)


@pytest.mark.parametrize("n", [1, 2, 59, 60, 61, 130])
@pytest.mark.parametrize("tolerance", [1e-5, np.finfo(float).eps])
def test_a_solution_has_the_digits_asked_for(make, n, tolerance):
    A, b = near_one(n, 0.5), random(2).normal(size=n)
    status, x, coercive, sign, _ = solved(make, A, b, tolerance)
    assert (status, coercive, sign) == (0, 1, 1)
    left = np.linalg.norm(b - A @ x) / np.linalg.norm(b)
    assert left <= max(tolerance, 1e-14) and (n <= 2 or tolerance < 1e-10 or left > 1e-9)


@pytest.mark.parametrize("n", [3, 80])
def test_the_least_eigenvalue_and_the_sign_of_the_determinant(make, n):
    """A quarter is the bound; one negative eigenvalue makes det A < 0, two do not."""
    q = np.linalg.qr(random(3).normal(size=(n, n)))[0]
    for low, coercive, sign in ([0.6], 1, 1), ([0.2], 0, 1), ([-0.5], 0, -1), ([-0.5, -0.7], 0, 1):
        values = np.r_[low, np.linspace(1, 2, n - len(low))]
        assert solved(make, q * values @ q.T)[2:4] == (coercive, sign)


def test_of_many_unknowns_the_sign_is_not_known(make):
    """Elimination is asked of 600 at most; where A is coercive its determinant is positive, however many there are."""
    values = np.linspace(0.5, 2, 601)
    assert solved(make, np.diag(values), build="gcc")[3] == 1
    values[7] = -1
    assert solved(make, np.diag(values), build="gcc")[3] == 0
    assert solved(make, np.diag(values[1:]), build="gcc")[3] == -1


def test_what_is_singular_is_not_solved(make):
    """A = 0, b outside the image of A, and a rotation of the unknowns that a short basis never sees."""
    assert solved(make, np.zeros((4, 4)))[0] == 1
    assert solved(make, np.diag([1.0, 1, 0]))[0] == 1
    assert solved(make, np.roll(np.eye(200), 1, axis=0), np.eye(200)[0])[0] == 1
    assert solved(make, np.roll(np.eye(50), 1, axis=0), np.eye(50)[0])[0] == 0


def test_a_system_that_is_too_slow_is_given_up(make):
    """Eigenvalues from 1 to 4000: sixty vectors gain a digit or so, 400 products not sixteen."""
    A = np.diag(np.geomspace(1, 4000, 300))
    assert solved(make, A, tolerance=1e-2)[0] == 0
    assert solved(make, A, tolerance=np.finfo(float).eps)[0] == 1


def test_nothing_and_no_number(make):
    A = near_one(5, 0.3)
    status, x, *_ = solved(make, A, np.zeros(5))
    assert status == 0 and not x.any()
    assert solved(make, A, [1, np.nan, 0, 0, 0])[0] == 1


def test_an_invariant_subspace_ends_lanczos(make):
    """The identity: after one step nothing is left."""
    assert solved(make, np.eye(30))[2] == 1 and solved(make, np.eye(30) / 5)[2] == 0


@pytest.mark.parametrize("n, bases, room", [(1, (10, 60), 4), (60, (60, 60), 63 * 60), (62, (60, 60), 63 * 62), (63, (60, 60), 64 * 63), (250, (60, 10), 251 * 250),
                                            (700, (60, 10), 63 * 700)])
def test_large_systems_have_a_short_basis_and_small_ones_room_for_their_matrix(make, n, bases, room):
    """And one number, how many products are left."""
    assert solved(make, np.eye(n), build="gcc")[4] == (*bases, room + 1)
