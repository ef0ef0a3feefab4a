"""What accuracy costs: the table, its file and figure, the choice of a method, the error of a run."""
import dataclasses
import math
import re
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import smidgen
from smidgen.cli.choose import written
from smidgen.build.binary import find_compiler, lanes_of
from smidgen.check.witness import Witness
from smidgen.cost import measured as measured_facts
from smidgen.cost.measure.case import Case, candidates
from smidgen.cost.even import GENERAL, steps_until_even
from smidgen.cost.frontier import by_method, first, keeps_energy, seconds_for
from smidgen.cost.peers import PEERS, compiled, of_case
from smidgen.cost.peers.rows import one as one_of_peers
from smidgen.cost import choice, versus
from smidgen.cost.measure import case as measured_case, sweep
from smidgen.cost.measure.clock import processor_seconds
from smidgen.cost.measure.reference import Reference, lost_to_round_off, reference
from smidgen.cost.report import Cost, load_cost
from smidgen.cost.measure.sweep import Row, parts, slope
from smidgen.errors import RunError, UsageError
from smidgen.methods import METHODS
from smidgen.run.settings import settle
from smidgen.read.load import load_text
from smidgen.run.estimate import TOLERANCE
from smidgen.run.settings import settle
from smidgen.show.plot import cost as cost_figure
from smidgen.show.plot.cost import draw_cost, leading

FEW = ("spherical-midpoint", "gauss-6", "dop853")


def rows(name="gauss-2", order=2, steps=(10, 20, 40), one=1e-6):
    """Rows whose error is N^-order and whose time is N*one."""
    return [Row(name, 1 / n, n, end_error=float(n) ** -order, energy=1e-17, seconds=n * one) for n in steps]


@pytest.fixture(scope="module")
def table():
    return smidgen.cost(smidgen.load("irreversible_rigid_body"), time=10, methods=FEW, seconds=2)


@pytest.mark.quick
def test_the_time_for_an_error_lies_on_the_line_between_neighbours():
    assert math.isclose(seconds_for(rows(order=2), "end_error", 30.0 ** -2), 30e-6)
    assert math.isclose(seconds_for(rows(), "end_error", 1.0), 10e-6)           # the largest step is good enough
    assert math.isnan(seconds_for(rows(), "end_error", 1e-9))       # none is
    quick = [*rows()[:2], dataclasses.replace(rows()[2], seconds=5e-6)]
    assert math.isclose(seconds_for(quick, "end_error", 30.0 ** -2), 5e-6)      # a smaller step that takes less time
    failed = [dataclasses.replace(rows()[0], status="no solution"), *rows()[1:]]
    assert math.isclose(seconds_for(failed, "end_error", 1.0), 20e-6)


@pytest.mark.quick
def test_the_first_is_the_fastest_of_those_that_get_there():
    both = rows("gauss-4", 4, one=5e-6) + rows("gauss-2", 2)
    assert first(both, "end_error", 1e-2)[0] == "gauss-2"
    assert first(both, "end_error", 1e-5)[0] == "gauss-4"
    assert first(both, "end_error", 1e-5, lambda name: name == "gauss-2")[0] == ""
    assert list(by_method(both)) == ["gauss-4", "gauss-2"]


@pytest.mark.quick
def test_energy_is_kept_where_every_step_keeps_it():
    good, bad = rows("good"), rows("bad")
    bad[0].energy = 1e-12
    assert keeps_energy(good + bad, 1.0) == {"good"}


@pytest.mark.quick
def test_a_slope_comes_with_its_error():
    t = np.linspace(0, 10, 50)
    noise = 0.01 * (-1.0) ** np.arange(50)
    a, off = slope(t, 3 * t + 1 + noise)
    assert abs(a - 3) < 3 * off < 3e-3


@pytest.mark.quick
@pytest.mark.parametrize("steps", [1, 5, 48, 49, 1000])
def test_samples_add_up_to_the_run(steps):
    assert sum(parts(steps)) == steps and min(parts(steps)) > 0


