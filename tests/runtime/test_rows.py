"""Lattices in lanes (runtime/lattice/smg_rows.h): at every size, boundary and width the step that the equation has, with the same bits."""
import re
import shutil
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.assemble.model import Model
from smidgen.compile.emit.emit import generate
from smidgen.compile.emit.memory import value
from smidgen.compile.plan.plan import choose
from smidgen.compile.select import select
from smidgen.run.step.saved import DEGREE, H, HISTORY
from support.strict import COMPILERS, MODES, compile_all

HEAD = """
[model]
name = "{name}"
[space]
w = {{ sphere = "{sites}"{more} }}
[parameters]
n = {n}
{lattice}
{effects}
[starts.random]
random = 1
"""
EXCHANGE = """[effects.exchange]
over = "bond(i, j) of {over}"
energy = "-0.7*dot(w[i], w[j])"
"""
FIELD = """[effects.field]
over = "site(i) of w"
energy = "0.3*w[i].x - 0.2*w[i].z + 0.4*w[i].z^2 + 0.1*w[i].x*w[i].y"
"""
DM = """[effects.dm]
over = "bond(i, j) of {over}"
energy = "0.2*(w[i].x*w[j].y - w[i].y*w[j].x) + 0.3*w[i].z*w[j].z"
"""
HONEY = """[lattices.honey]
size = ["n", 3]
boundary = ["periodic", "open"]
sites = 2
bonds.all = [{ from = 0, to = 1, offset = [0, 0] }, { from = 0, to = 1, offset = [-1, 0] }, { from = 0, to = 1, offset = [0, -1] }]
"""
SKEW = """[lattices.skew]
size = ["n", 4]
boundary = ["open", "periodic"]
bonds.near = [{ from = 0, to = 0, offset = [1, 0] }, { from = 0, to = 0, offset = [2, 1] }, { from = 0, to = 0, offset = [0, -1] }]
"""
LADDER = """[lattices.rungs]
size = ["n"]
boundary = "open"
sites = 2
bonds.all = [{ from = 0, to = 0, offset = [1] }, { from = 1, to = 1, offset = [1] }, { from = 0, to = 1, offset = [0] }]
"""
FAR = """[lattices.reach]
size = ["n"]
boundary = "periodic"
bonds.all = [{ from = 0, to = 0, offset = [1] }, { from = 0, to = 0, offset = [5] }]
"""
FIVE = """[lattices.five]
size = ["n", 7]
boundary = "periodic"
bonds.all = [{ from = 0, to = 0, offset = [1, 0] }, { from = 0, to = 0, offset = [2, 0] }, { from = 0, to = 0, offset = [3, 0] }, { from = 0, to = 0, offset = [4, 0] }, { from = 0, to = 0, offset = [0, 1] }]
"""
MANY = """[lattices.shells]
size = ["n", 9]
boundary = "periodic"
bonds.all = [%s]
""" % ", ".join(f"{{ offset = [{x}, {y}] }}" for x in range(-3, 4) for y in range(4) if 0 < x*x + y*y <= 9 and (y, x) > (0, 0))
UNEVEN = """[lattices.uneven]
size = ["n", 4]
sites = 3
boundary = "periodic"
bonds.all = [{ from = 0, to = 1, offset = [0, 0] }, { from = 0, to = 2, offset = [0, 0] }]
"""
FOUR = """[lattices.four]
size = ["n", 3, 4, 2]
boundary = ["periodic", "open", "periodic", "open"]
bonds.near = [{ from = 0, to = 0, offset = [1, 0, 0, 0] }, { from = 0, to = 0, offset = [0, 0, 1, 0] }, { from = 0, to = 0, offset = [0, 0, 0, 1] }]
"""
LINES = """[lattices.lines]
size = ["n", 1, 3]
boundary = "periodic"
bonds.all = [{ from = 0, to = 0, offset = [1, 0, 0] }, { from = 0, to = 0, offset = [0, 0, 1] }]
"""


COMB = """[lattices.teeth]
size = ["n"]
sites = 2
boundary = "periodic"
bonds.all = [{ from = 0, to = 0, offset = [1] }, { from = 0, to = 1, offset = [0] }]
"""


