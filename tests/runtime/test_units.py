"""Small functions of the C runtime: comparisons, remainders, carries, and numbers of more digits."""
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from support.filters import EVERY_BUILD, feed, make, random  # noqa: F401

EPSILON = np.finfo(float).eps


def units(program, pairs, integers):
    """(lengths of the messages, a row per pair, a row per pair of integers)."""
    out = feed(program, [len(pairs)], pairs, integers)
    return out[:11], out[11:11 + 9 * len(pairs)].reshape(-1, 9), out[11 + 9 * len(pairs):].reshape(-1, 3)


@pytest.mark.parametrize("build", EVERY_BUILD)
def test_every_status_has_a_message(make, build):
    """Eight of their own; what is no status is unknown."""
    lengths = units(make(build, "site"), np.zeros((1, 2)), np.ones((1, 2)))[0]
    assert list(lengths[[0, 9, 10]]) == [len("unknown status")] * 3
    assert np.all(lengths[1:9] >= 2) and lengths[1] == 2


@pytest.mark.quick
def test_the_smaller_and_the_larger(make):
    """What is not a number stays, on whichever side it stands."""
    pairs = np.array([[1, 2], [2, 1], [-1, -1], [np.nan, 1], [1, np.nan], [-3, 2]], float)
    rows = units(make("gcc-sanitized", "site"), pairs, np.ones((6, 2)))[1]
    assert np.array_equal(rows[[0, 1, 2, 5], :3], [[1, 2, 2], [1, 2, 2], [-1, -1, 1], [-3, 2, 3]])
    assert np.array_equal(rows[[0, 1, 2, 5], 8], [2, 2, -1, 2])
    assert np.isnan(rows[3:5, :3]).all() and np.isnan(rows[3:5, 8]).all()


@pytest.mark.quick
def test_a_change_keeps_the_largest_and_what_is_no_number(make):
    pairs = np.array([[0.5, -3], [2, 1], [np.nan, 1], [1, np.nan], [0, 0]], float)
    rows = units(make("gcc-sanitized", "site"), pairs, np.ones((5, 2)))[1]
    assert np.array_equal(rows[:2, 3:5], [[1.5, 3], [2, 2]])
    assert np.isnan(rows[2:4, 3:5]).all() and not rows[2:4, 5].any()
    assert list(rows[4, 3:6]) == [0, 0, 1]


@pytest.mark.quick
@pytest.mark.parametrize("size, settled", [(EPSILON, 1), (2 * EPSILON, 0), (8.01 * EPSILON, 0), (1e-12, 0)])
def test_settled_is_an_ulp(make, size, settled):
    """The last change was 1, so that two ulps still fall and are no round-off yet."""
    assert units(make("gcc", "site"), np.array([[size, 0]]), np.ones((1, 2)))[1][0, 5] == settled


@pytest.mark.quick
def test_a_carry_holds_what_a_sum_loses(make):
    """Exactly, as long as what is added is the smaller."""
    rng = random(1)
    pairs = np.stack([rng.uniform(1, 4, 200), rng.normal(size=200) * 10 ** rng.uniform(-20, -2, 200)], axis=1)
    rows = units(make("gcc", "site"), pairs, np.ones((200, 2)))[1]
    for (a, b), w, carry in zip(pairs, rows[:, 6], rows[:, 7]):
        assert Fraction(a) + Fraction(b) == Fraction(w) + Fraction(carry)


