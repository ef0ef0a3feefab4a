"""Compositions of the spherical midpoint on lattices by rows: each stage solves its step at its time, and a stage that fails leaves no trace."""
import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from support.going_on import one_by_one, restored
from support.strict import MODES, compile_all
from support.widths import same_in_lanes
from test_rows import DM, EXCHANGE, FIELD, SKEW, SPECS as QUADRATIC, lattice
from test_rows_any_formula import SPECS as ANY
from test_rows_by_site import BLOCKS, SOME, close
from test_rows_in_time import SPECS as IN_TIME, by_rows

FOUR = "spherical-midpoint-4"
SPECS = {
    "odd ring": QUADRATIC["ring of 17"], "second neighbours": QUADRATIC["further neighbours of 12"], "open cubic": QUADRATIC["open cubic"], "odd cubic": QUADRATIC["odd cubic"],
    "cubic anisotropy": ANY["cubic"], "any formula": ANY["blocks"], "in time": IN_TIME["open square"], "damped": IN_TIME["damped"], "by site": SOME, "blocks": BLOCKS,
    "other spheres": QUADRATIC["other spheres"],
}
CASES = [(name, FOUR) for name in SPECS] + [("odd ring", f"spherical-midpoint-{scheme}") for scheme in ("6", "8", "10", "ss13", "kl9a", "kl17a")]
QUICK = [("odd ring", FOUR), ("in time", FOUR), ("any formula", FOUR), ("odd ring", "spherical-midpoint-6")]
PASSES = {0: 18, 1: 15, 5: 15}
SHARED = lattice("shared", "square(n, 6, periodic)", 8, "6*n", EXCHANGE + DM + FIELD)


@pytest.mark.parametrize("name, method", [pytest.param(*case, marks=() if case in QUICK else pytest.mark.long) for case in CASES])
def test_every_stage_solves_its_step(name, method):
    """Against the witness, which knows no rows, from a time that is not 0."""
    spec = SPECS[name]
    assert by_rows(spec, method) and close(spec, method, steps=4) <= 3e-14


@pytest.mark.parametrize("name, widths", [("by site", (4,)), pytest.param("odd ring", (2, 4, 8), marks=pytest.mark.long), pytest.param("blocks", (2, 4, 8), marks=pytest.mark.long)])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, name, widths):
    def built(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SPECS[name], method=FOUR)
    assert same_in_lanes(built, widths)


def test_threads_have_the_same_bits(monkeypatch):
    monkeypatch.setenv("OMP_WAIT_POLICY", "passive")
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    assert np.array_equal(*(smidgen.build(SHARED, method=FOUR, threads=n).start("random", h=0.2).steps(7).save() for n in (1, 2)))


def test_wavefronts_have_the_same_bits(monkeypatch):
    """A small lattice that is taken for a large one."""
    found = []
    for flags in ("", " -DSMG_WAVE_FROM=0 -DSMG_WAVE_BLOCK=8 -DSMG_WAVE_STAGES=2"):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi{flags}")
        found.append(smidgen.build(SPECS["in time"], method=FOUR).start("random", h=0.1).steps(9).save())
    assert np.array_equal(*found)


def test_one_by_one_at_once_or_restored():
    model = smidgen.build(SPECS["in time"], method=FOUR)
    assert one_by_one(model) and restored(model)


@pytest.mark.parametrize("steps", [0, 1, 5])
def test_a_stage_that_fails_leaves_the_state(monkeypatch, steps):
    """With so few passes that only the largest stage, the third, does not settle: the stages before it are undone, their increments forgotten."""
    spec = SPECS["odd ring"]
    saved = smidgen.build(spec, method=FOUR).start("random", h=0.2).steps(steps).save()
    monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_ROW_PASSES={PASSES[steps]}")
    model = smidgen.build(spec, method=FOUR).start("random", h=0.2).restore(saved)
    w = model.w.copy()
    with pytest.raises(smidgen.RunError) as caught:
        model.steps(3)
    assert caught.value.status == 1 and np.array_equal(model.save(), saved) and np.array_equal(model.state(), w)


@pytest.mark.parametrize("compiler, mode", MODES)
def test_clean_c(tmp_path, compiler, mode):
    spec = lattice("skew", "skew.near", 13, "4*n", EXCHANGE + DM, SKEW)
    for file, text in generate(spec, method=FOUR, amalgamate=True).items():
        (tmp_path / file).write_text(text)
    assert not compile_all(tmp_path, [f"{spec.name}.c"], compiler, "-Wno-psabi", how=mode)
