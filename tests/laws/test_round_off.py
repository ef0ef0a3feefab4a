"""Round-off walks at random: over 1e5, 1e6 and more steps it grows like sqrt(N), not like N."""
import subprocess
import sys

import numpy as np
import pytest
import smidgen
from bench.round_off.costs import in_turns
from bench.round_off.growth import RUNS, TABLES, measured
from bench.round_off.page import meets, page, verdict
from bench.round_off.programs import DEFAULT, LANES, LONG, PAIRS, PLAIN
from bench.round_off.rows import Cost, Growth, exponent, keep_row, read_rows, small
from support.measure import casimirs, energy, scatter, start_points
from support.systems import CLASSICAL, VESELOV, begin, model

pytestmark = pytest.mark.usefixtures("optimised")
EPSILON = np.finfo(float).eps


def changes(one, starts, h, count, *quantities):
    """Change of each quantity of one site over `count` steps of h, for every start: (quantities, starts)."""
    def values():
        return [np.ravel(quantity(one))[0] for quantity in quantities]
    found = []
    for w in starts:
        one.start(w.copy(), h=h)
        before = values()
        one.steps(count)
        found.append(np.subtract(values(), before))
    return np.transpose(found)


def unbiased(found) -> bool:
    """Is the mean what a random walk of so many orbits may have, three and a half deviations?"""
    return abs(np.mean(found)) < 3.5 / np.sqrt(len(found)) * np.sqrt(np.mean(found**2))


@pytest.mark.quick
def test_a_bias_would_show():
    dice = np.random.default_rng(2).standard_normal(24)
    assert unbiased(dice) and not unbiased(dice + 1.2)


@pytest.mark.parametrize("h, count", [(0.125, 100_000), (0.4, 100_000),
                                      *(pytest.param(h, 1_000_000, marks=pytest.mark.long) for h in (0.05, 0.0877, 0.125, 0.4))])
def test_round_off_takes_no_side(h, count):
    """24 orbits of the free body: what each has lost or won has no common sign."""
    one = model(begin("free_rigid_body"))
    for quantity, found in zip((energy, casimirs), changes(one, start_points(24), h, count, energy, casimirs)):
        rms = np.sqrt(np.mean(found**2))
        print(f"h = {h}: {quantity.__name__} after {count} steps: rms {rms:.1e}, mean {found.mean():.1e}")
        assert unbiased(found) or rms < EPSILON
        assert rms < 60 * EPSILON


@pytest.mark.parametrize("count", [100_000, pytest.param(1_000_000, marks=pytest.mark.long)])
def test_round_off_of_large_steps(count):
    """At h = 1 a side is taken, but |w|^2 is no worse than the random walk of steps w += h X at
    h = 0.1 without a carry: 5.2e-14 after 1e6 steps."""
    found, = changes(model(begin("free_rigid_body")), start_points(24), 1.0, count, casimirs)
    assert np.sqrt(np.mean(found**2)) < 5.2e-14 * np.sqrt(count / 1e6)


@pytest.mark.parametrize("name, values, count", [
    ("two_bodies", {}, 1_000_000), ("heisenberg_chain", {"n": 6}, 100_000), *(pytest.param(name, values, 1_000_000, marks=pytest.mark.long) for name, values in (
        ("nambu_a39", {}), ("point_vortices", {}), ("heisenberg_chain", {"n": 6})))])