@pytest.mark.parametrize("build", EVERY_BUILD)
def test_remainders_round_down(make, build):
    """Python's own, for both signs of both numbers."""
    integers = [(x, n) for x in range(-9, 10) for n in (-4, -3, -1, 1, 3, 4)]
    rows = units(make(build, "site"), np.zeros((len(integers), 2)), np.array(integers, float))[2]
    assert np.array_equal(rows[:, 1], [x % n for x, n in integers])
    assert np.array_equal(rows[:, 2], [x // n for x, n in integers])


@pytest.mark.quick
def test_a_wrapped_cell_lies_in_the_lattice(make):
    integers = [(x, n) for n in (1, 2, 5, 8) for x in range(-n, 2 * n)]
    rows = units(make("gcc-sanitized", "site"), np.zeros((len(integers), 2)), np.array(integers, float))[2]
    assert np.array_equal(rows[:, 0], [x % n for x, n in integers])


# -- numbers of more digits ---------------------------------------------------------------------

def exact(pair):
    return Fraction(pair[0]) + Fraction(pair[1])


def root(x: Fraction) -> Fraction:
    """The square root to 40 digits."""
    return Fraction(math.isqrt(x.numerator * 10**80 // x.denominator), 10**40)


def expected(a, b):
    """The results of tests/runtime/wide.c, exactly."""
    u, q = (a, b, b), (b, a, b)
    cross = [u[1] * q[2] - u[2] * q[1], u[2] * q[0] - u[0] * q[2], u[0] * q[1] - u[1] * q[0]]
    return [a + b, a - b, a * b, a / b, a * b, root(a), 1 / root(a), abs(b), min(a, b), max(a, b),
            (b > 0) - (b < 0), a**3, 3 * a * b, *cross]


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("kind, bits", [("wide", 63), ("two_doubles", 102)])
def test_wide_arithmetic(make, build, kind, bits):
    """Every result within a few units of its last place, relative to the sizes that it is made of.

    A build whose reals are long has no wider ones, and hands them over as doubles.
    """
    long = build == "gcc-long-double"
    rng, bits = random(7), 52 if long else bits
    hi = np.stack([rng.uniform(0.1, 3, 100), rng.normal(size=100)], axis=1)
    lo = hi * EPSILON / 2 * rng.uniform(-0.9, 0.9, hi.shape) * (kind == "two_doubles" and not long)
    rows = feed(make(build, kind), [100], np.stack([hi[:, 0], lo[:, 0], hi[:, 1], lo[:, 1]], axis=1)).reshape(100, -1)
    for k, row in enumerate(rows):
        a, b = (exact((hi[k, c], lo[k, c])) for c in (0, 1))
        check_row(row, a, b, float(hi[k, 0]), 2.0 ** -bits)


def check_row(row, a, b, high, unit):
    found = [exact(p) for p in row[:40].reshape(-1, 2)]
    right = expected(a, b)
    right[4] = Fraction(high) * b
    size = max(1, 1 / abs(b)) * max(1, abs(b))**2 * max(1, a)**3 * max(1, 1 / a)
    for mine, other in zip(found, right):
        assert abs(mine - other) <= 16 * unit * size
    w, total = found[16], found[17]
    assert abs(w - (a + b)) <= 16 * unit * size and abs(total - (a + b)) <= 16 * unit * size + abs(b - Fraction(row[0]))
    assert list(row[-5:-2]) == [a < b, a == b, 1] and not row[-2:].any()


# -- their elementary functions -----------------------------------------------------------------

NAMES = "exp log sin cos tan asin acos atan sinh cosh tanh floor".split()
PART = ("log", "asin", "acos")      # these take b itself, in (0, 1)


def mp_values(a, b):
    """The results of tests/runtime/wide_math.c to 50 digits."""
    wide = 9 * b - 4
    return [*(getattr(mpmath, n)(a) for n in NAMES), *(getattr(mpmath, n)(b if n in PART else wide) for n in NAMES),
            mpmath.atan2(a, b - mpmath.mpf(1) / 2), a**wide]


@pytest.mark.parametrize("build", [b for b in EVERY_BUILD if b.values[0] != "gcc-long-double"])
@pytest.mark.parametrize("kind, error", [("wide_math", 1e-18), ("two_doubles_math", 1e-29)])
def test_elementary_functions(make, build, kind, error):
    """To the error that the header promises, relative to the larger of 1 and the result."""
    rng, low = random(9), kind == "two_doubles_math"
    hi = rng.uniform(0.01, 0.99, (60, 2))
    hi[0] = 0.3, 0.999
    lo = hi * EPSILON / 2 * rng.uniform(-0.9, 0.9, hi.shape) * low
    out = feed(make(build, kind), [60], np.stack([hi[:, 0], lo[:, 0], hi[:, 1], lo[:, 1]], axis=1))
    with mpmath.workdps(50):
        for k, row in enumerate(out[:60 * 52].reshape(60, -1, 2)):
            a, b = (mpmath.mpf(hi[k, c]) + mpmath.mpf(lo[k, c]) for c in (0, 1))
            for mine, other in zip(row, mp_values(a, b)):
                found = mpmath.mpf(mine[0]) + mpmath.mpf(mine[1])
                assert abs(found - other) <= error * max(1, abs(other)) * (1 if abs(other) < 10 else 4)


@pytest.mark.quick
@pytest.mark.parametrize("kind", ["wide_math", "two_doubles_math"])
def test_edges_of_elementary_functions(make, kind):
    """Of two doubles exp ends where a double does; log 0, far tanh, a floor by a hair, odd powers, 0."""
    edges = feed(make("gcc", kind), [1], [0.5, 0, 0.5, 0])[52:].reshape(-1, 2)[:, 0]
    assert edges[0] == np.inf and edges[1] == 0 and edges[2] == -np.inf
    assert list(edges[3:5]) == [1, -1] and list(edges[6:]) == [-8, 0, 0]
    assert edges[5] == (2 if kind == "two_doubles_math" else 2 + (np.finfo(np.longdouble).nmant < 60))
