"""The curve of solutions of a step, followed on curves that are known (tests/runtime/follow.c)."""
import numpy as np
import pytest
from support.filters import EVERY_BUILD, feed, make  # noqa: F401

OK, NO_CONVERGENCE, NO_SOLUTION, WRONG_BRANCH, SINGULAR = 0, 1, 2, 3, 7
FAR = 1e300
FOLD = (2, -2, 0)           # p = 2x - 2x^2 turns back at x = p = 1/2
S_CURVE = (3, -4.1, 1.6)    # turns back at p = 0.677, and forth again at p = 0.460


def follow(program, coefficients, d=0.0, limit=FAR, n=6, w0=1.0, own=0, side=1):
    """status, reached, site, partner, how far the component `own` and the one beside it went."""
    return feed(program, [n, own, side, w0, *coefficients, d, limit])


@pytest.mark.parametrize("build", EVERY_BUILD)
@pytest.mark.parametrize("coefficients, x", [((1.25, 0, 0), 0.8), ((0.02, 0, 0), 50.0), ((1, 0, 1), 0.682327803828019),
                                             ((50, 0, 0), 0.02)])
def test_a_curve_without_a_fold_ends_at_its_solution(make, build, coefficients, x):
    for own, side in ((0, 1), (0, -1), (5, 1), (5, -1)):
        found = follow(make(build, "follow"), coefficients, own=own, side=side)
        assert list(found[:4]) == [OK, 1, -1, -1]
        assert found[4:] == pytest.approx([side * x, side * x / 2], rel=1e-8)


@pytest.mark.quick
def test_sites_that_are_solved_separately_are_no_part_of_a_curve(make):
    """Whatever stands in the memory of the curve at their places."""
    program, whole = make("gcc-sanitized", "follow"), (1.25, 0, 0)
    assert np.array_equal(follow(program, whole, n=12), follow(program, whole)) and follow(program, whole, n=12)[0] == OK


@pytest.mark.quick
def test_a_curve_that_leads_too_far_is_not_vouched_for(make):
    """It goes a hundred times as far as it began, and there p = 1."""
    assert follow(make("gcc-sanitized", "follow"), (1 / 99, 0, 0))[0] == OK
    assert follow(make("gcc-sanitized", "follow"), (1 / 101, 0, 0))[0] == NO_CONVERGENCE


@pytest.mark.quick
def test_a_curve_across_a_centre_is_not_vouched_for(make):
    """The second site goes from (0, 0, 1) towards 0, and is there at p = 1, to 1e-4 or to 1e-5."""
    program = make("gcc-sanitized", "follow")
    assert follow(program, (1 / (1 - 1e-4), 0, 0), own=5, side=-1)[0] == OK
    assert follow(program, (1 / (1 - 1e-5), 0, 0), own=5, side=-1)[0] == NO_CONVERGENCE


@pytest.mark.parametrize("build", EVERY_BUILD)
def test_a_fold_is_no_solution(make, build):
    """It is known to a pace how far the branch goes; the sites that move are named, the faster one first."""
    for own, side in ((0, 1), (1, -1), (3, 1), (5, -1)):
        found = follow(make(build, "follow"), FOLD, own=own, side=side)
        assert list(found[[0, 2, 3]]) == [NO_SOLUTION, own // 3, 1 - own // 3]
        assert 0.45 < found[1] <= 0.5 + 1e-9


@pytest.mark.quick
@pytest.mark.parametrize("build", ["gcc", "gcc-sanitized"])
def test_what_lies_behind_a_fold_is_another_branch(make, build):
    """What was reached is the first fold, p = 0.677, though the curve goes on to 1."""
    found = follow(make(build, "follow"), S_CURVE)
    assert found[0] == WRONG_BRANCH and 0.6 < found[1] <= 0.6775
    assert np.polyval([*S_CURVE[::-1], 0], found[4]) == pytest.approx(1, abs=1e-6) and found[4] > 1.2


@pytest.mark.quick
def test_a_curve_that_gives_out_behind_its_fold_is_no_solution(make):
    """The fold, x = p = 1/2, is met before p = 1, whatever comes behind it."""
    found = follow(make("gcc-sanitized", "follow"), FOLD, limit=0.6)
    assert found[0] == NO_SOLUTION and 0.45 < found[1] <= 0.5 + 1e-9
    assert follow(make("gcc-sanitized", "follow"), FOLD, limit=0.4)[0] == NO_CONVERGENCE


@pytest.mark.quick
def test_a_curve_to_infinity_is_no_solution(make):
    """p = x/(1 + 2x) comes to 1/2 at infinity only."""
    found = follow(make("gcc-sanitized", "follow"), (1, 0, 0), d=2.0)
    assert found[0] == NO_SOLUTION and 0.49 < found[1] < 0.5 and found[4] > 1e5


@pytest.mark.quick
@pytest.mark.parametrize("own", [0, 5])
def test_a_curve_that_ends_in_the_centre_is_no_solution(make, own):
    """A site from (-1, 0, 0) to 0 at half of h, where no Newton matrix exists; anywhere else it is just the end."""
    program = make("gcc-sanitized", "follow")
    found = follow(program, (0.5, 0, 0), limit=1 - 1e-9, w0=-1.0, own=own)
    assert list(found[[0, 2, 3]]) == [NO_SOLUTION, own // 3, -1] and found[1] == pytest.approx(0.5, abs=1e-5)
    found = follow(program, (0.5, 0, 0), limit=1 - 1e-5, w0=-1.0, own=own)      # straight towards it
    assert list(found[[0, 2, 3]]) == [NO_SOLUTION, own // 3, -1]
    assert follow(program, (0.5, 0, 0), limit=1 - 1e-4, w0=-1.0, own=own)[0] == NO_CONVERGENCE
    found = follow(program, (0.5, 0, 0), limit=0.8, w0=-1.0, own=own)
    assert found[0] == NO_CONVERGENCE and found[1] == pytest.approx(0.4, abs=1e-5)


@pytest.mark.quick
def test_a_curve_that_cannot_begin(make):
    assert follow(make("gcc-sanitized", "follow"), (1, 0, 0), limit=-1.0)[0] == SINGULAR


@pytest.mark.quick
def test_a_large_system_takes_fewer_points(make):
    found = follow(make("gcc", "follow"), (1, 0, 0), n=12_000)
    assert list(found[:2]) == [OK, 1] and found[4] == pytest.approx(1, rel=1e-8)