def test_casimirs_do_not_drift(name, values, count):
    case = begin(name, **values)
    early, late = scatter(model(case), [case.w], case.h, (count // 10, count), casimirs)
    print(f"{name}: rms casimir error after {count // 10}, {count} steps: {early:.1e}, {late:.1e}")
    assert late < 6 * max(early, 4 * EPSILON)        # few sites: below some ulps the law is noise
    assert late < 40 * EPSILON


TWO = """
[model]
name = "two_coupled"
[space]
w = { sphere = 2 }
[parameters]
K = 1.0
[effects.coupling]
energy = "K*dot(w[0], w[1])"
[starts.any]
random = 1
"""
LARGE = [(1.0, 2, 20_000), (10.0, 0, 2_000), (1000.0, 0, 2_000),
         *(pytest.param(*one, marks=pytest.mark.long) for one in ((1.0, 2, 100_000), (1.0, 3, 100_000), (1.0, 7, 100_000), (10.0, 0, 40_000), (1000.0, 0, 40_000)))]


@pytest.mark.parametrize("K, draw, count", LARGE)
def test_two_spins_do_not_drift_at_large_steps(K, draw, count):
    """h K from 1 to 1000. Near a quarter turn (the third draw) plain evaluations do not damp what an iteration leaves: where the
    step ended with one, |w|^2 was off by 8e-13 after 1e5 steps. What is left walks at random, an ulp a step."""
    dice = np.random.default_rng(0)
    w = [dice.normal(size=(2, 3)) for _ in range(draw + 1)][-1]
    one = smidgen.build(smidgen.load_text(TWO), parameters={"K": K}).start(w / np.linalg.norm(w, axis=1)[:, None], h=1.0)
    before = one.w.copy()
    after = one.steps(count).w
    squares = [(x.sum(axis=0) ** 2).sum() for x in (before, after)]
    assert np.abs((after**2).sum(axis=1) - (before**2).sum(axis=1)).max() < 3 * EPSILON * np.sqrt(count)
    assert abs(squares[1] - squares[0]) < 10 * EPSILON * np.sqrt(count)


@pytest.mark.parametrize("count", [100_000, pytest.param(1_000_000, marks=pytest.mark.long)])
@pytest.mark.parametrize("method", [CLASSICAL, VESELOV])
def test_comparators_do_not_drift(method, count):
    """A comparison of methods must not compare their round-off."""
    one = model(begin("free_rigid_body"), method)
    early, late = scatter(one, start_points(6), 0.1, (count // 10, count), energy)
    assert late < 6 * max(early, EPSILON / 2) and late < 20 * EPSILON


@pytest.mark.parametrize("name, values, method, h, count", [("free_rigid_body", {}, "gauss-16", 0.5, 50_000), ("heisenberg_chain", {"n": 8}, "gauss-8", 0.2, 20_000)])
def test_lengths_of_collocation_walk_at_random(name, values, method, h, count):
    """By stages and by rows. With |w| as a root of squares in z, lengths were off by 0.13 ulp times sqrt(count), a drift; now by 0.009 and 0.005."""
    one = model(begin(name, **values), method)
    starts = start_points(8) if name == "free_rigid_body" else [start_points(8)[:, 0]]
    rms, = scatter(one, starts, h, (count,), lambda one: np.linalg.norm(one.w.astype(np.longdouble), axis=-1))
    print(f"{name}: {rms / EPSILON / np.sqrt(count):.4f} ulp a root of a step")
    assert rms < 0.02 * EPSILON * np.sqrt(count)


@pytest.mark.long
def test_round_off_does_not_drift_for_long():
    one, orbits = model(begin("free_rigid_body")), start_points(16)
    found = scatter(one, orbits, 0.1, (100_000, 1_000_000, 10_000_000), energy)
    print("rms energy error after 1e5, 1e6, 1e7 steps:", *(f"{e:.1e}" for e in found))
    assert found[2] < 6 * found[1] and found[2] < 2e-14


# ---- the study of docs/round_off.md: its programs at small N, its judgement, its page -------------------------------

def found(where, table, quantity, variant, orbits, steps):
    """The rows of one variant of a table, of few orbits and steps."""
    rows = list(measured(table, where, {variant: [(orbits, steps)]}))
    return [r for r in rows if r.quantity == quantity]


def test_the_default_keeps_the_law_of_the_study(tmp_path):
    """rms dH <= 1e-18 sqrt(N) of forty orbits at 1e4 and 1e5 steps."""
    rows = found(tmp_path, "free", "H", DEFAULT, 40, (10**4, 10**5))
    assert [r.steps for r in rows] == [10**4, 10**5] and small(rows) and all(r.rms > 1e-20 for r in rows)


@pytest.mark.parametrize("variant, size", [(PLAIN, 1e-16), *(pytest.param(*one, marks=pytest.mark.long) for one in ((LONG, 1e-21), (PAIRS, 1e-31)))])
def test_the_other_variants_are_as_large_as_their_digits(variant, size, tmp_path):
    rows = found(tmp_path, "free", "H", variant, 8, (10**4, 10**5))
    assert small(rows, size) and not small(rows, size / 1000)
    assert small(rows) == (variant != PLAIN)        # the judgement says no to sums without a carry


@pytest.mark.parametrize("variant", [pytest.param(v, marks=pytest.mark.long if k else ()) for k, v in enumerate(LANES)])
def test_lanes_keep_the_law_for_a_while(variant, tmp_path):
    rows = found(tmp_path, "lanes", "H", variant, 8, (10**4, 10**5))
    assert len(rows) == 2 and small(rows)


@pytest.mark.parametrize("table, orbits, variant, size", [("irreversible", 8, DEFAULT, 1e-17), *(
    pytest.param(*one, marks=pytest.mark.long) for one in (
        ("irreversible", 8, LONG, 1e-20), ("chain of 8", 8, DEFAULT, 1e-17), ("chain of 8", 8, LONG, 1e-19)))])
def test_lengths_walk_at_random(table, orbits, variant, size, tmp_path):
    rows = found(tmp_path, table, "|w|", variant, orbits, (10**3, 10**4))
    assert small(rows, size) and all(r.orbits == orbits and r.rms > 0 for r in rows)


@pytest.mark.long
def test_the_study_reaches_far(tmp_path):
    """Forty orbits to 1e7 steps: small, and no drift."""
    rows = found(tmp_path, "free", "H", DEFAULT, 40, (10**5, 10**6, 10**7))
    assert small(rows) and exponent(rows) <= 0.6


@pytest.mark.long
def test_distance_to_quadruple_precision_grows_like_the_three_halves(tmp_path):
    from bench.round_off.growth import distance
    rows = list(distance("distance", tmp_path, (10**3, 10**4, 10**5), (10**3, 10**4, 10**5), count=4))
    default = [r for r in rows if r.variant == DEFAULT]
    assert 1.2 < exponent(default) < 1.8 and default[0].rms < 1e-14
    assert all(r.rms < 1e-24 for r in rows if r.variant == PAIRS)


def rows_like(table, variant, law, scale):
    return [Growth(table, "H", variant, 40, n, scale * n**law, 0.0, "any") for n in (10**5, 10**6, 10**7, 10**8)]


@pytest.mark.quick
def test_the_judgement_says_no():
    """Too large, or too steep although small."""
    assert meets(rows_like("free", "a", 0.5, 0.99e-18)) and not meets(rows_like("free", "a", 0.5, 1.01e-18))
    assert not meets(rows_like("free", "a", 0.7, 1e-22)) and not meets(rows_like("free", "a", 0.5, 1e-19)[:3])


@pytest.mark.quick
def test_the_cheapest_that_keeps_the_law_is_named():
    rows = [*rows_like("free", "slow", 0.5, 1e-19), *rows_like("free", "fast", 0.5, 5e-19), *rows_like("free", "bad", 1, 1e-20)]
    cost = [Cost("free", v, 3, t, t, t, "any") for v, t in (("slow", 9.0), ("fast", 4.0), ("bad", 1.0))]
    assert "**fast**, 4.0 ns" in verdict(rows, cost, "free")
    assert "none" in verdict(rows[8:], cost, "free")


@pytest.mark.quick
def test_rows_are_kept_once(tmp_path):
    path, rows = tmp_path / "rows.csv", rows_like("free", "a", 0.5, 1e-19)
    for row in (*rows, *rows_like("free", "a", 0.5, 2e-19)[:1]):
        keep_row(path, row)
    kept = read_rows(path, Growth)
    assert len(kept) == 4 and kept[0].rms == 2 * rows[0].rms and kept[1:] == rows[1:]


@pytest.mark.quick
def test_programs_take_turns(tmp_path):
    path = tmp_path / "count"
    path.write_text(f"#!/bin/sh\necho x >> {tmp_path}/calls\nwc -l < {tmp_path}/calls\n")
    path.chmod(0o755)
    assert in_turns({"a": path, "b": path}, 3) == {"a": [1, 3, 5], "b": [2, 4, 6]}


@pytest.mark.quick
def test_the_page_is_of_its_tables(root):
    docs, prose = root / "docs", root / "tests" / "bench" / "round_off.md.in"
    rows, cost = read_rows(docs / "round_off.csv", Growth), read_rows(docs / "round_off_cost.csv", Cost)
    assert page(rows, cost, prose.read_text()) == (docs / "round_off.md").read_text()
    assert {r.table for r in rows} == set(TABLES) - {"cost"}
    assert {(r.table, r.variant) for r in rows if r.table in RUNS} == {(t, v) for t in RUNS for v in RUNS[t]}


def test_an_unknown_table_is_refused(root):
    said = subprocess.run([sys.executable, str(root / "tests" / "bench" / "round_off.py"), "nothing"], capture_output=True, text=True)
    assert said.returncode == 2 and "no table nothing" in said.stderr and "Traceback" not in said.stderr