def lattice(name, over, n, sites, effects=EXCHANGE + FIELD, lattice="", more=""):
    return smidgen.load_text(HEAD.format(name=name, sites=sites, n=n, lattice=lattice, more=more, effects=effects.format(over=over)))


SPECS = {
    **{f"ring of {n}": lattice("ring", "chain(n, periodic)", n, "n", EXCHANGE + FIELD + DM) for n in (4, 5, 16, 17, 33, 66, 601)},
    **{f"open chain of {n}": lattice("open_chain", "chain(n, open)", n, "n") for n in (3, 5, 16, 35)},
    **{f"further neighbours of {n}": lattice("further", "chain(n, periodic, 2)", n, "n", EXCHANGE + EXCHANGE.replace("exchange", "near").replace("{over}", "chain(n, periodic)"))
       for n in (7, 12, 50)},
    "square": lattice("square", "square(n, 7, periodic)", 6, "7*n"),
    "odd square": lattice("odd_square", "square(n, 5, open)", 9, "5*n", EXCHANGE + DM),
    "cubic": lattice("cubic", "cubic(n, n, 4, periodic)", 6, "4*n*n"),
    "plain cubic": lattice("plain_cubic", "cubic(n, n, n, periodic)", 6, "n*n*n", EXCHANGE),
    "odd cubic": lattice("odd_cubic", "cubic(n, 3, 5, periodic)", 5, "15*n"),
    "open cubic": lattice("open_cubic", "cubic(n, 4, 3, open)", 18, "12*n"),
    "honeycomb": lattice("honeycomb", "honey.all", 5, "6*n", lattice=HONEY),
    "three colours": lattice("skew", "skew.near", 13, "4*n", EXCHANGE + DM, SKEW),
    "ladder": lattice("ladder", "rungs.all", 7, "2*n", lattice=LADDER),
    "comb": lattice("comb", "teeth.all", 18, "2*n", lattice=COMB),
    "far": lattice("far", "reach.all", 14, "n", lattice=FAR),
    "five colours": lattice("five", "five.all", 15, "7*n", EXCHANGE.replace("0.7", "0.3"), FIVE),
    "many neighbours": lattice("many", "shells.all", 21, "9*n", EXCHANGE.replace("0.7", "0.08") + DM.replace("0.2*", "0.05*").replace("0.3*", "0.02*") + FIELD, MANY),
    "many along a chain": lattice("along", "along.all", 40, "n", EXCHANGE.replace("0.7", "0.1"), '[lattices.along]\nsize = ["n"]\nboundary = "periodic"\nbonds.all = [%s]' % ", ".join(f"{{ offset = [{k}] }}" for k in range(1, 13))),
    "more of one place": lattice("uneven", "uneven.all", 5, "12*n", EXCHANGE + DM, UNEVEN),
    "four dimensions": lattice("four", "four.near", 4, "24*n", EXCHANGE + DM, FOUR),
    "pieces": lattice("pieces", "square(n, 30, periodic)", 20, "30*n"),
    "rows around themselves": lattice("lines", "lines.all", 9, "3*n", lattice=LINES),
    "other spheres": lattice("spheres", "chain(n, periodic)", 20, "n", more=", radius = 1.7, kappa = -0.6"),
}


WIDTHS = dict.fromkeys(("ring of 17", "three colours"), (2, 4, 8))      # ends of rows within a vector of every width, and a colour that feels itself


def built(monkeypatch, spec, lanes=4, compiler="gcc"):
    monkeypatch.setenv("CC", f"{compiler} -Wno-psabi -DSMG_LANES={lanes}")
    return smidgen.build(spec)


def bits(model, steps=12):
    return model.start("random", h=0.1).steps(steps).save()


MORE_OF_A_SHAPE = ("ring of 4", "ring of 16", "ring of 33", "ring of 66", "open chain of 5", "open chain of 16", "open chain of 35", "further neighbours of 7",
                   "further neighbours of 12", "further neighbours of 50", "square", "cubic", "plain cubic", "pieces")


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long if n in MORE_OF_A_SHAPE else ()) for n in SPECS])
def test_rows_solve_the_step(monkeypatch, name):
    """Against the witness, which knows no rows."""
    spec = SPECS[name]
    assert "define SMG_BY_ROWS" in generate(spec)[f"{spec.name}.c"]
    model = built(monkeypatch, spec).start("random", h=0.1)
    w, steps = model.w.copy(), 5 if model.sites < 200 else 2        # of hundreds of sites the witness takes seconds a step
    found, wanted = model.steps(steps).w, Witness(spec).steps(w, 0.0, 0.1, steps)
    assert np.abs(found - (wanted if np.ndim(wanted) == 2 else wanted[-1])).max() <= 2e-14 * np.abs(w).max()


