"""Gauss collocation (runtime/method/gauss/smg_gauss.h) around models written by hand: order, symplecticity, round-off, refusals.

The filter tests/runtime/gauss.c also compares, in every run, a restored state's bits with those of the state it was saved from.
"""
import re
import sys
from pathlib import Path

import pytest
from mpmath import cos, fsum, log, mp, mpf, sin
from smidgen.resources import folder
from support.gauss import BODY, COMMANDS, FREE, KAPPA, STARTS, TIMED, UNREAL, VORTICES, compile_gauss, run
from support.triples import apart, cross, dot, norm, on_sphere

sys.path.insert(0, str(Path(__file__).parents[1] / "coefficients"))
import gauss as coefficients  # noqa: E402

EPSILON = 2.0**-52
OK, NO_CONVERGENCE, NOT_FINITE = 0, 1, 4
STAGES = [pytest.param(s, marks=() if s in (1, 2, 3, 8) else pytest.mark.long) for s in range(1, 9)]
NAMES = {FREE: "free body", BODY: "irreversible body", VORTICES: "vortices", TIMED: "in time"}


@pytest.fixture(autouse=True)
def digits():
    """Other tests set the digits of mpmath too."""
    with mp.workdps(70):
        yield


def fields(*which):
    return pytest.mark.parametrize("field", which, ids=NAMES.get)


@pytest.fixture(scope="session")
def make(tmp_path_factory):
    """make(stages, field, build): the compiled filter."""
    to = tmp_path_factory.mktemp("gauss")
    return lambda stages, field, build="double": compile_gauss(to, stages, field, build)


# ---- coefficients -----------------------------------------------------------------------------

def test_the_table_is_what_the_script_writes():
    assert (folder("runtime") / "method" / "tables" / "smg_gauss_table.h").read_text() == coefficients.header()


@pytest.mark.parametrize("s", range(1, 9))
def test_coefficients_satisfy_their_conditions(s):
    """B(2s), C(s), and b_i a_ij + b_j a_ji = b_i b_j, to sixty digits."""
    c, b, a, _ = coefficients.gauss(s)
    close = mpf(10)**-60
    for k in range(1, 2 * s + 1):
        assert abs(fsum(x * y**(k - 1) for x, y in zip(b, c)) - mpf(1) / k) < close
    for i in range(s):
        for k in range(1, s + 1):
            assert abs(fsum(x * y**(k - 1) for x, y in zip(a[i], c)) - c[i]**k / k) < close
        for j in range(s):
            assert abs(b[i] * a[i][j] + b[j] * a[j][i] - b[i] * b[j]) < close


