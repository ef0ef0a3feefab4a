"""What accuracy costs at a temperature: errors of means, with their standard errors."""
import math

import pytest

import smidgen
from smidgen.cost import WeakCost
from smidgen.cost.weak import COLUMNS, FEWEST, WeakRow, fastest
from smidgen.cost.weak_choice import weak_choice
from smidgen.errors import UsageError
from smidgen.methods import METHODS

WARM = """[model]
name = "warm"
[space]
w = { sphere = "n" }
[parameters]
n = 200
kT = 0.5
[effects.field]
over = "site(i) of w"
energy = "-w[i].z"
[effects.bath]
over = "site(i) of w"
damping = 0.5
kT = "kT"
[observables.mz]
over = "site(i) of w"
value = "w[i].z/n"
[starts.up]
theta = 0.5
phi = 0
[runs.demo]
start = "up"
h = 0.15625
time = 40
"""


@pytest.fixture(scope="module")
def warm():
    return smidgen.load_text(WARM)


@pytest.fixture(scope="module")
def heun(warm):
    """As few members as a standard error needs, so that the numbers are the same on every machine."""
    return smidgen.cost(warm, methods=["heun"], mean="mz", seconds=1e-3)


def test_all_rows_begin_at_the_same_random_start():
    """Without damping to speak of, the energy stays what it is in the beginning."""
    text = WARM.replace("theta = 0.5\nphi = 0", "random = 1").replace("damping = 0.5", "damping = 1e-6").replace("n = 200", "n = 2").replace("time = 40", "time = 5")
    found = smidgen.cost(smidgen.load_text(text), methods=["heun"], seconds=1e-3)
    assert max(abs(row.error) for row in found.rows) < 0.02


def test_the_error_of_a_mean_is_that_of_the_step(heun):
    """One spin in a field: Heun's mean is 3.6e-3 too large at h = 0.1, by tests/laws/test_weak_order.py, so some 2.3e-2 at h = 0.625."""
    assert [row.members for row in heun.rows] == [FEWEST] * 4 and [round(row.h / 0.078125) for row in heun.rows] == [8, 4, 2, 1]
    first = heun.rows[0]
    assert abs(first.error - 0.0225) < 3 * first.error_error and first.error > 4 * first.error_error
    exact = 1 / math.tanh(2) - 0.5
    assert abs(heun.reference.mean - exact) < 4 * heun.reference.mean_error < 0.012
    assert first.mean - heun.reference.mean == first.error


def test_its_table_and_its_words(heun, tmp_path):
    assert isinstance(heun, WeakCost)
    lines = heun.save(tmp_path / "warm.csv").read_text().splitlines()
    assert ",".join(("kind", *COLUMNS)) in lines and sum(line.startswith("weak,heun,") for line in lines) == 4
    assert any(line.startswith("reference,spherical-midpoint,") for line in lines) and "# number = mz" in lines
    said = str(heun)
    assert "mean of `mz` from t = 20 to 40" in said and "* the error due to the step" in said and "time to an error of 0.1" in said


def test_the_time_for_an_error_has_both_kinds():
    """Chance falls as one over the root of the time; what the step adds stays."""
    row = WeakRow("heun", 0.1, 10, members=100, mean=1, mean_error=0.01, error=0.03, error_error=0.01, seconds=2)
    assert row.takes(0.05) == pytest.approx(2 * 0.01**2 / (0.05**2 - 0.03**2)) and row.takes(0.03) == math.inf
    lucky = WeakRow("heun", 0.1, 10, members=100, mean=1, mean_error=0.01, error=0.0, error_error=0.01, seconds=2)
    assert lucky.takes(0.01) == math.inf        # an error that is not told from 0 may be as large as its standard error
    assert WeakRow("heun", 0.1, 10, status="fails").takes(1) == math.inf
    found = fastest(WeakCost([row, lucky], WeakRow("spherical-midpoint", 0.1, 10, mean_error=0.001), {}))
    assert len(found) > 1 and all("Heun" in line for line in found[1:])


def test_what_does_not_fit_is_refused(warm):
    with pytest.raises(UsageError, match="no quantity 'my'"):
        smidgen.cost(warm, mean="my", seconds=1e-3)
    with pytest.raises(UsageError, match="the error of a mean is measured: `peers`"):
        smidgen.cost(warm, peers=True)
    with pytest.raises(UsageError, match="the mean of `mz` is defined only at a temperature"):
        smidgen.cost(warm, effects=["field"], mean="mz")
    assert METHODS["heun"].noise_within and not METHODS["cf4"].noise_within


def row(name, h, error, seconds=1.0, **more):
    return WeakRow(name, h, round(40 / h), members=100, mean_error=0.01, error=error, error_error=0.001, seconds=seconds, ns_step=10.0, **more)


def test_the_choice_is_the_row_that_is_there_first():
    """takes: seconds mean_error^2/(target^2 - step^2), and as many times the members."""
    rows = [row("spherical-midpoint", 0.2, 0.05), row("spherical-midpoint", 0.1, 0.012, 2.0), row("heun", 0.05, 0.015, 4.0), row("depondt-mertens", 0.1, -0.03, 5.0)]
    cost = WeakCost(rows, WeakRow("spherical-midpoint", 0.01, 4000, members=400, mean_error=0.001), {"number": "mz"})
    pick = weak_choice(cost, 0.02)
    assert pick.settings == {"method": "spherical-midpoint", "h": 0.1, "steps": 400}
    assert pick.members == math.ceil(100 * 1e-4 / (0.02 ** 2 - 0.012 ** 2)) and [r.method for r in pick.others] == ["heun"] and set(pick.short) == {"depondt-mertens"}
    assert "spherical midpoint" in str(pick) and "40 members" in str(pick) and "depondt" in str(pick).lower() and pick.as_dict()["members"] == 40
    assert weak_choice(cost, 0.2).row.h == 0.2         # a larger step serves a larger error
    with pytest.raises(UsageError, match="no method reaches this accuracy: .*the error due to the step is 1.2e-02"):
        weak_choice(cost, 0.009)
    with pytest.raises(UsageError, match="the mean is known only to within ± 1.0e-03"):
        weak_choice(cost, 0.0015)


def test_choose_measures_at_a_temperature(warm):
    pick = smidgen.choose(warm, error=0.05, mean="mz", seconds=0.5, time=10)
    assert pick.row.method in ("spherical-midpoint", "heun", "depondt-mertens") and pick.members >= 1
    assert abs(pick.row.error) < 0.05 and pick.cost.facts["number"] == "mz"


@pytest.mark.parametrize("asked, said", [({}, "a positive error of the mean"), ({"energy": 0.1}, "steps are not symplectic"), ({"error": 0.1, "symplectic": True}, "steps are not symplectic")])
def test_choose_asks_for_the_error_of_a_mean(warm, asked, said):
    with pytest.raises(UsageError, match=said):
        smidgen.choose(warm, seconds=1e-3, **asked)
