"""Small lattices in blocks, one in each lane (runtime/lattice/smg_row_blocks.h): the bits of rows."""
import subprocess

import pytest
from support.systems import tiers
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from test_rows import DM, EXCHANGE, FIELD, lattice

HONEY = """[lattices.honey]
size = ["n", 8]
sites = 2
boundary = "periodic"
bonds.all = [{ from = 0, to = 1, offset = [0, 0] }, { from = 0, to = 1, offset = [-1, 0] }, { from = 0, to = 1, offset = [0, -1] }]
"""
STACKED = """[lattices.stacked]
size = ["n", 4]
sites = 2
boundary = "periodic"
bonds.all = [{ from = 0, to = 0, offset = [1, 0] }, { from = 1, to = 1, offset = [1, 0] }, { from = 0, to = 0, offset = [0, 1] }, { from = 1, to = 1, offset = [0, 1] }, { from = 0, to = 1, offset = [0, 0] }]
"""
UNLIKE = STACKED.replace("stacked", "unlike").replace("{ from = 1, to = 1, offset = [0, 1] }, ", "")      # places of a cell with four and two bonds
FOUR = """[lattices.four]
size = ["n", 4, 2, 6]
boundary = "periodic"
bonds.all = [{ from = 0, to = 0, offset = [1, 0, 0, 0] }, { from = 0, to = 0, offset = [0, 1, 0, 0] }, { from = 0, to = 0, offset = [0, 0, 1, 0] }, { from = 0, to = 0, offset = [0, 0, 0, 1] }]
"""
NEAR = """[lattices.near]
size = ["n", 12, 12]
boundary = "periodic"
bonds.all = [%s]
""" % ", ".join(f"{{ from = 0, to = 0, offset = {list(o)} }}" for o in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)))
TRIANGULAR = """[lattices.triangles]
size = ["n", 16]
boundary = "periodic"
bonds.all = [{ offset = [1, 0] }, { offset = [0, 1] }, { offset = [1, -1] }]
"""
# Each with the blocks along its directions, and how far along the first of them the next ones begin.
SPECS = {
    "ring": (lattice("ring", "chain(n, periodic)", 48, "n", EXCHANGE + DM), (8, 1, 1, 1), (0, 0, 0, 0)),
    "square": (lattice("square", "square(n, 8, periodic)", 10, "8*n", EXCHANGE + DM + FIELD), (1, 8, 1, 1), (0, 5, 0, 0)),
    "cubic": (lattice("cubic", "cubic(n, n, n, periodic)", 20, "n*n*n", EXCHANGE), (2, 4, 1, 1), (0, 5, 0, 0)),
    "long cubic": (lattice("long_cubic", "cubic(n, 6, 12, periodic)", 8, "72*n", EXCHANGE + DM), (4, 1, 2, 1), (0, 0, 0, 0)),
    "honeycomb": (lattice("honeycomb", "honey.all", 10, "16*n", EXCHANGE + DM, HONEY), (1, 8, 1, 1), (0, 0, 0, 0)),
    "stacked": (lattice("stacked_up", "stacked.all", 16, "8*n", EXCHANGE + DM, STACKED), (4, 2, 1, 1), (0, 0, 0, 0)),
    "unlike": (lattice("unlike_places", "unlike.all", 16, "8*n", EXCHANGE + DM, UNLIKE), (4, 2, 1, 1), (0, 0, 0, 0)),
    "three colours": (lattice("further", "chain(n, periodic, 2)", 96, "n", EXCHANGE + EXCHANGE.replace("exchange", "near").replace("{over}", "chain(n, periodic)")), (8, 1, 1, 1), (0, 0, 0, 0)),
    "four colours in place of three": (lattice("triangles", "triangles.all", 16, "16*n", EXCHANGE, TRIANGULAR), (1, 8, 1, 1), (0, 0, 0, 0)),
    "eighteen neighbours": (lattice("far", "near.all", 12, "144*n", EXCHANGE.replace("0.7", "0.2"), NEAR), (2, 4, 1, 1), (0, 0, 0, 0)),
    "four directions": (lattice("directions", "four.all", 8, "48*n", EXCHANGE.replace("0.7", "0.3"), FOUR), (4, 2, 1, 1), (0, 0, 0, 0)),
}
# No lattice for them: a direction that is open, 500 sites of a colour in vectors of eight, rows of 66 sites that begin where a vector does, a ring
# that closes sites of one colour upon each other, and so many cells.
WITHOUT = {
    "open": lattice("open_square", "square(n, 8, open)", 10, "8*n", EXCHANGE),
    "half a vector": lattice("halves", "cubic(n, n, n, periodic)", 10, "n*n*n", EXCHANGE),
    "empty slots": lattice("emptied", "square(n, 8, periodic)", 132, "8*n", EXCHANGE),
    "at the seam": lattice("seam", "square(16, n, periodic)", 7, "16*n", EXCHANGE),
    "at the seam of the fourth direction": lattice("sewn", "four.all", 8, "40*n", EXCHANGE, FOUR.replace("6]", "5]")),
    "large": lattice("extensive", "square(n, 640, periodic)", 640, "640*n", EXCHANGE),
}

