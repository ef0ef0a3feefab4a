"""Pair rotations on lattices, sites in lanes (runtime/method/explicit/smg_pair_rows.h): the bits of the steps from bond to bond."""
import numpy as np
import pytest
from smidgen.check.witness import Witness, splittings
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError
from support.going_on import one_by_one, restored
from support.strict import COMPILERS, MODES, compile_all
from support.widths import bits, by_witness, same_by_clang, same_in_lanes
from support.widths import built as built_with
from test_rows import EXCHANGE, FOUR, HONEY, LADDER, SKEW, lattice

METHOD = "pair-rotations"
CUBE = """[effects.cube]
over = "bond(i, j) of {over}"
energy = "0.2*dot(w[j], w[i])^3"
"""
BOTH = EXCHANGE + CUBE
BACK = """[lattices.back]
size = ["n", 6, 5]
boundary = ["periodic", "periodic", "open"]
bonds.all = [{ from = 0, to = 0, offset = [1, 0, -1] }, { from = 0, to = 0, offset = [1, 0, 0] }, { from = 0, to = 0, offset = [0, 1, 0] }, { from = 0, to = 0, offset = [0, 0, 2] }]
"""
SPECS = {
    **{f"ring of {n}": lattice("ring", "chain(n, periodic)", n, "n", BOTH) for n in (2, 4, 18, 602)},
    **{f"open chain of {n}": lattice("open_chain", "chain(n, open)", n, "n", BOTH) for n in (2, 3, 35)},
    "square": lattice("square", "square(n, 8, periodic)", 6, "8*n", BOTH),
    "odd square": lattice("odd_square", "square(n, 5, open)", 9, "5*n", EXCHANGE),
    "cubic": lattice("cubic", "cubic(n, n, 4, periodic)", 6, "4*n*n", BOTH),
    "two layers": lattice("layers", "cubic(n, 4, 2, periodic)", 18, "8*n", EXCHANGE),
    "open cubic": lattice("open_cubic", "cubic(n, 4, 3, open)", 18, "12*n", EXCHANGE),
    "far layers": lattice("far", "back.all", 6, "30*n", BOTH, lattice=BACK),
    "honeycomb": lattice("honeycomb", "honey.all", 5, "6*n", BOTH, lattice=HONEY),
    "three colours": lattice("skew", "skew.near", 13, "4*n", EXCHANGE, SKEW),
    "ladder": lattice("ladder", "rungs.all", 7, "2*n", BOTH, lattice=LADDER),
    "four dimensions": lattice("four", "four.near", 4, "24*n", EXCHANGE, FOUR),
    "other spheres": lattice("spheres", "chain(n, periodic)", 20, "n", EXCHANGE, more=", radius = 1.7, kappa = -0.6"),
}
SOME = ("ring of 18", "cubic", "odd square", "far layers", "honeycomb", "three colours", "other spheres")


def built(monkeypatch, spec, method=METHOD, **how):
    return built_with(monkeypatch, spec, method, **how)


def in_rows(spec, **how) -> bool:
    return "SMG_ROW_CLASSES" in generate(spec, method=METHOD, **how)[f"{spec.name}.c"]


@pytest.mark.parametrize("name, method", [pytest.param(n, m, marks=[] if n in SOME and m == METHOD or n == "ring of 18" else pytest.mark.long)
                                          for n in SPECS for m in (METHOD, f"{METHOD}-4")])
def test_the_bits_are_those_from_bond_to_bond(monkeypatch, name, method):
    """A build for ensembles goes from bond to bond; and the witness knows no rows."""
    spec = SPECS[name]
    assert in_rows(spec) and not in_rows(spec, features=("ensemble",))
    model = built(monkeypatch, spec, method=method).start("random", h=0.2)
    w = model.w.copy()
    assert np.array_equal(model.steps(6).save(), bits(built(monkeypatch, spec, method=method, features=("ensemble",)), 6))
    assert np.abs(model.w - by_witness(spec, w, method, 6)).max() <= 2e-14 * np.abs(w).max()


@pytest.mark.parametrize("name, widths", [("ring of 18", (2, 8)), ("honeycomb", (2,)), *(pytest.param(n, (2, 4, 8), marks=pytest.mark.long) for n in SPECS)])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, name, widths):
    assert same_in_lanes(lambda lanes: built(monkeypatch, SPECS[name], lanes=lanes), widths)


