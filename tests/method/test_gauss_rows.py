"""Gauss collocation on lattices, sites in lanes (runtime/method/gauss/smg_gauss_rows.h): the step that the equation has, with the same bits."""

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError
from support.going_on import restored
from support.strict import COMPILERS, MODES, compile_all
from support.widths import bits, by_witness, same_by_clang, same_in_lanes
from support.widths import built as built_with
from test_rows import DM, EXCHANGE, FIELD, SPECS as QUADRATIC, WIDTHS, lattice

IN_TIME = """[effects.field]
over = "site(i) of w"
energy = "sin(2*t)*w[i].x - 0.3*cos(t)*w[i].z + 0.2*w[i].z^2"
"""
SPECS = {**QUADRATIC, "in time": lattice("in_time", "square(n, 7, periodic)", 6, "7*n", EXCHANGE + IN_TIME)}
SOME = ("ring of 5", "ring of 17", "odd square", "honeycomb", "three colours", "in time")


def built(monkeypatch, spec, order=6, **how):
    return built_with(monkeypatch, spec, f"gauss-{order}", **how)


@pytest.mark.parametrize("name", [*SOME, "open chain of 3", "other spheres", *(pytest.param(n, marks=pytest.mark.long) for n in SPECS)])
def test_rows_solve_the_step(monkeypatch, name):
    """Against the witness, which knows no rows."""
    spec = SPECS[name]
    assert "SMG_ROW_STAGES" in generate(spec, method="gauss-6")[f"{spec.name}.c"]
    model = built(monkeypatch, spec).start("random", h=0.2)
    w = model.w.copy()
    assert np.abs(model.steps(4).w - by_witness(spec, w, "gauss-6", 4)).max() <= 2e-14 * np.abs(w).max()


@pytest.mark.parametrize("order", range(2, 17, 2))
def test_every_order_is_that_of_the_witness(monkeypatch, order):
    spec = SPECS["ring of 17"]
    model = built(monkeypatch, spec, order).start("random", h=0.25)
    w = model.w.copy()
    assert np.abs(model.steps(3).w - by_witness(spec, w, f"gauss-{order}", 3, h=0.25)).max() <= 2e-14


@pytest.mark.parametrize("radius", ["1e100", "1e140"])
def test_fields_beyond_all_numbers_are_refused(monkeypatch, radius):
    model = built(monkeypatch, lattice("strong", "chain(n, periodic)", 18, "n", EXCHANGE.replace("-0.7", "1e150"), more=f", radius = {radius}")).start("random", h=0.2)
    before = model.w.copy()
    with pytest.raises(RunError):
        model.step()
    assert np.array_equal(model.w, before) and model.count == 0


@pytest.mark.parametrize("order", [4, 8])
def test_order_in_extended_precision(monkeypatch, order):
    """Of steps against those half as long, and of these against half of them again."""
    model, ends = built(monkeypatch, SPECS["in time"], order, real="long double"), []
    for n in (16, 32, 64):
        ends.append(model.start("random", h=1 / n).steps(n).w.copy())
    ratio = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max()
    assert abs(np.log2(ratio) - order) < 0.1


@pytest.mark.parametrize("name, widths", [*((n, WIDTHS.get(n, (4,))) for n in SOME), *(pytest.param(n, (2, 4, 8), marks=pytest.mark.long) for n in SPECS)])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, name, widths):
    assert same_in_lanes(lambda lanes: built(monkeypatch, SPECS[name], lanes=lanes), widths)


@pytest.mark.skipif("clang" not in COMPILERS, reason="no clang")
def test_another_compiler_has_them_too(monkeypatch):
    assert same_by_clang(lambda **how: built(monkeypatch, SPECS["ring of 33"], **how))


@pytest.mark.parametrize("name", ["ring of 17", "honeycomb"])
def test_restored_it_goes_on_with_the_same_bits(monkeypatch, name):
    model = built(monkeypatch, SPECS[name])
    assert restored(model)


