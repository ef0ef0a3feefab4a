"""Steps of a large lattice as a wavefront (runtime/lattice/smg_row_wave.h): the bits of one colour after the other."""
import os
import subprocess

import pytest
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from test_rows import DM, EXCHANGE, FIELD, lattice
from test_rows_in_time import field

LAYERS = """[lattices.layers]
size = ["n", 6, 60]
boundary = ["periodic", "periodic", "open"]
bonds.near = [{ from = 0, to = 0, offset = [1, 0, 0] }, { from = 0, to = 0, offset = [0, 1, 0] }, { from = 0, to = 0, offset = [1, 1, 0] }, { from = 0, to = 0, offset = [0, 0, 1] }]
"""
SPECS = {
    "ring": lattice("ring", "chain(n, periodic)", 1200, "n", EXCHANGE + DM),
    "open chain": lattice("open_chain", "chain(n, open)", 1201, "n", EXCHANGE),
    "cubic": lattice("cubic", "cubic(n, 4, 60, periodic)", 6, "240*n", EXCHANGE + DM),
    "open cubic": lattice("open_cubic", "cubic(n, 5, 60, open)", 6, "300*n", EXCHANGE + DM),
    "plane": lattice("plane", "square(n, 60, periodic)", 128, "60*n", EXCHANGE + DM),
    "in time, by site": lattice("driven", "cubic(n, 4, 80, periodic)", 6, "320*n", EXCHANGE + field("0.4*cos(2*t + 0.3*i)*w[i].y + 0.2*mod(i, 3)*w[i].z")),
    "own field": lattice("own_field", "cubic(n, 4, 80, periodic)", 6, "320*n", EXCHANGE + FIELD),
    "three colours": lattice("layers", "layers.near", 6, "360*n", EXCHANGE.replace("0.7", "0.4"), LAYERS),
    "three colours, a ring": lattice("further", "chain(n, periodic, 2)", 1800, "n", EXCHANGE + EXCHANGE.replace("exchange", "near").replace("{over}", "chain(n, periodic)")),
}

# Two states take the same calls of three steps, one of them without wavefronts, and are compared as a whole, with their reports. Before each
# call the other is told to expect something else: what the steps before took, more passes, fewer, no small components, or any of them to be looked at.
DRIVER = """
#include <stdint.h>
static int64_t least_bytes;
#define SMG_WAVE_BLOCK 8
#define SMG_WAVE_FROM least_bytes
#define SMG_LARGE_PLANE 7000
#define SMG_BLOCKS_TO 0
#include "{name}.c"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static {name}_state states[2];
static double *saved[2];

static void expect(smg_state *s, int what) {{
  if (what == 1) s->row_passes = s->row_fewest += 3;
  if (what == 2) s->row_passes = s->row_fewest -= 2;
  if (what == 3) s->row_near = 100;
  if (what == 4) s->row_near = 0;
}}

static int same(const smg_state *a, const smg_state *b, size_t size) {{
  {name}_save(a, saved[0]);
  {name}_save(b, saved[1]);
  return memcmp(saved[0], saved[1], size * sizeof(double)) == 0 && memcmp(a->w, b->w, (size_t)(3 * smg_sites(&a->c)) * sizeof(double)) == 0
         && a->report.iterations == b->report.iterations && a->report.residual == b->report.residual;
}}

int main(int count, char **words) {{
  const double h = atof(words[1]), tolerance = atof(words[2]), size_of_xy = atof(words[3]);
  smg_params p;
  smg_model model;
  smg_row_wave wave;
  (void)count;
  {name}_defaults(&p);
  if ({name}_model_init(&model, &p) != SMG_OK) return 1;
  const size_t sites = (size_t){name}_sites(&model), size = {name}_savesize(&model);
  double *w = malloc(3 * sites * sizeof(double));
  for (size_t k = 0; k < sites; ++k) {{
    const double z = 0.9 * sin(1.0 + 0.7 * (double)(k * k % 1009)), turn = 1.3 * (double)(k * 37 % 211);
    w[3 * k] = size_of_xy * sqrt(1 - z * z) * cos(turn);
    w[3 * k + 1] = size_of_xy * sqrt(1 - z * z) * sin(turn);
    w[3 * k + 2] = size_of_xy < 1 ? 1 : z;
  }}
  for (int k = 0; k < 2; ++k) {{
    saved[k] = malloc(size * sizeof(double));
    if ({name}_init(states + k, &model, malloc({name}_memsize(&model)), w, 0, h) != SMG_OK || {name}_set_tolerance(states + k, tolerance) != SMG_OK) return 1;
  }}
  for (int call = 0; call < 15; ++call) {{
    expect(states, call % 5);
    least_bytes = INT64_MAX;
    if ({name}_steps(states + 1, 3) != SMG_OK) return 2;
    least_bytes = 0;
    if ({name}_steps(states, 3) != SMG_OK) return 3;
    if (!same(states, states + 1, size)) return 4;
    if (!smg_wave_pays(states, &wave)) return 5;
  }}
  printf("%d passes, %d blocks, %d stages\\n", (int)wave.passes, (int)wave.blocks, (int)wave.stages);
  return 0;
}}
"""


