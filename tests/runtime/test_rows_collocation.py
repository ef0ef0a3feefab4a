"""Gauss collocation by rows of lattices whose sites do more than precess in their field, or do not move."""
import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from support.going_on import one_by_one, restored
from support.strict import MODES, compile_all
from support.widths import same_in_lanes
from test_rows import DM, EXCHANGE, lattice
from test_rows_by_site import KINDS, PLACES, drawn
from test_rows_held import ABSENT, PINNED, held
from test_rows_in_time import by_rows
from test_rows_laws import LAWS

QUICK = (("three colours", "all", "gauss-4"), ("blocks", "warm", "gauss-6"))
SOME = drawn("three colours", KINDS["in time"], bonds=EXCHANGE + DM + LAWS["all"])


def close(spec, method, steps=3, **more) -> float:
    """The distance from the witness, which knows no rows."""
    model = smidgen.build(spec, method=method).start("random", h=0.08, t0=0.37, **more)
    w = model.w.copy()
    return np.abs(model.steps(steps).w - Witness(spec, **more).steps(w, 0.37, 0.08, steps, method)[-1]).max()


@pytest.mark.parametrize("place, kind, method", [pytest.param(*one, marks=() if one in QUICK else pytest.mark.long) for one in
                                                 [*QUICK, *(("odd square", k, "gauss-4") for k in LAWS), *((p, "all", "gauss-8") for p in PLACES)]])
def test_rows_solve_the_step(place, kind, method):
    spec = drawn(place, KINDS["in time"], bonds=EXCHANGE + DM + LAWS[kind])
    assert by_rows(spec, method) and close(spec, method, **({"seed": 5} if kind == "warm" else {})) <= 2e-14


@pytest.mark.parametrize("radius", [5, pytest.param(1e-3, marks=pytest.mark.long)])
def test_sites_that_are_not_there_have_no_length(radius):
    """1/|z|^2 of theirs is no number."""
    spec = lattice("sized", "square(n, 5, open)", 9, "5*n", EXCHANGE + ABSENT + PINNED, more=f", radius = {radius}")
    model, still = smidgen.build(spec, method="gauss-4").start("random", h=0.08 / radius), Witness(spec).still
    w = model.w.copy()
    end = Witness(spec).steps(w, 0.0, 0.08 / radius, 3, "gauss-4")[-1]
    assert by_rows(spec, "gauss-4") and np.abs(model.steps(3).w - end).max() <= 2e-14 * radius and np.array_equal(model.w[still], w[still])


def test_a_torque_where_there_is_no_field():
    """What tells when sweeps have settled is how strongly sites are turned: with the strength of their fields it would take 8 sweeps."""
    spec = lattice("weak", "chain(n, periodic)", 40, "n", EXCHANGE.replace("0.7", "7e-18") + LAWS["torque"])
    model = smidgen.build(spec, method="gauss-6").start("random", h=0.08).steps(5)
    assert by_rows(spec, "gauss-6") and model.report()["iterations"] <= 6
    assert close(spec, "gauss-6") <= 2e-14


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SOME, method="gauss-4")
    assert same_in_lanes(built, (2, 4, 8))


@pytest.mark.parametrize("compiler, mode", MODES)
def test_clean_c(tmp_path, compiler, mode):
    spec = held("odd square", "warm")
    for file, text in generate(spec, amalgamate=True, method="gauss-4").items():
        (tmp_path / file).write_text(text)
    assert not compile_all(tmp_path, [f"{spec.name}.c"], compiler, "-Wno-psabi", how=mode)


@pytest.mark.parametrize("spec", [SOME, pytest.param(held("odd square", "both"), marks=pytest.mark.long)], ids=["all", "held"])
def test_restored_it_goes_on(spec):
    model = smidgen.build(spec, method="gauss-4")
    assert restored(model) and one_by_one(model)
