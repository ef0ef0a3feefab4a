"""runtime/method/explicit/smg_dop853.h by itself: its coefficients, and what it does to the hand-written models of tests/runtime/dop853.c.

No compiler of specs is asked. Judged by the order conditions of Butcher's trees, by solutions in closed form, and by the same
text in long double and quadruple.
"""
import re
import shutil
import subprocess
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from smidgen.resources import include_flags

ROOT = Path(__file__).parents[2]
TABLES = [ROOT / "runtime" / "method" / "tables" / f"smg_dop853_{name}.h" for name in ("table", "estimates")]
SOURCE = ROOT / "tests" / "runtime" / "dop853.c"
PATHS = include_flags()
WARNINGS = "-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wvla -Werror".split()
COMPILERS = {"gcc": ["gcc", "-std=c11"], "clang": ["clang", "-std=c11"], "g++": ["g++", "-x", "c++", "-std=c++17"],
             "clang++": ["clang++", "-x", "c++", "-std=c++17"]}
LONG, QUAD, FIXED, PROJECT = "-DSMG_LONG_DOUBLE", "-DSMG_QUAD", "-DSMG_FIXED_STEP=1", "-DSMG_PROJECT=1"
BODY, BODY_R3, VORTICES, FIELD, NAMBU, EDGE, FREE_BODY = 0, 1, 2, 3, 4, 5, -1
START = "0.453596121425577387771370051784716122 0 0.891207360061435339951802577871703538"    # cos 1.1, 0, sin 1.1
FREE_AT_10 = ("-0.4503635330766926960600452", "-0.09362899305780025785077625", "0.8879224626810953221192839")
FOUR = "1 0.1 0.2  -0.3 1 0.1  0.2 -0.9 0.6  -0.4 -0.3 -1"
STARTS = {BODY: START, BODY_R3: "0.9 -1.1 0.4", VORTICES: FOUR, FIELD: START, NAMBU: "0.8 0.3 -0.5"}
OK, NO_CONVERGENCE, NOT_FINITE = 0, 1, 4
mp.mp.dps = 50


@pytest.fixture(autouse=True)
def digits():
    """Other tests set the digits of mpmath too."""
    with mp.mp.workdps(50):
        yield


@pytest.fixture(scope="session")
def build(tmp_path_factory):
    """build(*flags): the driver compiled with them, once; the warnings that need an optimiser are asked for below."""
    place, built = tmp_path_factory.mktemp("dop853"), {}

    def call(*flags):
        if flags not in built:
            built[flags] = place / f"driver{len(built)}"
            subprocess.run([*COMPILERS["gcc"], "-O0", *WARNINGS, *flags, *PATHS, str(SOURCE), "-o", str(built[flags]),
                            *(["-lquadmath"] if QUAD in flags else []), "-lm"], check=True)
        return built[flags]
    return call


def ask(program, what, h, *action, starts=None, t0=0, tolerance=0):
    """What the driver answers to one start, or to a list of them, as texts."""
    given = [starts or STARTS.get(what, START)] if not isinstance(starts, list) else starts
    sites = len(given[0].split()) // 3
    done = subprocess.run([program, *map(str, (what, sites, h, t0, tolerance, *action))], input="\n".join(given),
                          capture_output=True, text=True, check=True)
    rows = [line.split() for line in done.stdout.splitlines()]
    assert len(rows) == len(given)
    return rows if isinstance(starts, list) else rows[0]


class Run:
    """N steps: their status, internal steps, largest estimate, w, and how far C of site 0 has moved."""

    def __init__(self, words):
        self.status, self.internal = int(words[0]), int(words[1])
        self.residual, *w, self.off = map(np.longdouble, words[2:])
        self.w = np.array(w).reshape(-1, 3)


def run(program, what, h, steps, **more):
    found = ask(program, what, h, "run", steps, **more)
    return [Run(f) for f in found] if isinstance(found[0], list) else Run(found)