def built(tmp_path, spec, right="", wrong="", more=()):
    """The driver, with some words of the runtime put wrong, or in another way; more: flags."""
    for file, text in generate(spec, amalgamate=bool(right)).items():
        assert right in text or not file.endswith(f"{spec.name}.c")
        (tmp_path / file).write_text(text.replace(right, wrong) if right else text)
    return compiled(tmp_path, spec, more)


def compiled(tmp_path, spec, more=()):
    (tmp_path / "main.c").write_text(DRIVER.format(name=spec.name))
    subprocess.run(["gcc", "-std=c11", "-O1", "-ffp-contract=off", "-Wno-psabi", *more, "-I.", *include_flags(), "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    return tmp_path / "main"


@pytest.mark.parametrize("name", SPECS)
def test_a_wavefront_has_the_same_bits(tmp_path, name):
    main = built(tmp_path, SPECS[name])
    for words in (("0.05", "0", "1"), ("0.1", "0", "1"), ("0.02", "1e-9", "1"), *[TINY] * (name == "open chain")):
        found = subprocess.run([main, *words], capture_output=True, text=True)
        assert found.returncode == 0, (words, found)


@pytest.mark.parametrize("name", ["plane", "cubic", *(pytest.param(n, marks=pytest.mark.long) for n in ("three colours, a ring", "ring", "open cubic", "three colours", "own field"))])
def test_threads_have_them_too(tmp_path, name):
    main = built(tmp_path, SPECS[name], more=("-fopenmp", "-DSMG_SHARE=8"))
    for words in (("0.05", "0", "1"), ("0.1", "0", "1"), ("0.02", "1e-9", "1")):
        found = subprocess.run([main, *words], capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "2"})
        assert found.returncode == 0, (words, found)


@pytest.mark.parametrize("more, status", [(1, 0), (0, 4)])
@pytest.mark.parametrize("name", ["cubic", *(pytest.param(n, marks=pytest.mark.long) for n in ("ring", "three colours, a ring"))])
def test_what_stages_do_at_one_time_may_go_in_any_order(tmp_path, name, more, status):
    """As they may by threads: here the last one first, with the lag of threads, and that of one thread."""
    lag, order = "block + (s->row_team > 1);", "for (int64_t k = 0; k < stages; ++k) {"
    spec = SPECS[name]
    for file, text in generate(spec, amalgamate=True).items():
        assert file != f"{spec.name}.c" or (text.count(lag), text.count(order)) == (1, 1)
        (tmp_path / file).write_text(text.replace(lag, f"block + {more};").replace(order, "for (int64_t k = stages - 1; k >= 0; --k) {"))
    assert subprocess.run([compiled(tmp_path, spec), "0.05", "0", "1"]).returncode == status


@pytest.mark.parametrize("n", [40, 1201])
def test_where_no_wavefront_pays(tmp_path, n):
    """A short ring has too few blocks; on one that is no multiple of the colours sites of a colour meet."""
    main = built(tmp_path, lattice("ring", "chain(n, periodic)", n, "n", EXCHANGE))
    assert subprocess.run([main, "0.05", "0", "1"]).returncode == 5


TINY = "0.1", "0", "1e-200"     # h, tolerance, size of x and y
WRONG = {"the lag": ("wave->lag = (s->row_reach + block - 1) / block", "wave->lag = 1"), "the beginning on a ring": ("wave->later = SMG_RINGS", "wave->later = 0 && SMG_RINGS"),
         "passes that were too many": ("if (smg_rows_settled(s, sweep) || (pass.small", "if ((pass.small")}


@pytest.mark.parametrize("name", WRONG)
def test_what_the_bits_depend_on(tmp_path, name):
    """The test above can fail: where a stage does not wait for the one before it, or what the passes show is not looked at."""
    main = built(tmp_path, SPECS["cubic"], *WRONG[name])
    assert any(subprocess.run([main, *words]).returncode == 4 for words in (("0.05", "0", "1"), ("0.1", "0", "1")))