@pytest.mark.quick
def test_time_of_the_processor_is_that_of_children_too_and_not_of_waiting():
    before = processor_seconds()
    subprocess.run([sys.executable, "-c", "import time\nwhile time.process_time() < 0.4: pass"], check=True)
    worked = processor_seconds()
    time.sleep(0.4)
    assert 0.35 < worked - before < 4 and processor_seconds() - worked < 0.1


@pytest.mark.quick
def test_compiling_is_counted_in_time_of_the_processor(monkeypatch):
    ticks = iter(range(0, 1000, 3))
    monkeypatch.setattr(measured_case, "processor_seconds", lambda: next(ticks))
    spec = smidgen.load("free_rigid_body")
    assert Case(spec, settle(spec), 1.0).compiled == {("spherical-midpoint", "double"): 3}


def test_the_reference_is_the_flow_to_the_error_it_states():
    spec = smidgen.load("point_vortices")
    case = Case(spec, settle(spec), 5.0)
    known = reference(case)
    flow = Witness(spec).flow(case.w, 0.0, [5.0])[0]
    assert known.error < 1e-13 and case.distance(known.end, flow) < 1e-11
    assert len({METHODS[name].header for name in known.methods}) == 2


@pytest.mark.parametrize("name, time", [("nambu_a31", 10.0), ("free_rigid_body", 100.0), ("two_bodies", 5.0)])
def test_an_end_that_can_be_known_is_not_lost(name, time):
    """Also where the first methods that serve take steps of their own: those of two precisions differ by their tolerance."""
    spec = smidgen.load(name)
    assert not lost_to_round_off(Case(spec, settle(spec), time))


@pytest.mark.long
@pytest.mark.usefixtures("as_shipped")
def test_an_end_that_nobody_knows_is_not_judged():
    spec = smidgen.load("heisenberg_chain")
    chain = dict(parameters={"n": 6}, time=600, start=np.random.default_rng(3).normal(size=(6, 3)))
    chain["start"] /= np.linalg.norm(chain["start"], axis=1)[:, None]
    found = smidgen.cost(spec, methods=("spherical-midpoint",), seconds=1, long=False, **chain)
    assert all(math.isnan(row.end_error) for row in found.rows) and "no errors of the final state" in str(found)
    with pytest.raises(UsageError, match="chaotic"):
        smidgen.choose(spec, error=1e-8, methods=("spherical-midpoint",), **chain)