@pytest.mark.parametrize("field", [40.0, -40.0])
def test_turns_of_more_than_half_a_circle_are_refused_and_leave_the_state(monkeypatch, field):
    """h times the field is 8, of either sign: no start is near, and the steps after the one that failed are not taken."""
    strong = f'[effects.field]\nover = "site(i) of w"\nenergy = "{field}*w[i].z"\n'
    model = built(monkeypatch, lattice("strong", "chain(n, periodic)", 17, "n", EXCHANGE + strong))
    w = np.array([0.0, 0.0, 1.0]) + 0.2 * np.random.default_rng(1).normal(size=(17, 3))
    before = model.start(w / np.linalg.norm(w, axis=1)[:, None], h=0.2).save()
    with pytest.raises(RunError, match="did not converge"):
        model.steps(3)
    assert np.array_equal(model.save(), before)


def test_one_by_one_or_at_once(monkeypatch):
    model = built(monkeypatch, SPECS["odd cubic"])
    whole = bits(model)
    model.start("random", h=0.2)
    for _ in range(8):
        model.steps(1)
    assert np.array_equal(model.save(), whole)


def test_a_refused_step_leaves_all_as_it_was(monkeypatch):
    """One site in a field that no iteration of this h solves: it is named, and the state goes on as if nothing had been."""
    strong = EXCHANGE + FIELD.replace("0.3*w[i].x", "(0.3 + 60*floor(t + 0.5))*w[i].x")
    model = built(monkeypatch, lattice("strong", "chain(n, periodic)", 12, "n", strong))
    model.start("random", h=0.1).steps(5)
    before = model.save()
    with pytest.raises(RunError, match="at site"):
        model.steps(1)
    assert np.array_equal(model.save(), before)


def test_what_is_kept(monkeypatch):
    """Lengths and total momentum to round-off, energy without a drift."""
    spec = lattice("ring", "chain(n, periodic)", 100, "n", EXCHANGE)
    model = built(monkeypatch, spec, 8).start("random", h=0.25)
    first, w = dict(zip(model.columns, model.values())), model.w.copy()
    last = dict(zip(model.steps(2000).columns, model.values()))
    assert np.abs(np.linalg.norm(model.w, axis=1) / np.linalg.norm(w, axis=1) - 1).max() < 60 * 2**-52
    assert np.abs(model.w.sum(0) - w.sum(0)).max() < 1e-13
    assert abs(last["energy"] - first["energy"]) < 1e-5


def test_a_tolerance_is_kept(monkeypatch):
    exact = built(monkeypatch, SPECS["cubic"], 8).start("random", h=0.2).steps(6)
    errors, iterations = [], [exact.report()["iterations"]]
    w = exact.w.copy()
    for tolerance in (1e-10, 1e-6):
        model = built(monkeypatch, SPECS["cubic"], 8).start("random", h=0.2, tolerance=tolerance).steps(6)
        errors.append(np.abs(model.w - w).max() / tolerance)
        iterations.append(model.report()["iterations"])
    assert 0 < max(errors) < 6 and iterations[0] > iterations[1] > iterations[2]


def test_few_sweeps_on_the_smooth_chain():
    """With what a spin turns by itself, and relaxation for it: six sweeps where 18 were needed without, 7 with the first alone."""
    model = smidgen.build(smidgen.load("heisenberg_chain"), method="gauss-8").start("smooth", h=1.0, tolerance=7e-12).steps(10)
    assert model.report()["iterations"] <= 6


def test_what_rows_are_not_for():
    spec = lattice("general", "chain(n, periodic)", 16, "n", EXCHANGE + FIELD.replace("0.4*w[i].z^2", "max(w[i].z, 0.1)"))
    assert "SMG_ROW_STAGES" not in generate(spec, method="gauss-6")["general.c"]


@pytest.mark.parametrize("lanes", [1, 8])
@pytest.mark.parametrize("compiler, mode", MODES)
def test_clean_c(tmp_path, compiler, mode, lanes):
    spec = lattice("skew", "square(n, 5, open)", 9, "5*n", EXCHANGE + DM)
    for file, text in generate(spec, amalgamate=True, method="gauss-6").items():
        (tmp_path / file).write_text(text)
    assert not compile_all(tmp_path, [f"{spec.name}.c"], compiler, "-Wno-psabi", f"-DSMG_LANES={lanes}", how=mode)
