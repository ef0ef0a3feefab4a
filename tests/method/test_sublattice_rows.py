"""Sublattice rotations on lattices, sites in lanes (runtime/method/explicit/smg_sublattice_rows.h): the bits of the steps from site to site."""
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError
from smidgen.resources import include_flags
from support.going_on import one_by_one, restored
from support.strict import COMPILERS, MODES, compile_all
from support.widths import bits, by_witness, same_by_clang, same_in_lanes
from support.widths import built as built_with
from test_rows import DM, EXCHANGE, FOUR, HONEY, LADDER, SKEW, lattice

METHOD = "sublattice-rotations"
LINEAR = """[effects.field]
over = "site(i) of w"
energy = "0.3*w[i].x - 0.2*w[i].z"
"""
BOTH = EXCHANGE + LINEAR
GROWING = EXCHANGE.replace("-0.7*", "-(0.5 + 0.3*t)*") + LINEAR.replace("0.3*", "0.3*t^2*")      # of no bound that holds at all times
SPECS = {
    **{f"ring of {n}": lattice("ring", "chain(n, periodic)", n, "n", BOTH + DM) for n in (4, 18, 602)},
    **{f"open chain of {n}": lattice("open_chain", "chain(n, open)", n, "n", BOTH) for n in (3, 35)},
    "square": lattice("square", "square(n, 8, periodic)", 6, "8*n", BOTH),
    "odd square": lattice("odd_square", "square(n, 5, open)", 9, "5*n", EXCHANGE + DM),
    "cubic": lattice("cubic", "cubic(n, n, 4, periodic)", 6, "4*n*n", BOTH),
    "open cubic": lattice("open_cubic", "cubic(n, 4, 3, open)", 18, "12*n", BOTH),
    "honeycomb": lattice("honeycomb", "honey.all", 5, "6*n", BOTH, lattice=HONEY),
    "three colours": lattice("skew", "skew.near", 13, "4*n", EXCHANGE + DM, SKEW),
    "ladder": lattice("ladder", "rungs.all", 7, "2*n", BOTH, lattice=LADDER),
    "four dimensions": lattice("four", "four.near", 4, "24*n", EXCHANGE + DM, FOUR),
    "pieces": lattice("pieces", "square(n, 30, periodic)", 20, "30*n", EXCHANGE),
    "growing": lattice("growing", "square(n, 8, periodic)", 6, "8*n", GROWING),
    "other spheres": lattice("spheres", "chain(n, periodic)", 20, "n", BOTH, more=", radius = 1.7, kappa = -0.6"),
}
SOME = ("ring of 18", "growing", "odd square", "honeycomb", "three colours", "other spheres")


def built(monkeypatch, spec, method=METHOD, **how):
    return built_with(monkeypatch, spec, method, **how)


def in_rows(spec, **how) -> bool:
    return "SMG_ROW_TURNS" in generate(spec, method=METHOD, **how)[f"{spec.name}.c"]


@pytest.mark.parametrize("name, method", [pytest.param(n, m, marks=[] if n in SOME and m == METHOD or n == "ring of 18" else pytest.mark.long)
                                          for n in SPECS for m in (METHOD, f"{METHOD}-4")])
def test_the_bits_are_those_from_site_to_site(monkeypatch, name, method):
    """A build for ensembles goes from site to site; and the witness knows no rows."""
    spec = SPECS[name]
    assert in_rows(spec) and not in_rows(spec, features=("ensemble",))
    model = built(monkeypatch, spec, method=method).start("random", h=0.2)
    w = model.w.copy()
    assert np.array_equal(model.steps(8).save(), bits(built(monkeypatch, spec, method=method, features=("ensemble",))))
    assert np.abs(model.w - by_witness(spec, w, method, 8)).max() <= 2e-14 * np.abs(w).max()


@pytest.mark.parametrize("name, widths", [("ring of 18", (2, 4, 8)), ("honeycomb", (2,)), *(pytest.param(n, (2, 4, 8), marks=pytest.mark.long) for n in SPECS)])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, name, widths):
    assert same_in_lanes(lambda lanes: built(monkeypatch, SPECS[name], lanes=lanes), widths)


def test_a_field_beyond_all_numbers_ends_a_call():
    """In the state after the last step whose turns are finite."""
    spec = lattice("beyond", "square(n, 8, periodic)", 6, "8*n", EXCHANGE + LINEAR.replace("0.3*", "exp(300*t)*"))
    assert in_rows(spec)
    together, alone = (smidgen.build(spec, method=METHOD).start("random", h=0.1) for _ in range(2))
    with pytest.raises(RunError, match="not finite|infinite"):
        together.steps(9)
    taken = together.count
    assert 2 < taken < 9 and np.isfinite(together.w).all()
    assert np.array_equal(alone.steps(taken).save(), together.save())


def test_it_goes_on_by_rows_with_other_parameters():
    """Its bounds and arrays begin anew."""
    rows, sites = (smidgen.build(SPECS["growing"], method=METHOD, features=features).start("random", h=0.2).steps(3) for features in ((), ("ensemble",)))
    assert np.array_equal(*(one.set_parameters({}).steps(3).save() for one in (rows, sites)))


LIEB = """[lattices.lieb]
size = ["n", 4]
sites = 3
boundary = "open"
bonds.near = [{ from = 0, to = 1, offset = [0, 0] }, { from = 1, to = 0, offset = [1, 0] }, { from = 0, to = 2, offset = [0, 0] }, { from = 2, to = 0, offset = [0, 1] }]
"""