# -- coefficients -------------------------------------------------------------------------------

def table(name):
    """A table of the header, both parts of its numbers added, as rows."""
    text = re.search(rf"smg_dop853_{name}\[.*?= \{{(.*?)\}};", "".join(table.read_text() for table in TABLES), re.S).group(1)
    number = r"SMG_PAIR\(([^,]+), ([^)]+)\)|(-?[\d.]+)"
    rows = re.findall(r"\{(.*?)\}", text, re.S) or [text]
    found = [[mp.mpf(float(high or alone)) + mp.mpf(float(low or 0)) for high, low, alone in re.findall(number, row)] for row in rows]
    return found if "{" in text else found[0]


@lru_cache(None)
def trees(n):
    """Rooted trees of n nodes, each the sorted tuple of its branches."""
    return [()] if n == 1 else forests(n - 1)


@lru_cache(None)
def forests(n):
    if n == 0:
        return [()]
    return sorted({tuple(sorted((tree, *rest))) for k in range(1, n + 1) for tree in trees(k) for rest in forests(n - k)})


def nodes(tree):
    return 1 + sum(map(nodes, tree))


def density(tree):
    product = nodes(tree)
    for branch in tree:
        product *= density(branch)
    return product


class Tableau:
    """All stages, and the weights of the tree conditions."""

    def __init__(self):
        self.c, self.b, self.e5, self.e3 = table("c"), table("b"), table("e5"), table("e3")
        self.a = [row + [mp.mpf(0)] * (12 - len(row)) for row in table("a")]
        self.known = {}

    def weights(self, tree):
        """The elementary weight of every stage."""
        if tree not in self.known:
            found = [mp.mpf(1)] * 12
            for branch in tree:
                inner = self.weights(branch)
                found = [f * mp.fsum(x * y for x, y in zip(row, inner) if x) for f, row in zip(found, self.a)]
            self.known[tree] = found
        return self.known[tree]

    def off(self, b, order):
        """How far the conditions of this order are from met by the weights b."""
        return max(abs(mp.fsum(x * y for x, y in zip(b, self.weights(t))) - mp.mpf(1) / density(t)) for t in trees(order))


@pytest.fixture(scope="module")
def tableau():
    return Tableau()


def test_the_trees_are_all_there():
    assert [len(trees(n)) for n in range(1, 10)] == [1, 1, 2, 4, 9, 20, 48, 115, 286]


def test_rows_add_up_to_the_nodes(tableau):
    assert max(abs(mp.fsum(row) - c) for row, c in zip(tableau.a, tableau.c)) < 1e-28
    root = mp.sqrt(6)
    exact = [0, (6 - root) * 2 / 135, (6 - root) / 45, (6 - root) / 30, (6 + root) / 30,
             *(mp.mpf(p) / q for p, q in ((1, 3), (1, 4), (4, 13), (127, 195), (3, 5), (6, 7), (1, 1)))]
    assert max(abs(x - y) for x, y in zip(exact, tableau.c)) < 1e-29


def test_conditions_of_order_eight(tableau):
    assert max(tableau.off(tableau.b, order) for order in range(1, 9)) < 5e-29
    assert tableau.off(tableau.b, 9) > 1e-6


@pytest.mark.parametrize("name, order", [("e5", 5), ("e3", 3)])
def test_estimates_are_of_their_orders(tableau, name, order):
    lower = [b - e for b, e in zip(tableau.b, getattr(tableau, name))]
    assert max(tableau.off(lower, p) for p in range(1, order + 1)) < 1e-27
    assert tableau.off(lower, order + 1) > 1e-4


# -- accuracy -----------------------------------------------------------------------------------

@pytest.mark.parametrize("what, h, more", [(BODY, "0.5", ()), (BODY, "0.5", (PROJECT,)), (VORTICES, "0.1", ()),
                                           (VORTICES, "0.1", (PROJECT,)), (FIELD, "0.25", ()), (NAMBU, "0.1", (PROJECT,))])