@pytest.mark.parametrize("name", ["ring of 5", "ring of 17", "odd cubic", "honeycomb", "three colours", "far",
                                  *(pytest.param(n, marks=pytest.mark.long) for n in SPECS)])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, name):
    spec = SPECS[name]
    wanted = bits(built(monkeypatch, spec, 1))
    for lanes in WIDTHS.get(name, (4,)):
        assert np.array_equal(bits(built(monkeypatch, spec, lanes)), wanted)


@pytest.mark.skipif("clang" not in COMPILERS, reason="no clang")
@pytest.mark.parametrize("name", ["ring of 33", pytest.param("open cubic", marks=pytest.mark.long)])
def test_another_compiler_has_them_too(monkeypatch, name):
    assert np.array_equal(bits(built(monkeypatch, SPECS[name], 2, "clang")), bits(built(monkeypatch, SPECS[name], 4)))


def test_native_code_has_them_too(monkeypatch):
    wanted = bits(built(monkeypatch, SPECS["odd cubic"], 1))
    assert np.array_equal(bits(smidgen.build(SPECS["odd cubic"], native=True)), wanted)


@pytest.mark.parametrize("name", ["ring of 17", "honeycomb", "three colours"])
def test_restored_it_goes_on_with_the_same_bits(monkeypatch, name):
    model = built(monkeypatch, SPECS[name])
    saved, whole = model.start("random", h=0.1).steps(7).save(), model.steps(9).save()
    assert np.array_equal(model.start("random", h=0.03).restore(saved).steps(9).save(), whole)


def test_one_by_one_or_at_once(monkeypatch):
    model = built(monkeypatch, SPECS["odd cubic"])
    whole = bits(model)
    model.start("random", h=0.1)
    for _ in range(12):
        model.steps(1)
    assert np.array_equal(model.save(), whole)


@pytest.mark.parametrize("h", [0.05, 0.2, 0.25, 0.29])
def test_up_to_the_largest_step_of_rows(monkeypatch, h):
    """Strong fields, midpoints near the centre."""
    spec = SPECS["plain cubic"]
    model, witness = built(monkeypatch, spec).start("random", h=h), Witness(spec)
    w = model.w.copy()
    for _ in range(3):
        after = model.steps(1).w.copy()
        assert witness.residual(w, after, 0.0, h) <= 4e-15
        w = after
    model.steps(100)


BEYOND = {"plain cubic": (0.24, 0.29), "odd cubic": (0.24,), "square": (0.45,), "other spheres": (0.5,)}


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n == "plain cubic" else pytest.mark.long) for n in BEYOND])
def test_beyond_the_bound_sweeps_go_by_rows_too(monkeypatch, name):
    """The step that the equation has, with the same bits in lanes and without, one by one and restored."""
    spec = SPECS[name]
    models, witness = [built(monkeypatch, spec, lanes) for lanes in (1, 4)], Witness(spec)
    for h in BEYOND[name]:
        one, four = (model.start("random", h=h) for model in models)
        before = four.w.copy()
        assert witness.residual(before, four.steps(1).w, 0.0, h) <= 8e-15 * np.abs(before).max()
        saved = four.save()
        assert np.array_equal(one.steps(4).save(), four.steps(3).save())
        assert np.array_equal(four.start("random", h=0.05).restore(saved).steps(3).save(), one.save())


def test_large_steps_go_the_general_way(monkeypatch):
    """h where sweeps need not be a contraction: J h/sqrt(1 - (J h)^2) > 0.9; a state restored changes its way with its h."""
    model = built(monkeypatch, SPECS["cubic"])
    small = model.start("random", h=0.05).steps(3).save()
    w = model.w.copy()
    model.start("random", h=0.4).steps(1).restore(small)
    assert np.array_equal(model.save(), small) and np.array_equal(model.w, w)