# Two states, of which the second stands in rows, take the same calls of steps; they and what they save are compared bit by bit, and so is a third one in
# blocks that is restored from what the second saved.
DRIVER = """
#include <stdint.h>
static int64_t most_slots;
#define SMG_BLOCKS_TO most_slots
#include "{name}.c"
#include <stdio.h>
#include <stdlib.h>

static {name}_state states[3];
static smg_real *saved[3];

static int steps(int k, int64_t count) {{
  most_slots = k == 1 ? 0 : INT32_MAX;
  return {name}_steps(states + k, count) == SMG_OK;
}}

/* Numbers, for what fills a long double up has any bits. */
static int alike(const smg_real *a, const smg_real *b, size_t size) {{
  for (size_t k = 0; k < size; ++k)
    if (!(a[k] == b[k]) || !signbit(a[k]) != !signbit(b[k])) return 0;
  return 1;
}}

static int saves_alike(int k, size_t size) {{
  most_slots = INT32_MAX;
  {name}_save(states, saved[0]);
  most_slots = k == 1 ? 0 : INT32_MAX;
  {name}_save(states + k, saved[k]);
  return alike(saved[0], saved[k], size);
}}

static int same(int k, size_t sites, size_t size) {{
  return saves_alike(k, size) && alike(states[0].w, states[k].w, 3 * sites)
         && states[0].report.iterations == states[k].report.iterations && states[0].report.residual == states[k].report.residual;
}}

int main(int count, char **words) {{
  smg_params p;
  smg_model model;
  smg_blocks b = {{{{0}}, {{0}}, {{0}}}};
  (void)count;
  {name}_defaults(&p);
  if ({name}_model_init(&model, &p) != SMG_OK) return 1;
  most_slots = INT32_MAX;
  const size_t sites = (size_t){name}_sites(&model), size = {name}_savesize(&model), bytes = {name}_memsize(&model);
  smg_real *w = malloc(3 * sites * sizeof(smg_real));
  for (size_t k = 0; k < sites; ++k) {{
    const smg_real z = 0.9 * sin(1.0 + 0.7 * (double)(k * k % 1009)), turn = 1.3 * (double)(k * 37 % 211);
    w[3 * k] = SMG_MATH(sqrt)(1 - z * z) * SMG_MATH(cos)(turn);
    w[3 * k + 1] = SMG_MATH(sqrt)(1 - z * z) * SMG_MATH(sin)(turn);
    w[3 * k + 2] = z;
  }}
  for (int k = 0; k < 3; ++k) {{
    most_slots = k == 1 ? 0 : INT32_MAX;
    saved[k] = malloc(size * sizeof(smg_real));
    if ({name}_init(states + k, &model, malloc(bytes), w, 0, atof(words[1])) != SMG_OK || {name}_set_tolerance(states + k, atof(words[2])) != SMG_OK) return 1;
  }}
  if (!states[0].rows || !states[0].row_beside || states[1].row_beside) return 2;
  for (int call = 0; call < 12; ++call) {{
    if (!steps(0, 1 + call) || !steps(1, 1 + call)) return 3;
    if (!same(1, sites, size)) return 4;
    if (call == 5) {{
      most_slots = INT32_MAX;
      if ({name}_restore(states + 2, saved[1]) != SMG_OK || !saves_alike(2, size)) return 5;
    }}
    if (call > 5 && (!steps(2, 1 + call) || !same(2, sites, size))) return 6;
  }}
  most_slots = INT32_MAX;
  if (!smg_in_blocks(&states[0].c, &b)) return 7;
  for (int d = 0; d < 4; ++d) printf("%d ", (int)b.parts[d]);
  for (int d = 0; d < 4; ++d) printf("%d ", (int)b.shear[d]);
  return 0;
}}
"""