@pytest.mark.parametrize("s", range(1, 9))
def test_the_table_is_right_to_its_second_double(s):
    text = coefficients.table(s)
    c, b, a, _ = coefficients.gauss(s)
    shares = [a[i][j] / b[j] if i > j else 1 - a[i][j] / b[j] for j in range(s) for i in range(s) if i != j]
    pairs = [mpf(float(high)) + mpf(float(low)) for high, low in re.findall(r"(?:PAIR|MIRROR)\((\S+), ([^\s)]+)\)", text)]
    half = [(a[i][j] / b[j] + a[i][s - 1 - j] / b[s - 1 - j] - 1) / 2 for i in range(s // 2) for j in range((s + 1) // 2)]
    assert len(pairs) == 2 * s + s * (s - 1) + len(half)
    assert max(abs(x - y) for x, y in zip(pairs, c + b + shares + half)) < mpf(10)**-32


@pytest.mark.parametrize("s", range(1, 9))
def test_halves_of_the_stages_tell_all_shares(s):
    """a_ij/b_j - 1/2 = alpha_ij - alpha_ji and its mirror images, by the numbers of the table for pairs of stages."""
    _, b, a, _ = coefficients.gauss(s)
    alpha, last = coefficients.crossed(a, b), s - 1
    for i in range(s // 2):
        for j in range(s // 2):
            near, far = alpha[i][j] - alpha[j][i], alpha[i][j] + alpha[j][i]
            for (k, q), found in (((i, j), near), ((i, last - j), far), ((last - i, last - j), -near), ((last - i, j), -far)):
                assert abs(a[k][q] / b[q] - mpf(1) / 2 - found) < mpf(10)**-50
        if s % 2:
            m = s // 2
            assert abs(a[i][m] / b[m] - mpf(1) / 2 - alpha[i][m]) < mpf(10)**-50
            assert abs(a[m][i] / b[i] - mpf(1) / 2 + alpha[i][m]) < mpf(10)**-50


# ---- order ------------------------------------------------------------------------------------

# Half the steps of each ladder: errors from where the order shows down to 1e-30.
LADDERS = {(BODY, 7): 16, (BODY, 8): 8, (VORTICES, 6): 16, (VORTICES, 7): 4, (VORTICES, 8): 4}
END = 2


@pytest.fixture(scope="session")
def solution(make):
    """solution(field): the state at END, to 1e-30 and better."""
    known = {}

    def of(field):
        if field not in known:
            known[field] = run(make(8, field, "quad"), STARTS[field], END / 128, 128).state
        return known[field]
    return of


@fields(BODY, VORTICES, TIMED)
@pytest.mark.parametrize("s", STAGES)
def test_order_is_twice_the_stages(make, solution, s, field):
    steps = LADDERS.get((field, s), 32)
    errors = []
    for n in (steps, 2 * steps):
        found = run(make(s, field, "quad"), STARTS[field], END / n, n)
        assert found.status == OK
        errors.append(apart(found.state, solution(field)))
    assert errors[1] > mpf(10)**-30
    assert abs(log(errors[0] / errors[1], 2) - 2 * s) < 0.06


# ---- one stage ----------------------------------------------------------------------------------

def body_field(w):
    """b = dH/dw of the irreversible body."""
    return [(x + x * x) / moment for x, moment in zip(w, (1, 2, 4))]


def spherical_midpoint(w, h):
    """W = w + h m x b(m), m = (w + W)/|w + W|."""
    end = w
    for _ in range(150):
        m = [x + y for x, y in zip(w, end)]
        m = [x / norm(m) for x in m]
        end = [x + h * y for x, y in zip(w, cross(m, body_field(m)))]
    return end


def test_one_stage_is_the_spherical_midpoint(make):
    w = STARTS[BODY][0]
    for h in (0.5, 0.25):
        found = run(make(1, BODY, "quad"), [w], h)
        assert found.status == OK and apart(found.state, [spherical_midpoint(w, mpf(h))]) < mpf(10)**-32


# ---- what is kept -------------------------------------------------------------------------------

def momentum(w):
    return [fsum(k * v[b] for k, v in zip(KAPPA, w)) for b in range(3)]


def lengths(field, state):
    return max(abs(norm(v) / norm(w) - 1) for v, w in zip(state, STARTS[field]))


@fields(FREE, BODY)
@pytest.mark.parametrize("s", STAGES)
@pytest.mark.parametrize("h", [0.05, 0.8])
def test_lengths_are_kept_to_round_off(make, s, field, h):
    found = run(make(s, field), STARTS[field], h, 10000)
    assert found.status == OK and lengths(field, found.state) < 100 * EPSILON


@pytest.mark.parametrize("s", STAGES)
def test_momentum_of_vortices_is_kept_to_round_off(make, s):
    found = run(make(s, VORTICES), STARTS[VORTICES], 0.02, 10000)
    assert found.status == OK and lengths(VORTICES, found.state) < 20 * EPSILON
    assert norm([a - b for a, b in zip(momentum(found.state), momentum(STARTS[VORTICES]))]) < 40 * EPSILON


@pytest.mark.parametrize("s", STAGES)
def test_a_body_at_rest_in_space_stays(make, s):
    """w = 0 in R^3, where z has no phase; spin and body beside it keep their lengths."""
    start = [*STARTS[TIMED][:2], [0, 0, 0]]
    found = run(make(s, TIMED), start, 0.0625, 20)
    assert found.status == OK and found.state[2] == [0, 0, 0]
    assert apart(found.state, start) > 0.1
    assert all(abs(norm(a) / norm(b) - 1) < 10 * EPSILON for a, b in zip(found.state[:2], start[:2]))


@fields(FREE, BODY, VORTICES)
@pytest.mark.parametrize("s", STAGES)
def test_a_step_back_undoes_a_step(make, s, field):
    for h, steps in ((0.3, 1), (0.05, 50)):
        found = run(make(s, field), STARTS[field], h, steps, back=True)
        assert found.status == OK and found.count == 2 * steps
        assert apart(found.state, STARTS[field]) < (10 + 2 * steps) * EPSILON


def tangents(w):
    """Two tangent vectors of every site."""
    for k, v in enumerate(w):
        first = cross(v, on_sphere((0.3, -0.5, 0.8)))
        for t in (first, cross(v, first)):
            yield k, [x / norm(t) for x in t]


def moved(w, k, t, angle):
    """w with site k turned towards the unit tangent t."""
    r = norm(w[k])
    turned = [cos(angle) * x + sin(angle) * r * y for x, y in zip(w[k], t)]
    return [*w[:k], turned, *w[k + 1:]]


def area(strengths, w, a, b):
    """sum of kappa_k w_k.(a_k x b_k)/|w_k|^2"""
    return fsum(s * dot(v, cross(x, y)) / dot(v, v) for s, v, x, y in zip(strengths, w, a, b))


@fields(BODY, VORTICES)
@pytest.mark.parametrize("s", STAGES)
def test_the_step_keeps_the_area(make, s, field):
    """Pairs of columns of its Jacobian, by central differences in quad, have the area of the tangents they come from."""
    program, w, h, angle = make(s, field, "quad"), STARTS[field], 0.4, mpf(10)**-9
    before, after = [], []
    for k, t in tangents(w):
        ends = [run(program, moved(w, k, t, sign * angle), h).state for sign in (1, -1)]
        before.append([[norm(w[k]) * x if site == k else mpf(0) for x in t] for site in range(len(w))])
        after.append([[(x - y) / (2 * angle) for x, y in zip(*both)] for both in zip(*ends)])
    end = run(program, w, h).state
    for i in range(len(before)):
        for j in range(i):
            apart_by = area(KAPPA, end, after[i], after[j]) - area(KAPPA, w, before[i], before[j])
            assert abs(apart_by) < 1e-15
    assert apart(end, w) > 0.01


# ---- round-off ----------------------------------------------------------------------------------

POLES = {"south pole": (0, 0, -1), "near it": (1e-9, -1e-12, -1), "north pole": (1e-200, 0, 1), "equator": (0.6, 0.8, 0),
         "below the equator": (0.6, 0.8, -1e-17), "south": (0.28, 0, -0.96)}


@pytest.mark.parametrize("place", POLES)
@pytest.mark.parametrize("s", [1, 3, 8])
@pytest.mark.parametrize("h", [1e-6, 0.1])
def test_the_increment_is_right_to_its_own_round_off(make, s, place, h):
    """At vortices that stand anywhere, next to the quadruple step from the same numbers."""
    start = [[mpf(2 * float(x)) for x in POLES[place]], *([mpf(float(x)) for x in v] for v in STARTS[VORTICES][1:3]),
             [mpf(float(x)) for x in on_sphere((0.5, -0.5, 0.9), 2)]]
    steps = [run(make(s, VORTICES, build), start, h) for build in ("double", "quad")]
    assert [step.status for step in steps] == [OK, OK]
    (u, exact) = [[[x - y for x, y in zip(*both)] for both in zip(step.state, start)] for step in steps]
    for found, wanted in zip(u, exact):
        assert norm([x - y for x, y in zip(found, wanted)]) < 24 * EPSILON * norm(wanted)


@fields(BODY, VORTICES, TIMED)
def test_the_iteration_ends_at_the_accuracy_asked_for(make, field):
    """What a sweep has left over is below the tolerance, a part of the largest component, in every of ten steps."""
    h = 0.8 if field == BODY else 0.25
    exact = run(make(6, field), STARTS[field], h, 10)
    iterations = [exact.iterations]
    for build, tolerance in (("to 1e-11", 1e-11), ("to 1e-6", 1e-6)):
        found = run(make(6, field, build), STARTS[field], h, 10)
        largest = max(abs(x) for v in STARTS[field] for x in v)
        assert found.status == OK and 0 < apart(found.state, exact.state) < 10 * tolerance * largest
        iterations.append(found.iterations)
    assert iterations[0] > iterations[1] > iterations[2]


# ---- refusals -----------------------------------------------------------------------------------

@fields(FREE, BODY, VORTICES, TIMED)
@pytest.mark.parametrize("s", STAGES)
@pytest.mark.parametrize("h", [40.0, -1e5])
def test_a_hopeless_step_is_refused_and_leaves_no_trace(make, s, field, h):
    found = run(make(s, field), STARTS[field], h)
    assert found.status in (NO_CONVERGENCE, NOT_FINITE) and found.count == 0
    assert 0 <= found.site < len(STARTS[field])
    assert apart(found.state, [[mpf(float(x)) for x in v] for v in STARTS[field]]) == 0


def test_what_is_not_finite_is_told(make):
    found = run(make(2, UNREAL), STARTS[UNREAL], 0.1)
    assert (found.status, found.site, found.count) == (NOT_FINITE, 0, 0)
    far = run(make(2, BODY), STARTS[BODY], 1e300)     # where the field along rays still is a number
    assert far.status == NO_CONVERGENCE and far.count == 0 and apart(far.state, run(make(2, BODY), STARTS[BODY], 1e300, 0).state) == 0


def moves_on(program, start, first, last):
    """Is W, fast where two solutions are about to meet, looked at ten times as closely, without a jump of a twentieth?"""
    known = [(h, run(program, start, h)) for h in (first + (last - first) * k / 10 for k in range(11))]
    known = [(h, found.state) for h, found in known if found.status == OK]
    return all(apart(v, w) < 6 * (h - g) for (g, w), (h, v) in zip(known, known[1:])) and len(known) > 1


@fields(BODY, VORTICES)
@pytest.mark.parametrize("s", STAGES)
def test_accepted_steps_are_of_one_branch(make, s, field):
    """As h grows W moves on without a jump, over gaps where no step is found, and in the end none is."""
    program, last, last_h, refused = make(s, field), STARTS[field], 0, 0
    for k in range(1, 200):
        found = run(program, STARTS[field], h := k / 10)
        refused += found.status != OK
        if found.status == OK:
            assert apart(found.state, last) < 2 * (h - last_h) or moves_on(program, STARTS[field], last_h, h)
            last, last_h = found.state, h
    assert refused and last_h > 0.9


# ---- compilers ----------------------------------------------------------------------------------

@pytest.mark.parametrize("build", [pytest.param(b, marks=pytest.mark.long if b in ("g++", "g++ quad", "clang") else ())
                                   for b in COMMANDS if b not in ("double", "quad") and "to " not in b])
@fields(TIMED)
@pytest.mark.parametrize("s", [pytest.param(1, marks=pytest.mark.long), 3, pytest.param(8, marks=pytest.mark.long)])
def test_every_compiler_takes_it_without_a_warning(make, s, field, build):
    found, wanted = (run(make(s, field, b), STARTS[field], 0.0625, 10) for b in (build, "quad"))
    assert found.status == OK and apart(found.state, wanted.state) < 1e-14