def test_a_state_of_the_general_way_goes_on_by_rows(monkeypatch):
    """Of the increments that are saved rows keep as many as they have room for."""
    spec = SPECS["ring of 17"]
    model = built(monkeypatch, spec).start("random", h=0.7).steps(9)
    saved = model.save()
    assert saved[HISTORY] == 7
    saved[H], saved[DEGREE] = 0.05, 6
    kept = model.restore(saved).save()
    assert kept[HISTORY] in (4, 5) and kept[DEGREE] == kept[HISTORY] - 1
    w = model.w.copy()
    assert Witness(spec).residual(w, model.steps(1).w, 0.0, 0.05) <= 4e-15


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_tolerance_is_kept(monkeypatch, tolerance):
    spec = SPECS["cubic"]
    model = built(monkeypatch, spec).start("random", h=0.05, tolerance=tolerance)
    witness, w = Witness(spec), model.w.copy()
    for _ in range(6):
        after = model.steps(1).w.copy()
        assert witness.residual(w, after, 0.0, 0.05) <= tolerance
        w = after
    assert witness.residual(w, model.steps(1).w, 0.0, 0.05) > 1e-15


def test_a_step_that_does_not_settle_leaves_the_state(monkeypatch):
    """With five passes of colours allowed, in place of two thousand; the increments of a step stand where w is between calls."""
    model = built(monkeypatch, SPECS["cubic"], "4 -DSMG_ROW_PASSES=5").start("random", h=0.2)
    before, w = model.save(), model.w.copy()
    with pytest.raises(smidgen.RunError) as caught:
        model.steps(3)
    assert caught.value.status == 1 and caught.value.residual > 1e-12
    assert np.array_equal(model.save(), before) and np.array_equal(model.state(), w)


@pytest.mark.parametrize("start, h", [("random", 0.03), ("spiral", 0.02), ("spiral", 0.05)])
def test_passes_that_are_not_watched_are_no_more(monkeypatch, start, h):
    """Steps take as many sweeps as where all passes are watched, also where components that are round-off settle long after the others, and first steps take more."""
    spec, found = lattice("cubic", "cubic(n, 16, 16, periodic)", 16, "256*n", EXCHANGE), []
    k = np.arange(4096)
    w = np.array([np.cos(np.pi * k / 8), np.sin(np.pi * k / 8), 0.3 * np.cos(np.pi * k / 2048)]).T
    for flags in ("4", "4 -DSMG_ROW_WATCHED=1000"):
        model = built(monkeypatch, spec, flags).start(start if start == "random" else w / np.linalg.norm(w, axis=1)[:, None], h=h)
        found.append([model.steps(1).report()["iterations"] for _ in range(40)])
    assert found[0][0] > min(found[0]) and found[0] == found[1]


@pytest.mark.parametrize("over, sites, even", [("chain(n, periodic)", "n", 100), ("square(n, n, periodic)", "n*n", 24), ("cubic(n, n, n, periodic)", "n*n*n", 8), ("cubic(8, 8, n, periodic)", "64*n", 16)],
                         ids=["ring", "square", "cubic", "one side of three"])
def test_a_seam_takes_one_sweep_more(over, sites, even):
    """Sites of one colour that meet across the seam of odd sides feel the newest midpoints of each other, and are extrapolated as all others: as many sweeps as even sides take, or one more; two where three seams meet."""
    found = []
    for n in (even, even + 1):
        model = smidgen.build(lattice("rings", over, n, sites, EXCHANGE)).start("random", h=0.05).steps(10)
        found.append(max(model.steps(1).report()["iterations"] for _ in range(5)))
    assert found[0] <= found[1] <= found[0] + 1 + (even < 16)


def test_a_tiny_component_keeps_its_own_rate(monkeypatch):
    """All spins along z but for 1e-300: what is tiny solves the linear step of its own, to its own digits."""
    spec = lattice("ring", "chain(n, periodic)", 16, "n", EXCHANGE)
    w = np.zeros((16, 3))
    w[:, 2], tiny = 1, np.random.default_rng(3).uniform(-1, 1, (16, 2))
    found = {}
    for size in (1e-9, 1e-300):
        w[:, :2] = size * tiny
        found[size] = built(monkeypatch, spec).start(w, h=0.1).steps(20).w[:, :2] / size
    assert np.abs(found[1e-300] - found[1e-9]).max() <= 1e-13