def built(tmp_path, spec, method="spherical-midpoint", right="", wrong="", more=()):
    for file, text in generate(spec, amalgamate=bool(right), method=method).items():
        assert right in text or not file.endswith(f"{spec.name}.c")
        (tmp_path / file).write_text(text.replace(right, wrong) if right else text)
    (tmp_path / "main.c").write_text(DRIVER.format(name=spec.name))
    subprocess.run(["gcc", "-std=c11", "-O1", "-ffp-contract=off", "-Wno-psabi", *more, "-I.", *include_flags(), "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    return tmp_path / "main"


def bits_agree(main, *words):
    return subprocess.run([main, *words], capture_output=True, text=True)


FIRST = (("cubic", 2), ("honeycomb", 8), ("unlike", 4), ("eighteen neighbours", 8))


@pytest.mark.parametrize("name, lanes", [*FIRST, *(pytest.param(n, lanes, marks=pytest.mark.long) for n in SPECS for lanes in (1, 2, 4, 8) if (n, lanes) not in FIRST)])
def test_blocks_have_the_bits_of_rows(tmp_path, name, lanes):
    spec, parts, shear = SPECS[name]
    main = built(tmp_path, spec, more=(f"-DSMG_LANES={lanes}",))
    for words in (("0.15", "0"), ("0.02", "1e-9")):
        found = bits_agree(main, *words)
        assert found.returncode == 0, (words, found)
        numbers = tuple(map(int, found.stdout.split()))
        assert numbers == (*parts, *shear)


@pytest.mark.parametrize("name, method", [("honeycomb", "sublattice-rotations"), ("three colours", "sublattice-rotations"), *(pytest.param(*case, marks=pytest.mark.long) for case in (
    ("cubic", "sublattice-rotations"), ("cubic", "sublattice-rotations-kl9a"), ("three colours", "sublattice-rotations-kl9a")))])
def test_sublattice_rotations_have_them_too(tmp_path, name, method):
    found = bits_agree(built(tmp_path, SPECS[name][0], method), "0.05", "0")
    assert found.returncode == 0, found


@pytest.mark.parametrize("method", ["spherical-midpoint", "sublattice-rotations"])
def test_threads_have_them_too(tmp_path, monkeypatch, method):
    """Shares so small that a colour of 64 sites has three; and what does not stand in blocks goes in wavefronts."""
    for word, value in (("OMP_NUM_THREADS", "3"), ("OMP_WAIT_POLICY", "passive")): monkeypatch.setenv(word, value)
    found = bits_agree(built(tmp_path, SPECS["stacked"][0], method, more=("-fopenmp", "-DSMG_SHARE=8", "-DSMG_WAVE_FROM=0", "-DSMG_WAVE_BLOCK=8")), "0.05", "0")
    assert found.returncode == 0, found


@pytest.mark.parametrize("method", ["spherical-midpoint", pytest.param("sublattice-rotations", marks=pytest.mark.long)])
def test_long_doubles_have_them_too(tmp_path, method):
    found = bits_agree(built(tmp_path, SPECS["honeycomb"][0], method, more=("-DSMG_LONG_DOUBLE",)), "0.05", "0")
    assert found.returncode == 0, found


WHETHER = """
#include "{name}.c"
#include <stdio.h>
int main(void) {{
  smg_params p;
  smg_model model;
  smg_coefficients c;
  smg_blocks b;
  {name}_defaults(&p);
  smg_sizes(&model, &p);
  c.model = &model;
  return smg_in_blocks(&c, &b) || (NO_PARTS && smg_find_blocks(&c, &b));
}}
"""


@pytest.mark.parametrize("name", WITHOUT)
def test_where_there_are_none(tmp_path, name):
    spec = WITHOUT[name]
    for file, text in generate(spec).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "main.c").write_text(WHETHER.format(name=spec.name))
    subprocess.run(["gcc", "-std=c11", "-O0", "-w", f"-DNO_PARTS={int(name == 'half a vector')}", "-I.", *include_flags(), "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"]).returncode == 0


WRONG = {
    "the lane": ("sum += (l / unit + t / unit) % b->parts[d] * unit;", "sum += (l / unit) % b->parts[d] * unit;"),
    "the shear": ("x -= part * b->shear[d];", ""),
    "the sample": ("return smg_slot_in_blocks(c, b, at.sub, cell);", "return slot;"),
    "the passes that are not watched": ("s->row_from = steps < 0 ? -steps : 0;", "s->row_from = 0;"),
    "nothing": ("x -= part", "x -= part"),
}


@pytest.mark.parametrize("what", tiers(WRONG, (), ("the lane", "nothing")))
def test_what_the_bits_depend_on(tmp_path, what):
    found = bits_agree(built(tmp_path, SPECS["cubic"][0], right=WRONG[what][0], wrong=WRONG[what][1]), "0.2", "0")
    assert found.returncode == {"nothing": 0, "the passes that are not watched": 5}.get(what, 4)