@pytest.mark.skipif("clang" not in COMPILERS, reason="no clang")
def test_another_compiler_has_them_too(monkeypatch):
    assert same_by_clang(lambda **how: built(monkeypatch, SPECS["three colours"], **how))


@pytest.mark.parametrize("n", [5, 17])
def test_a_class_that_meets_itself_goes_bond_after_bond(monkeypatch, n):
    """A ring of an odd number, as the witness has it."""
    spec = lattice("ring", "chain(n, periodic)", n, "n", EXCHANGE)
    model = built(monkeypatch, spec).start("random", h=0.2)
    w = model.w.copy()
    assert splittings.classes(Witness(spec), list(splittings.bonds(Witness(spec)))) is None
    assert np.abs(model.steps(6).w - by_witness(spec, w, METHOD, 6)).max() <= 2e-14


def test_the_witness_finds_classes_of_which_no_two_bonds_meet():
    """As many as bonds of the cell times colours; and it refuses one that is none."""
    one = Witness(SPECS["cubic"])
    found = list(splittings.bonds(one))
    groups = splittings.classes(one, found)
    assert len(groups) == 2 * 12 - 1 and [part for _, part in groups].count(1.0) == 1
    assert sum(len(group) for group, _ in groups) == 2 * len(found) - len(groups[11][0])
    with pytest.raises(RunError, match="two bonds of a class share a site"):
        splittings.apart(found)


def test_restored_it_goes_on_with_the_same_bits(monkeypatch):
    model = built(monkeypatch, SPECS["cubic"])
    assert restored(model) and one_by_one(model)


@pytest.mark.usefixtures("optimised")
def test_momentum_and_lengths_are_kept(monkeypatch):
    """To round-off, over 1e4 steps: a turn keeps the sum of two spins to all digits, and lengths, known to an ulp, are brought back by a sixteenth."""
    model = built(monkeypatch, SPECS["cubic"]).start("random", h=0.05)
    w = model.w.copy()
    model.steps(10_000)
    assert np.abs(model.w.sum(axis=0) - w.sum(axis=0)).max() < 3e-14
    assert np.abs(np.linalg.norm(model.w, axis=1) / np.linalg.norm(w, axis=1) - 1).max() < 4 * 2**-52


@pytest.mark.parametrize("J, more", [("1e150", ", kappa = 1e-20"), ("1.0", ", radius = 1e90")])
def test_numbers_beyond_all_bounds_are_refused(monkeypatch, J, more):
    """They go from bond to bond, where the step that has no numbers is refused, and the state stays."""
    strong = lattice("strong", "chain(n, periodic)", 18, "n", EXCHANGE.replace("-0.7", J).replace("[j])", "[j])^3"), more=more)
    model = built(monkeypatch, strong).start("random", h=0.2)
    before = model.w.copy()
    with pytest.raises(RunError, match="finite|number"):
        model.steps(3)
    assert np.array_equal(model.w, before) and model.count == 0


@pytest.mark.parametrize("J, more", [("1e60", ""), ("1.0", ", kappa = 1e-60")])
def test_strong_fields_turn_by_half_a_circle_from_bond_to_bond(monkeypatch, J, more):
    strong = lattice("strong", "chain(n, periodic)", 18, "n", EXCHANGE.replace("-0.7", J), more=more)
    model = built(monkeypatch, strong).start("random", h=0.2).steps(3)
    assert np.abs(np.linalg.norm(model.w, axis=1) - 1).max() < 10 * 2**-52      # an ulp each of nine turns, and one of what numpy takes for the length


def test_slopes_without_a_bound_go_from_bond_to_bond():
    logs = lattice("logs", "chain(n, periodic)", 18, "n", EXCHANGE.replace("-0.7*dot(w[i], w[j])", "-log(2 - dot(w[i], w[j]))"))
    sites = lattice("sites", "chain(n, periodic)", 18, "n", EXCHANGE.replace("-0.7", "sin(i)"))
    assert not in_rows(logs) and not in_rows(sites)


@pytest.mark.parametrize("compiler, mode", MODES)
@pytest.mark.parametrize("lanes", [1, 2])
def test_clean_c(tmp_path, compiler, mode, lanes):
    files = generate(SPECS["far layers"], method=METHOD)
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert not compile_all(tmp_path, ["far.c"], compiler, "-Wno-psabi", f"-DSMG_LANES={lanes}", how=mode)