@pytest.mark.parametrize("name", ["cubic 20", "ring of 601"])
def test_memory_of_a_spin(tmp_path, name):
    """160 bytes, and 216 on odd sides, which keep the increments of the first colour too; but for the few slots at the ends."""
    spec = lattice("big", "cubic(n, n, n, periodic)", 20, "n*n*n") if name == "cubic 20" else SPECS[name]
    for file, text in generate(spec, amalgamate=True).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "main.c").write_text(f'#include <stdio.h>\n#include "{spec.name}.c"\nint main(void) {{\n  {spec.name}_state s;\n  smg_params p;\n  smg_model model;\n'
                                     f"  {spec.name}_defaults(&p);\n  smg_sizes(&model, &p);\n  s.c.model = &model;\n"
                                     '  printf("%g\\n", (double)sizeof(smg_real) * (double)smg_row_layout(&s, NULL) / (double)smg_sites(&s.c));\n  return 0;\n}\n')
    subprocess.run(["gcc", "-Wno-psabi", "-I.", "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    sites, most = (8000, 160) if name == "cubic 20" else (601, 216 * 608 / 601)
    found = float(subprocess.run(["./main"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout)
    assert found <= most + 8 * 9 * 3 * 32 / sites and found <= stated_by_rows(spec) / sites <= 1.02 * found


MEMCHECK = """#include <stdlib.h>
#include "{name}.c"
int main(void) {{
  {name}_params p;
  {name}_model model;
  {name}_state s;
  static smg_real w[3 * 125];
  {name}_defaults(&p);
  for (int k = 0; k < 125; ++k) w[3 * k + k % 3] = 1;
  return {name}_model_init(&model, &p) || {name}_init(&s, &model, malloc({name}_memsize(&model)), w, 0, 0.1) || {name}_steps(&s, 4);
}}
"""


@pytest.mark.skipif(not shutil.which("valgrind"), reason="no valgrind: apt-get install valgrind")
def test_no_step_depends_on_memory_without_a_value(tmp_path):
    """Odd sides, whose pieces end within vectors."""
    spec = lattice("written", "cubic(n, n, n, periodic)", 5, "n*n*n", EXCHANGE)
    for file, text in {**generate(spec, amalgamate=True), "main.c": MEMCHECK.format(name=spec.name)}.items():
        (tmp_path / file).write_text(text)
    subprocess.run(["gcc", "-O1", "-g", "-Wno-psabi", "-DSMG_LANES=4", "-I.", "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    said = subprocess.run(["valgrind", "-q", "--error-exitcode=9", "./main"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr[-1500:]


def stated_by_rows(spec) -> int:
    """Bytes of the arrays by rows, as `gen` has them."""
    scene = select(spec)
    model = Model(scene, choose(scene, "spherical-midpoint", "auto"))
    sizes = {p.name: p.default for p in scene.parameters}
    return 8 * max(part.numbers(model, lambda e: value(e, model, sizes)) for part in model.parts)


OBLIQUE = """[lattices.oblique]
size = ["n", {rows}]
boundary = [{boundary}]
bonds.near = [{{ from = 0, to = 0, offset = [1, 0] }}, {{ from = 0, to = 0, offset = [0, 1] }}, {{ from = 0, to = 0, offset = [1, 1] }}]
"""
PLANES = {
    "even": lattice("even", "square(n, 12, periodic)", 128, "12*n", EXCHANGE + DM),
    "odd and open": lattice("odd_plane", "square(n, 11, open)", 131, "11*n", EXCHANGE + DM),
    "open one way": lattice("one_way", "strip.near", 140, "7*n", EXCHANGE, """[lattices.strip]
size = ["n", 7]
boundary = ["periodic", "open"]
bonds.near = [{ from = 0, to = 0, offset = [1, 0] }, { from = 0, to = 0, offset = [0, 1] }]
"""),
    "three colours": lattice("oblique", "oblique.near", 195, "6*n", EXCHANGE.replace("0.7", "0.5"), OBLIQUE.format(rows=6, boundary='"periodic", "periodic"')),
    "seam": lattice("seam", "oblique.near", 199, "7*n", EXCHANGE.replace("0.7", "0.5"), OBLIQUE.format(rows=7, boundary='"open", "periodic"')),
}


FIRST = [("odd and open", "spherical-midpoint"), ("seam", "spherical-midpoint"), ("three colours", "spherical-midpoint"), ("even", "sublattice-rotations")]


@pytest.mark.parametrize("name, method", [*FIRST, *(pytest.param(n, m, marks=pytest.mark.long) for n in PLANES for m in ("spherical-midpoint", "sublattice-rotations", "gauss-6") if (n, m) not in FIRST),
                                          pytest.param("open one way", "pair-rotations", marks=pytest.mark.long)])
def test_a_large_plane_has_the_bits_of_a_small_one(monkeypatch, name, method):
    """There rows follow each other as they lie; a small lattice is taken for a large one here."""
    assert re.search("define SMG_(BY_ROWS|ROW_STAGES)", generate(PLANES[name], method=method)[f"{PLANES[name].name}.c"])
    found = []
    for large in (1 << 40, 0):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LARGE_PLANE={large}")
        found.append(smidgen.build(PLANES[name], method=method).start("random", h=0.2).steps(5))
    assert np.array_equal(*(model.save() for model in found)) and np.array_equal(*(model.steps(3).w for model in found))


@pytest.mark.parametrize("name, why", [("branches", "0.1*i*abs(w[i].x)"), ("unbounded", "1/w[i].z")])
def test_what_rows_are_not_for(name, why):
    spec = lattice("general", "chain(n, periodic)", 16, "n", EXCHANGE + FIELD.replace(re.search('energy = "(.*)"', FIELD)[1], why))
    assert "define SMG_BY_ROWS" not in generate(spec)["general.c"]


@pytest.mark.parametrize("lanes", [1, 2, pytest.param(8, marks=pytest.mark.long)])
@pytest.mark.parametrize("compiler, mode", MODES)
@pytest.mark.parametrize("name", ["honeycomb", pytest.param("three colours", marks=pytest.mark.long)])
def test_clean_c(tmp_path, compiler, mode, lanes, name):
    spec = SPECS[name]
    for file, text in generate(spec, amalgamate=True).items():
        (tmp_path / file).write_text(text)
    assert not compile_all(tmp_path, [f"{spec.name}.c"], compiler, "-Wno-psabi", f"-DSMG_LANES={lanes}", how=mode)


@pytest.fixture
def quiet_threads(monkeypatch):
    """Threads that sleep while they wait: there may be fewer processors than threads."""
    monkeypatch.setenv("OMP_WAIT_POLICY", "passive")


@pytest.mark.parametrize("threads", [2, pytest.param(3, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", ["odd cubic", "plain cubic", "honeycomb", "three colours", "ring of 601"])
def test_threads_have_the_same_bits(monkeypatch, quiet_threads, name, threads):
    """Shares so small that each thread has some of these few sites."""
    spec = SPECS[name]
    wanted = bits(smidgen.build(spec))
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    assert np.array_equal(bits(smidgen.build(spec, threads=threads)), wanted)


def test_threads_where_there_are_none():
    with pytest.raises(smidgen.UsageError, match="use one thread"):
        smidgen.build(smidgen.load("free_rigid_body"), threads=2)
    for wrong in (0, -1, 1.5, True, 10**6):
        with pytest.raises(smidgen.UsageError, match="threads must be a number"):
            smidgen.build(SPECS["plain cubic"], threads=wrong)


def test_a_compiler_without_openmp(monkeypatch):
    from smidgen.build import binary
    monkeypatch.setattr(binary, "THREADS", ("-fno-such-thing",))
    with pytest.raises(smidgen.MissingTool, match="does not support OpenMP"):
        smidgen.build(SPECS["plain cubic"], threads=2)


def test_a_run_with_threads_is_recorded_and_repeated(tmp_path):
    spec = SPECS["plain cubic"]
    result = smidgen.run(spec, start="random", h=0.1, steps=3, threads=2, out=tmp_path / "cubic.npz", keep=True)
    assert result.meta["threads"] == 2 and "-fopenmp" in result.meta["flags"]
    assert np.array_equal(smidgen.repeat(tmp_path / "cubic.npz").w["w"], smidgen.run(spec, start="random", h=0.1, steps=3).w["w"])