def test_errors_fall_as_the_order_says(table):
    for name, own in by_method(table.rows).items():
        good = [r for r in own if not r.status and 1e-11 < r.end_error < 1e-3]
        good = good[len(good) // 2:]        # in the largest steps leading terms of one sign may cancel later ones
        if METHODS[name].controlled or len(good) < 2:
            continue
        observed = math.log(good[0].end_error / good[-1].end_error) / math.log(good[-1].steps / good[0].steps)
        assert abs(observed - METHODS[name].order) < 0.1 * METHODS[name].order, name


def test_every_row_is_whole(table):
    assert {row.method for row in table.rows} == set(FEW)
    for row in table.rows:
        assert row.status or (row.seconds > 0 and row.end_error >= 0 and row.ns_step > 0)
        assert row.status or row.tolerance == row.tolerance or row.casimir < 1e-12
    assert {name for name, *_ in table.long} == set(FEW)
    assert "fastest, symplectic" in str(table)


@pytest.mark.usefixtures("as_shipped")
def test_runs_without_a_known_end_go_to_a_tolerance_by_their_energy():
    """Twice the energy error at most, in fewer iterations, where steps resolve the motion (with 57 of them, h = 5.3, what an iteration leaves
    is not in proportion to what it does); a single sphere's midpoints have none to end."""
    found = smidgen.cost(smidgen.load("irreversible_rigid_body"), time=300, methods=("gauss-8", "spherical-midpoint"), seconds=1, ends=False, long=False)
    exact = {row.steps: row for row in found.rows if row.method == "gauss-8" and row.tolerance != row.tolerance}
    loose = [row for row in found.rows if row.tolerance == row.tolerance and exact[row.steps].energy < 1e-2]
    assert len(loose) > 5 and {row.method for row in loose} == {"gauss-8"}
    assert all(row.energy < 2 * exact[row.steps].energy and row.iterations < 0.9 * exact[row.steps].iterations for row in loose)


def test_a_method_whose_steps_all_fail_is_given_up(monkeypatch):
    """No time of theirs is known; the steps become no smaller than those of a run that would take too long in any case."""
    def failing(case, name, steps, known, tolerance=None):
        return Row(name, 1 / steps, steps, status="no convergence")
    monkeypatch.setattr(sweep, "one", failing)
    case = SimpleNamespace(fewest=lambda turn: 10, w=np.zeros((50, 3)))
    rows = sweep.ladder(case, "gauss-4", Reference(np.zeros((50, 3)), 0.0, ()), limit=1.0)
    assert all(row.status for row in rows) and 1e6 < rows[-1].steps < 1e8


def test_the_file_holds_the_table_and_the_figure_is_made_of_it_alone(table, tmp_path):
    again = load_cost(table.save(tmp_path / "a.csv"))
    assert again.save(tmp_path / "b.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()
    assert again.facts == {k: str(v) for k, v in table.facts.items()}
    one, two = (draw_cost(again, tmp_path / name).read_bytes() for name in ("a.png", "b.png"))
    assert one == two


def made(name, times):
    """Rows of a method: the time it takes for 1e-2, 1e-4, .."""
    return [Row(name, 1.0, 10 + k, end_error=100.0 ** -(k + 1), energy=1.0, seconds=t) for k, t in enumerate(times)]


@pytest.mark.quick
def test_the_figure_shows_the_frontier_and_names_the_rest(tmp_path, monkeypatch):
    """The fastest of each kind for some error, and the spherical midpoint; of the rest the names."""
    rows = [*made("classical-midpoint", [6, 7, 8]), *made("spherical-midpoint", [3, 4, 5]), *made("gauss-4", [1, 2, 9]), *made("gauss-8", [2, 3, 4]),
            *made("gauss-6", [5, 5, 5]), *made("dop853", [0.5, 0.6, 0.7]), *made("cf4", [1, 1, 1]), *made("gsl-rk8pd", [2, 2, 2]), *made("scipy", [9, 9, 9])]
    assert leading(rows, "end_error") == ["spherical-midpoint", "gauss-4", "gauss-8", "dop853", "gsl-rk8pd"]
    figures = []
    monkeypatch.setattr(cost_figure, "save", lambda figure, path: figures.append(figure))
    draw_cost(Cost(rows, [("gauss-6", 1.0, 1.0, 1.0), ("gauss-8", 1.0, 1.0, 1.0)], dict.fromkeys(("spec", "run", "time", "sites", "machine", "reference"), "x")), "x.png")
    (figure,) = figures
    assert [len(ax.lines) for ax in figure.axes] == [5, 5, 0, 1]
    said = " ".join(t.get_text() for t in figure.texts).replace("\n", " ")
    assert "not the fastest of their kind for any error: classical midpoint, Gauss 6, CF4, SciPy DOP853" in said


def test_a_notebook_shows_a_line_of_a_table(table):
    assert len(repr(table)) < 200 and f"{len(table.rows)} rows of {len(FEW)} methods" in repr(table)


@pytest.mark.quick
def test_a_file_of_something_else_is_refused(tmp_path):
    for text in ("", "a,b\n1,2\n", "\x00"):
        (tmp_path / "x.csv").write_text(text)
        with pytest.raises(UsageError):
            load_cost(tmp_path / "x.csv")
    with pytest.raises(UsageError):
        load_cost(tmp_path / "none.csv")


@pytest.mark.long
@pytest.mark.parametrize("error, symplectic", [(1e-4, True), (1e-9, False)])
def test_the_choice_is_as_good_as_was_asked_for(error, symplectic):
    """Judged by the witness, which the choice does not know."""
    spec = smidgen.load("irreversible_rigid_body")
    pick = smidgen.choose(spec, error=error, time=10, symplectic=symplectic, methods=("spherical-midpoint", "gauss-4", "gauss-8", "dop853"))
    case = Case(spec, settle(spec), 10.0)
    end = smidgen.run(spec, **pick.settings).final
    assert case.distance(end, Witness(spec).flow(case.w, 0.0, [10.0])[0]) <= error
    assert METHODS[pick.row.method].symplectic or not symplectic
    assert all(pick.row.seconds <= other.seconds for other in pick.others) and pick.row.method in str(pick)


@pytest.mark.long
def test_a_choice_by_energy():
    pick = smidgen.choose(smidgen.load("irreversible_rigid_body"), energy=1e-7, time=10, methods=("spherical-midpoint", "gauss-6"))
    assert pick.row.method == "gauss-6" and pick.row.energy <= 1e-7


@pytest.mark.quick
@pytest.mark.parametrize("asked, said", [({}, "give the accuracy"), ({"error": 0.0}, "positive"), ({"error": -1.0}, "positive"),
                                         ({"energy": math.inf}, "positive"), ({"error": 1e-3, "time": 0}, "time"),
                                         ({"error": 1e-3, "methods": ["nothing"]}, "nothing")])
def test_what_cannot_be_asked_for_is_refused(asked, said):
    with pytest.raises(UsageError, match=said):
        smidgen.choose(smidgen.load("free_rigid_body"), **asked)


CHOSEN = """
[model]
name = "chosen"
[units]
energy = "meV"
time = "ps"
[space]
w = { sphere = 3, kappa = "1 hbar" }
[parameters]
B = { default = "1 meV" }
D = { default = ["1 meV", "1 meV", "1 meV"], size = 3 }
[effects.field]
over = "site(i) of w"
energy = "B*w[i].x"
[effects.axes]
over = "site(i) of w"
energy = "D[i]*w[i].z^2"
[effects.more]
over = "site(i) of w"
energy = "B*w[i].y^2"
[starts.any]
random = 1
[runs.first]
start = "any"
h = "1 fs"
time = "1 ps"
without = ["more"]
set = { B = "2 meV", D = ["1 meV", "3 meV", "5 meV"] }
[runs.other]
like = "first"
set = { B = "0.25 eV" }
"""


@pytest.mark.quick
@pytest.mark.parametrize("run", [None, "other"])
def test_the_chosen_run_is_one_of_the_same_model(tmp_path, run):
    """The effects and the values of the run that was measured, in the units of the spec."""
    spec, out = smidgen.load_text(CHOSEN), tmp_path / "chosen.toml"
    args = SimpleNamespace(out=out, run=run, parameters={}, effects=None, seed=None, start=None)
    row = SimpleNamespace(method="gauss-4", h=0.0625, steps=16)
    written(spec, args, SimpleNamespace(row=row, settings={"tolerance": 1e-5}))
    base, mine = settle(spec, run), settle(smidgen.load(out), "chosen")
    assert (mine.method, mine.h, mine.steps, mine.tolerance, mine.start) == ("gauss-4", 0.0625, 16, 1e-5, "any")
    assert mine.effects == base.effects == ("field", "axes")
    assert all(np.array_equal(mine.numbers.values[name], base.numbers.values[name]) for name in "BD")


@pytest.mark.long
def test_the_chosen_run_is_a_run_of_the_spec(command, tmp_path):
    out = command("choose", "free_rigid_body", "--error", "1e-6", "--time", "5", "--methods", "gauss-4,gauss-6", "--out", "chosen.toml")
    assert out.returncode == 0 and "Gauss" in out.stdout
    chosen = smidgen.load(str(tmp_path / "chosen.toml")).runs[-1]
    assert chosen.name == "chosen" and (chosen.tolerance is not None) == ("--tolerance" in out.stdout)
    assert command("run", "chosen.toml", "chosen").returncode == 0
    assert command("choose", "chosen.toml", "--error", "1e-6", "--out", "again.toml").returncode == 2


@pytest.mark.long
def test_the_command_draws_and_reads(command, tmp_path):
    out = command("cost", "free_rigid_body", "--time", "2", "--methods", "gauss-4", "--seconds", "1", "--out", "c.csv", "--plot", "c.svg")
    assert out.returncode == 0 and "Gauss 4" in out.stdout
    again = command("cost", "--from", "c.csv")
    assert again.returncode == 0 and again.stdout == out.stdout
    assert command("cost").returncode == 2


# General integrators beside

SYSTEMS = ("free_rigid_body", "forced_rigid_body", "vortex_tracers", "nambu_a34", "heisenberg_chain", "two_bodies")


@pytest.mark.long
@pytest.mark.parametrize("name", SYSTEMS)
def test_general_integrators_get_to_the_same_end(name):
    spec = smidgen.load(name)
    case = Case(spec, settle(spec, parameters={"n": 6} if name == "heisenberg_chain" else {}), 0.2 if name.startswith("nambu") else 1.0)
    known, (found, missing) = reference(case), of_case(case)
    assert {"gsl-rk8pd", "scipy"} <= set(found) and set(found) | set(missing) == set(PEERS)
    case.peers = found
    for peer in found:
        row = one_of_peers(case, peer, known, 1e-9, 1000.0)
        assert row.status == "" and row.steps > 0 and row.seconds > 0 and row.end_error < 1e-4, (peer, row)
        assert case.energy_changes or row.energy < 1e-4, (peer, row)


@pytest.mark.parametrize("name, values", [("free_rigid_body", {"I2": 1.7}), ("irreversible_rigid_body", {"sigma": 0.3}),
                                          ("point_vortices", {"gamma": [1.0, -0.5, 2.0, 0.7]}), ("heisenberg_chain", {"n": 7})])
def test_fields_by_hand_are_those_of_the_specs(name, values):
    """With other values too; the end is the flow's, forwards and backwards."""
    spec = smidgen.load(name)
    case = Case(spec, settle(spec, parameters=values), -2.0)
    found, missing = of_case(case, ("c-by-hand",))
    assert not missing
    states, steps = found["c-by-hand"].states(1e-12, [-1.0, -2.0])
    flow = Witness(spec, parameters=values).flow(case.w, 0.0, [-1.0, -2.0])
    assert steps > 5 and max(case.distance(a, b) for a, b in zip(states, flow)) < 1e-9
    assert found["c-by-hand"].seconds(1e-6, 3) > 0


FREE = """[model]
name = "free_rigid_body"
[space]
w = { sphere = 1 }
[parameters]
I1 = 1.0
I2 = 2.0
I3 = 4.0
[effects.rotation]
energy = "ENERGY"
[starts.up]
theta = 1.0
phi = 0.5
[runs.demo]
start = "up"
h = 0.1
time = 1
"""


@pytest.mark.parametrize("energy, same", [("w.x^2/(2*I1) + w.y^2/(2*I2) + w.z^2/(2*I3)", True), ("w.x^2/I1 + w.y^2/I2 + w.z^2/I3", False),
                                          ("(w.x^2/I1 + w.y^2/I2 + w.z^2/I3)/2 + 0.1*w.z", False)])
def test_a_field_by_hand_of_another_system_is_none(energy, same):
    """A spec may have the name of a shipped one."""
    spec = load_text(FREE.replace("ENERGY", energy))
    found, missing = of_case(Case(spec, settle(spec), 1.0), ("c-by-hand",))
    assert bool(found) == same and ("hand-written C field for this spec" in missing.get("c-by-hand", "")) != same


@pytest.mark.quick
def test_a_table_says_when_and_on_what_vectors_it_was_measured(table, monkeypatch):
    """As the header of lanes has them, and no more than the flags ask for."""
    assert {"date", "compiler", "lanes", "machine"} <= set(table.facts) and f"vectors of {table.facts['lanes']} lanes, {table.facts['date']}" in str(table)
    compiler = find_compiler()
    assert [lanes_of(compiler, flags) for flags in ((), ("-mavx",), ("-mavx512f",))] == [2, 4, 8]
    assert measured_facts(False)["lanes"] == 2


@pytest.mark.quick
def test_a_run_that_would_take_too_long_is_not_begun():
    """A peer that has been asked for the hundredth part twice is asked no more."""
    class Slow:
        asked = []
        def prepare(self, tolerance): pass
        def states(self, tolerance, times):
            self.asked.append(float(times[-1]))
            began = time.thread_time()
            while time.thread_time() - began < 2e-3: pass
            return np.zeros((len(times), 1, 3)), 1
    case = SimpleNamespace(peers={"slow": Slow()}, time=50.0)
    row = one_of_peers(case, "slow", None, 1e-9, 0.1)
    assert row.status == "a run would take more than 0.1 s" and Slow.asked == [0.5, 0.5]


@pytest.mark.quick
def test_what_is_missing_is_named(monkeypatch, tmp_path):
    """In one line, and the others are measured."""
    monkeypatch.setenv("SUNDIALS_DIR", str(tmp_path))
    monkeypatch.setattr(compiled, "SUNDIALS", ("-lsundials_that_is_not_there",))
    monkeypatch.setitem(sys.modules, "heyoka", None)
    found = smidgen.cost(smidgen.load("free_rigid_body"), time=1, methods=["spherical-midpoint"], seconds=0.2, long=False, peers=True)
    said = str(found)
    for word in ("cvode-adams requires SUNDIALS 7", "arkode requires SUNDIALS 7", "heyoka requires heyoka (pip install heyoka)"):
        assert f"not measured: {word}" in said
    assert {"gsl-rk8pd", "spherical-midpoint"} <= {row.method for row in found.rows} and "of the general integrators" in said


@pytest.mark.quick
def test_rows_of_general_integrators_are_told_apart_in_the_file(tmp_path):
    table = Cost([*rows(), Row("gsl-rk8pd", 0.1, 10, 1e-6, end_error=1e-7, energy=1e-8, seconds=2e-6, ns_step=5.0)], [], {"spec": "a", "run": "b", "energy": "1"})
    text = table.save(tmp_path / "a.csv").read_text()
    assert text.count("\npeer,gsl-rk8pd,") == 1 and text.count("\nsweep,") == 3
    assert load_cost(tmp_path / "a.csv").text() == text


@pytest.mark.quick
def test_ratios_are_those_of_the_times_and_tell_who_is_ahead():
    """Of N^-2 and N^-4 at a microsecond a step, beside one that takes 20 steps at 2 us for 1e-6, and never gets to 1e-12."""
    other = [Row("gsl-rk8pd", 0.1, n, 1.0 / n ** 2, end_error=e, seconds=2e-6 * n, ns_step=2e3) for n, e in ((10, 1e-4), (20, 1e-6))]
    cost = Cost([*rows("gauss-2", 2, (10, 1000)), *rows("gauss-4", 4, (10, 1000)), *other], [], {"energy": "1"})
    targets = (1e-4, 1e-6, 1e-12)
    own, beside = versus.best(cost, "end_error", targets)["symplectic"], versus.others(cost, "end_error", targets)["gsl-rk8pd"]
    assert [c.name for c in own] == ["gauss-4", "gauss-4", "gauss-4"] and math.isclose(own[1].seconds, 1e-6 * 10 ** 1.5)
    assert math.isclose(beside[1].seconds, 40e-6) and beside[2].name == ""
    said = versus.table(cost, "end_error", targets)
    assert "| GSL rk8pd | 2 / 2 / 2 | 1.3 / 1.3 / 1.3 | does not get there |" in said and versus.behind(cost, "end_error", targets) == []
    faster = [dataclasses.replace(r, seconds=r.seconds / 4) for r in other]
    assert versus.behind(Cost([*cost.rows[:4], *faster], [], cost.facts), "end_error", targets) == [
        "GSL rk8pd at 1e-04: 0.50 of the time of Gauss 4", "GSL rk8pd at 1e-06: 0.32 of the time of Gauss 4"]


@pytest.mark.quick
def test_an_error_that_is_small_by_chance_ends_no_sweep(monkeypatch):
    """That of 29 steps is a hundredth of its neighbours'."""
    spec = smidgen.load("free_rigid_body")
    case = Case(spec, settle(spec), 1.0)

    def made(case, name, steps, known, tolerance=None):
        error = max(float(steps) ** -6 * (0.01 if 27 < steps < 32 else 1), 1e-15)
        return Row(name, 1 / steps, steps, math.nan if tolerance is None else tolerance, end_error=error, seconds=1e-6 * steps)
    monkeypatch.setattr(sweep, "one", made)
    case.fewest = lambda turn: 10
    found = sweep.ladder(case, "gauss-6", Reference(case.w, 1e-17, ("a", "b")), 10.0)
    assert min(r.end_error for r in found) == 1e-15 and sum(r.end_error == 1e-15 for r in found) < 12


# The error of a run

@pytest.mark.parametrize("name, method, h, steps", [("free_rigid_body", "spherical-midpoint", 0.125, 80), ("irreversible_rigid_body", "gauss-4", 0.2, 51),
                                                    ("point_vortices", "spherical-midpoint", 0.05, 101), ("forced_rigid_body", "classical-midpoint", 0.05, 100),
                                                    ("irreversible_rigid_body", "gauss-10", 0.8, 30), ("irreversible_rigid_body", "dop853", 10.0, 1),
                                                    ("irreversible_rigid_body", "dop853", 0.5, 20), ("point_vortices", "dop853-projected", 1.0, 5)])
def test_the_estimate_is_the_error_within_a_factor(name, method, h, steps):
    """Of the last but one h is the step, of the others with step control the tolerance."""
    spec = smidgen.load(name)
    result = smidgen.run(spec, method=method, h=h, steps=steps, estimate=True, tolerance=1e-6 if method.startswith("dop853") else None)
    case = Case(spec, settle(spec), h * steps)
    error = case.distance(result.final, Witness(spec).flow(case.w, 0.0, [h * steps])[0])
    assert error / 1.5 < result.meta["end_error"] < 1.5 * error


@pytest.mark.quick
def test_the_estimate_changes_nothing_else(tmp_path):
    spec = smidgen.load("free_rigid_body")
    one, two = (smidgen.run(spec, steps=64, estimate=asked) for asked in (False, True))
    assert np.array_equal(one.final, two.final) and one.summary["t"] == two.summary["t"]
    assert one.meta["end_error"] is None and two.meta["end_error"] > 0
    smidgen.run(spec, steps=64, estimate=True, out=tmp_path / "a.npz")
    smidgen.repeat(tmp_path / "a.npz", tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert smidgen.load_result(tmp_path / "a.npz").meta["end_error"] == two.meta["end_error"]


@pytest.mark.quick
def test_the_estimate_knows_what_step_control_aims_at():
    text = (Path(__file__).parents[2] / "runtime" / "method" / "explicit" / "smg_dop853.h").read_text()
    said = re.search(r"defined\(SMG_LONG_DOUBLE\)\n#define SMG_TOLERANCE (\S+)\n.*\n.*\n#else\n#define SMG_TOLERANCE (\S+)", text)
    assert TOLERANCE == {"long double": float(said[1]), "double": float(said[2])}


@pytest.mark.quick
def test_no_estimate_where_there_is_none_to_be_had():
    spec = smidgen.load("free_rigid_body")
    assert smidgen.run(spec, steps=8, method="dop853", estimate=True).meta["end_error"] < 1e-11
    assert smidgen.run(spec, steps=1, estimate=True).meta["end_error"] > 0      # by two halves
    with pytest.raises(RunError) as failed:
        smidgen.run(smidgen.load("point_vortices"), h=50, steps=4, estimate=True)
    assert failed.value.result.meta["end_error"] is None


@pytest.mark.quick
def test_the_summary_tells_the_estimate(command):
    said = command("run", "free_rigid_body", "--steps", "80")
    assert "estimated error of the final state: 0.000" in said.stdout
    assert "estimated" not in command("run", "free_rigid_body", "--steps", "80", "--no-estimate").stdout
    assert "the final state is not resolved" in command("run", "irreversible_rigid_body", "--h", "2", "--steps", "100").stdout


# What is given up for speed

def test_a_fast_run_says_so_and_can_be_repeated(tmp_path):
    spec = smidgen.load("irreversible_rigid_body")
    path = tmp_path / "a.npz"
    result = smidgen.run(spec, steps=100, fast=True, out=path)
    assert result.meta["fast"] and "-ffp-contract=fast" in result.meta["flags"] and "-march=native" in result.meta["flags"]
    smidgen.repeat(path, tmp_path / "b.npz")
    assert path.read_bytes() == (tmp_path / "b.npz").read_bytes()
    plain = smidgen.run(spec, steps=100)
    assert not plain.meta["fast"] and np.abs(plain.final - result.final).max() < 1e-13
    with pytest.raises(UsageError, match="extended"):
        smidgen.build(spec, features=("extended",), fast=True)


# When the compiler has been paid for

@pytest.mark.quick
def test_steps_until_the_compiler_is_paid_for():
    """2 s for a run of 100 steps that takes 1 ms where another takes 5 ms: 500 runs."""
    row, other = (Row("gauss-4", 0.1, 100, seconds=s, compiled=c) for s, c in ((1e-3, 2.0), (5e-3, 0.5)))
    assert steps_until_even(row, other, True) == 50000 and steps_until_even(row, other, False) == 37500
    assert steps_until_even(other, row, True) == math.inf and steps_until_even(dataclasses.replace(row, compiled=0.0), other, True) == 0


@pytest.mark.quick
def test_smaller_steps_are_chosen_where_twice_as_many_take_less_time(monkeypatch):
    """Where h is so large that steps are solved by following their branch."""
    seconds = {10: 130e-6, 20: 23e-6, 40: 7e-6, 80: 12e-6}
    rows = {n: Row("spherical-midpoint", 50.0 / n, n, energy=1e-16, iterations=3.0, seconds=t) for n, t in seconds.items()}
    monkeypatch.setattr(choice, "one", lambda case, name, steps, known: rows[steps])
    assert choice.quicker(None, rows[10], None, {"energy": 1e-6}) is rows[40]
    rows[20] = dataclasses.replace(rows[20], energy=1.0)        # less time, and not good enough
    assert choice.quicker(None, rows[10], None, {"energy": 1e-6}) is rows[10]
    explicit = dataclasses.replace(rows[10], iterations=0.0)
    assert choice.quicker(None, explicit, None, {"energy": 1e-6}) is explicit


EXPLICIT = ("cf4", "sublattice-rotations-4")


def test_explicit_steps_have_no_tolerance_to_end_at():
    """A tolerance would change no bit of them: they are timed once, and compared with others."""
    spec = smidgen.load("heisenberg_chain")
    pick = smidgen.choose(spec, error=1e-6, time=2, parameters={"n": 8}, methods=(*EXPLICIT, "gauss-4"))
    found = [(row.method, row.tolerance == row.tolerance) for row in (pick.row, *pick.others)]
    assert {name for name, _ in found} & set(EXPLICIT) and len(set(found)) == len(found)
    assert not any(loose for name, loose in found if name in EXPLICIT)
    case, known = Case(spec, settle(spec, parameters={"n": 8}), 2.0), Reference(np.zeros((8, 3)), 0.0, ())
    swept = {name: sweep.loosened(case, sweep.one(case, name, 20, known), known, 1e-6) for name in candidates(case, (*EXPLICIT, "gauss-4"))}
    assert [name for name, rows in swept.items() if rows] == ["gauss-4"]


@pytest.mark.quick
def test_a_choice_takes_the_largest_tolerance_that_is_good_enough(monkeypatch):
    """Of those that spare sweeps; it asks for no larger one behind a failure."""
    tried = []

    def loosened(case, row, known, tolerance):
        tried.append(tolerance)
        return [] if tolerance < 1e-9 else [tolerance]
    monkeypatch.setattr(choice, "loosened", loosened)
    for good, expected, asked in ((1.0, 6e-8, 3), (1e-8, 6e-9, 3), (1e-12, None, 2)):
        tried.clear()
        monkeypatch.setattr(choice, "enough", lambda found, _, good=good: found <= good)
        found = choice.with_tolerance(None, SimpleNamespace(steps=100), None, {"end_error": 1e-6})
        assert [round(x, 12) for x in found] == ([] if expected is None else [expected]) and len(tried) == asked


def test_a_choice_tells_when_it_is_ahead_of_a_general_integrator():
    spec = smidgen.load("free_rigid_body")
    pick = smidgen.choose(spec, error=1e-6, time=10, methods=("gauss-4", "gauss-6"))
    assert pick.general.method in GENERAL and pick.general.end_error <= 1e-6
    slow = dataclasses.replace(pick, row=dataclasses.replace(pick.row, compiled=1.0))
    assert f"compared with {PEERS[pick.general.method].label}, this pays off after {slow.even:.2g} steps" in str(slow)
    assert "it is already compiled, so it is faster from the first step than" in str(dataclasses.replace(pick, row=dataclasses.replace(pick.row, compiled=0.0)))