def test_colours_have_as_many_sites_as_others():
    """Two of three places have the same colour, though no bond reaches far."""
    spec = lattice("lieb", "lieb.near", 8, "12*n", EXCHANGE, LIEB)
    assert generate(spec, "sublattice-rotations").notes["reason"].endswith("site by site, because its colours have different numbers of sites")


@pytest.mark.skipif("clang" not in COMPILERS, reason="no clang")
def test_another_compiler_has_them_too(monkeypatch):
    assert same_by_clang(lambda **how: built(monkeypatch, SPECS["three colours"], **how))


@pytest.mark.parametrize("n", [5, 17])
def test_a_colour_that_meets_itself_goes_from_site_to_site(monkeypatch, n):
    """A ring of an odd number: every site is a colour of its own, as the witness has it."""
    spec = lattice("ring", "chain(n, periodic)", n, "n", BOTH)
    model = built(monkeypatch, spec).start("random", h=0.2)
    w = model.w.copy()
    assert np.abs(model.steps(6).w - by_witness(spec, w, METHOD, 6)).max() <= 2e-14


@pytest.mark.parametrize("name", ["cubic", "growing"])
def test_restored_it_goes_on_with_the_same_bits(monkeypatch, name):
    model = built(monkeypatch, SPECS[name])
    assert restored(model) and one_by_one(model)


def test_a_start_is_saved_and_restored(monkeypatch):
    model = built(monkeypatch, SPECS["ring of 18"]).start("random", h=0.2)
    saved, wanted = model.save(), model.steps(4).save()
    model.restore(saved)
    assert np.array_equal(model.save(), saved) and np.array_equal(model.steps(4).save(), wanted)


STEPS = """
#include "ring.c"
#include <stdlib.h>
#include <string.h>
int main(void) {
  smg_params p;
  smg_model model;
  ring_state s[2];
  double w[54], *saved[2];
  ring_defaults(&p);
  if (ring_model_init(&model, &p) != SMG_OK) return 1;
  for (int k = 0; k < 54; ++k) w[k] = k % 3 == 0 ? 0.6 : k % 3 == 1 + k / 3 % 2 ? 0.8 : 0;
  for (int k = 0; k < 2; ++k) {
    saved[k] = malloc(ring_savesize(&model) * sizeof(double));
    if (ring_init(s + k, &model, malloc(ring_memsize(&model)), w, 0, 0.1) != SMG_OK) return 1;
  }
  if (ring_step(s) != SMG_OK || ring_step(s) != SMG_OK || ring_steps(s + 1, 2) != SMG_OK) return 2;
  for (int k = 0; k < 2; ++k) ring_save(s + k, saved[k]);
  return memcmp(saved[0], saved[1], ring_savesize(&model) * sizeof(double)) ? 3 : 0;
}
"""


def test_one_step_at_a_time_in_c(tmp_path):
    for file, text in generate(SPECS["ring of 18"], method=METHOD).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "main.c").write_text(STEPS)
    subprocess.run(["gcc", "-std=c11", "-O1", "-ffp-contract=off", "-Wno-psabi", "-I.", *include_flags(), "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"]).returncode == 0


def test_threads_have_the_same_bits(monkeypatch):
    monkeypatch.setenv("OMP_WAIT_POLICY", "passive")
    monkeypatch.setenv("GOMP_SPINCOUNT", "0")
    spec = SPECS["pieces"]
    wanted = bits(built(monkeypatch, spec))
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_LANES=4 -DSMG_SHARE=32")
    assert np.array_equal(bits(smidgen.build(spec, method=METHOD, threads=2)), wanted)


@pytest.mark.usefixtures("optimised")
def test_energy_and_lengths_are_kept(monkeypatch):
    """To round-off, over 1e5 steps: nothing drifts."""
    model = built(monkeypatch, SPECS["cubic"]).start("random", h=0.2)
    first, w = dict(zip(model.columns, model.values())), model.w.copy()
    last = dict(zip(model.steps(100_000).columns, model.values()))
    assert np.abs(np.linalg.norm(model.w, axis=1) / np.linalg.norm(w, axis=1) - 1).max() < 4 * 2**-52
    assert abs(last["energy"] - first["energy"]) < 1e-12 * len(w)


def test_fields_beyond_all_numbers_are_refused(monkeypatch):
    """They go from site to site, where the step that has no numbers is refused, and the state stays."""
    strong = lattice("strong", "chain(n, periodic)", 18, "n", EXCHANGE + '[effects.field]\nover = "site(i) of w"\nenergy = "1e150*w[i].z"\n', more=", kappa = 1e-20")
    model = built(monkeypatch, strong).start("random", h=0.2)
    before = model.w.copy()
    with pytest.raises(RunError, match="finite|number"):
        model.steps(3)
    assert np.array_equal(model.w, before) and model.count == 0


@pytest.mark.parametrize("compiler, mode", MODES)
@pytest.mark.parametrize("lanes", [1, 2])
def test_clean_c(tmp_path, compiler, mode, lanes):
    files = generate(SPECS["three colours"], method=METHOD)
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert not compile_all(tmp_path, ["skew.c"], compiler, "-Wno-psabi", f"-DSMG_LANES={lanes}", how=mode)