def test_order_eight_with_one_internal_step(build, what, h, more):
    program, n = build(LONG, FIXED, *more), 8
    found = [run(program, what, float(h) / 2**k, n * 2**k).w for k in range(3)]
    exact = run(build(QUAD), what, float(h) * n, 1, tolerance="1e-21").w
    errors = [np.abs(w - exact).max() for w in found]
    orders = [np.log2(x / y) for x, y in pairwise(errors)]
    print(what, more, errors, orders)
    assert errors[2] > 1e-17 and 7.5 < orders[1] < 8.7


def test_free_body_to_every_digit_of_the_reference(build):
    words = ask(build(QUAD), FREE_BODY, 10, "run", 1)
    assert max(abs(mp.mpf(x) - mp.mpf(y)) for x, y in zip(words[3:6], FREE_AT_10)) < 1e-24


def test_error_follows_the_tolerance(build):
    """On the free body, in one output step and in ten of them."""
    exact, errors, steps = np.array([np.longdouble(x) for x in FREE_AT_10]), [], []
    for digits in range(6, 13):
        one, ten = (run(build(LONG), FREE_BODY, h, 10 // h, tolerance=f"1e-{digits}") for h in (10, 1))
        error, tolerance = np.abs(one.w - exact).max(), 10.0**-digits
        errors.append(error / tolerance)
        steps.append(one.internal)
        assert np.abs(ten.w - exact).max() < 10 * tolerance and one.residual <= tolerance * 0.9
        assert one.residual > 0.01 * tolerance
    print(errors, steps)
    assert max(errors) < 10 and min(errors) > 1e-3
    assert all(x < y for x, y in pairwise(steps)) and steps[-1] < 6 * steps[0]


@pytest.mark.parametrize("real", [(), (LONG,)])
def test_time_dependent_field_in_closed_form(build, real):
    """B = (a cos 2t, a sin 2t, b): in the frame that turns along, w turns about (a, 0, b + 2)."""
    def turned(v, axis, angle):
        axis = axis / np.linalg.norm(axis)
        return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1 - np.cos(angle))
    z, t0, t1, w = np.array([0, 0, 1.0]), 0.7, 13.2, np.array([np.cos(1.1), 0, np.sin(1.1)])
    still = np.array([0.7, 0, 2.5])
    exact = turned(turned(turned(w, z, -2 * t0), still, -(t1 - t0) * np.linalg.norm(still)), z, 2 * t1)
    for h, steps in ((12.5, 1), (0.125, 100)):
        found = run(build(*real), FIELD, h, steps, t0=t0)
        assert np.abs(found.w[0] - exact).max() < 1e-11 and found.status == OK


def test_back_in_time_and_with_the_other_bracket(build):
    """A negative h, and the opposite sign of the bracket, undo a step."""
    there = run(build(), BODY, 2.5, 4)
    for program, h in ((build(), -2.5), (build("-DSMG_ORIENTATION=-1"), 2.5)):
        back = run(program, BODY, h, 4, starts=" ".join(f"{x:.18g}" for x in there.w[0]))
        assert np.abs(back.w[0] - np.array(START.split(), float)).max() < 1e-10
    there = run(build(), FIELD, 2.5, 4, t0=0.5)
    back = run(build(), FIELD, -2.5, 4, t0=10.5, starts=" ".join(f"{x:.18g}" for x in there.w[0]))
    assert np.abs(back.w[0] - np.array(START.split(), float)).max() < 1e-10


def test_round_off_is_carried_along(build):
    """100000 short steps of the free body: sums with a carry lose next to nothing, plain ones the digits of a random walk."""
    exact = np.array([np.longdouble(x) for x in FREE_AT_10])
    carried, plain = (np.abs(run(build(FIXED, *flags), FREE_BODY, 1e-4, 100000).w - exact).max() for flags in ((), ("-DSMG_PLAIN_SUMS=1",)))
    print(carried, plain)
    assert carried < 1e-15 and plain > 5 * carried


@pytest.mark.parametrize("flags", [(), (PROJECT,)])
def test_a_zero_state_stays(build, flags):
    """Projected too: its leaf is a point."""
    found = run(build(*flags), BODY_R3, 3, 2, starts="0 0 0")
    assert found.status == OK and not found.w.any() and found.internal == 2


def test_the_natural_size_is_remembered(build):
    """Output steps much shorter than the internal ones are one each; of longer ones hardly any try is refused."""
    assert run(build(), BODY, 0.01, 200).internal <= 202
    long, short = run(build(), BODY, 100, 1), run(build(), BODY, 10, 10)
    assert long.internal <= short.internal <= long.internal + 20


# -- leaves, energy, area -----------------------------------------------------------------------

@pytest.mark.parametrize("what", [BODY, BODY_R3, VORTICES, FIELD, NAMBU])
def test_projection_keeps_the_leaf_and_nothing_else_does(build, what):
    free, held = (run(build(*flags), what, 5, 200, tolerance="1e-6") for flags in ((), (PROJECT,)))
    print(what, free.off, held.off)
    assert abs(free.off) > 1e-7
    assert abs(held.off) < (5e-16 if what in (BODY, VORTICES, FIELD) else 2e-14)   # R^3 and Nambu: a leaf of each step's own


def test_projection_leaves_the_order_of_the_error(build):
    exact = run(build(QUAD), NAMBU, 5, 1, tolerance="1e-21").w
    for digits in (6, 9):
        for flags in ((), (PROJECT,)):
            found = run(build(*flags), NAMBU, 5, 1, tolerance=f"1e-{digits}").w
            assert np.abs(found - exact).max() < 300 * 10.0**-digits


def energy(w):
    return np.sum((w[0]**2 + 0.3 * w[0]**3) / (2 * np.array([1, 2, 4])))


def test_energy_drifts(build):
    """Projected or not: the error of the energy goes on growing with time, in proportion to it."""
    for flags in ((), (PROJECT,)):
        program = build(*flags)
        first = energy(run(program, BODY, 1, 0).w)
        drift = [energy(run(program, BODY, 50, steps, tolerance="1e-6").w) - first for steps in (200, 800)]
        print(flags, drift)
        assert abs(drift[0]) > 1e-7 and 3 < drift[1] / drift[0] < 5


def test_it_is_not_symplectic(build):
    """The area form of the sphere under one large step: W.(DW a x DW b) is not w.(a x b)."""
    program, w = build(LONG, FIXED, PROJECT), np.array([0.36, 0.48, 0.8], dtype=np.longdouble)
    a = np.cross(w, [0, 0, 1]) / np.linalg.norm(np.cross(w, [0, 0, 1]).astype(float))
    b, d = np.cross(w, a), np.longdouble(1e-3)
    found = []
    for h in (3, 0.05):
        at = [w, *(w + s * d * v for v in (a, b) for s in (-3, -2, -1, 1, 2, 3))]
        image = [r.w[0] for r in run(program, BODY, h, 1, starts=[" ".join(f"{np.format_float_positional(x, 21)}" for x in p / np.sqrt(p @ p)) for p in at])]
        W, weights = image[0], np.array([-1, 9, -45, 45, -9, 1], dtype=np.longdouble) / 60
        slopes = [sum(c * x for c, x in zip(weights, image[k:k + 6])) / d for k in (1, 7)]
        found.append(abs(W @ np.cross(*slopes) - 1))
    print(found)
    assert found[0] > 1e-6 and found[1] < 1e-13


# -- restart, failures --------------------------------------------------------------------------

@pytest.mark.parametrize("flags", [(), (LONG,), (PROJECT,), ("-DSMG_PLAIN_SUMS=1",), (FIXED,)])
@pytest.mark.parametrize("what", STARTS)
def test_restart_gives_the_same_bits(build, what, flags):
    """Of all that is saved, the history among it: one number more than head, w and compensation."""
    h = 0.3 if what in (VORTICES, NAMBU) or FIXED in flags else 2.5
    words = list(map(int, ask(build(*flags), what, h, "restart", 7, 20, t0=0.25)))
    sites = len(STARTS[what].split()) // 3
    assert words == [OK, OK, 11 + 6 * sites + 1, 1, *[OK] * 6]


def failed(program, what, h, steps, starts=START):
    """(status, site, steps done, is the state as it was)"""
    return list(map(int, ask(program, what, h, "fail", steps, starts=starts)))


@pytest.mark.parametrize("flags", [(), (LONG,), (FIXED,), (PROJECT,)])
def test_not_finite(build, flags):
    """The energy is no number beyond w_3 = 0.8, where the orbit goes after some steps, or is from the start."""
    status, site, count, same = failed(build(*flags), EDGE, 1, 50, "0 0.7855 0.6188")
    assert [status, site, same] == [NOT_FINITE, 0, 1] and count > 0
    assert failed(build(*flags), EDGE, 1, 50) == [NOT_FINITE, 0, 0, 1]


def test_the_site_of_a_failure(build):
    assert failed(build(), EDGE, 1, 50, "0.1 0.99 0.01  0 0.7855 0.6188")[:2] == [NOT_FINITE, 1]
    assert failed(build(), EDGE, 1, 50, "0 0.7855 0.6188  0.1 0.99 0.01")[:2] == [NOT_FINITE, 0]


@pytest.mark.parametrize("h", ["1e6", "1e13"])
def test_no_convergence(build, h):
    """1e6: more internal steps than the cap; 1e13: the size they would need is less than 1e-12 of h."""
    assert failed(build(), FREE_BODY, h, 1) == [NO_CONVERGENCE, 0, 0, 1]


# -- compilers ----------------------------------------------------------------------------------

@pytest.mark.parametrize("flags", [(), (LONG,), (QUAD,), (PROJECT, FIXED), (LONG, PROJECT), ("-DTIMED=0", "-DSMG_PLAIN_SUMS=1", PROJECT)])
@pytest.mark.parametrize("compiler", [pytest.param(c, marks=() if c in ("gcc", "clang++") else pytest.mark.long) for c in COMPILERS])
def test_no_compiler_complains(compiler, flags):
    if shutil.which(compiler) is None or (QUAD in flags and "clang" in compiler):
        pytest.skip("no such compiler, or none with quadruple numbers")
    promotes = ["-Wno-double-promotion"] if LONG in flags and "clang" in compiler else []    # as in tests/support/strict.py
    optimised = compiler == "gcc" and not {LONG, QUAD} & set(flags)      # some of its warnings need the flow of data
    how = ["-O1", "-c", "-o", "/dev/null"] if optimised else ["-fsyntax-only"]
    done = subprocess.run([*COMPILERS[compiler], *WARNINGS, *promotes, *flags, *PATHS, *how, str(SOURCE)], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr


@pytest.mark.parametrize("flags", [(), (PROJECT,)])
def test_sanitizers_find_nothing(build, flags):
    program = build("-fsanitize=address,undefined", "-fno-sanitize-recover=all", *flags)
    for what in STARTS:
        h = 0.3 if what in (VORTICES, NAMBU) else 2.5
        plain = run(build(*flags), what, h, 5)
        assert np.allclose(np.array(run(program, what, h, 5).w, float), np.array(plain.w, float), rtol=0, atol=1e-13)
        ask(program, what, h, "restart", 3, 4)
        ask(program, what, h, "look")
    assert failed(program, EDGE, 1, 50, "0 0.7855 0.6188")[0] == NOT_FINITE
