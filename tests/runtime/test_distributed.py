"""Ranks of MPI with memory of their own (runtime/lattice/smg_row_parts.h): the bits of one rank, and memory that falls with their number."""
import re
import subprocess

import pytest
import smidgen
from smidgen.build.mpi import mpi_compiler
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from smidgen.resources import include_flags
from smidgen.run.step.start import initial_state
from support.strict import COMPILERS, WARNINGS
from test_ranks import LONG, SMALL, mpirun, needs_mpi
from test_rows import DM, EXCHANGE, FIELD, SPECS, lattice

# Numbers of other ranks are NaN wherever a rank is given some. Every rank writes its part of the saved state and of w into one file.
MAIN = """
#ifndef _DEFAULT_SOURCE
#define _DEFAULT_SOURCE
#endif
#ifdef SMG_MPI
#include <mpi.h>
#endif
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include "{M}.h"

static {M}_model model;
static int64_t from, to, sites;

static void *pages(size_t size) {{
  void *mem = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return mem == MAP_FAILED ? NULL : mem;
}}

static long resident(void) {{
  long all, pages = 0;
  FILE *f = fopen("/proc/self/statm", "r");
  if (!f || fscanf(f, "%ld %ld", &all, &pages) != 2) return -1;
  fclose(f);
  return pages * sysconf(_SC_PAGESIZE);
}}

static int put(const char *name, const smg_real *all, int64_t first, int64_t n) {{
  const int f = open(name, O_WRONLY | O_CREAT, 0666);
  const ssize_t size = (ssize_t)(sizeof *all * (size_t)n);
  return n > 0 && pwrite(f, all + first, (size_t)size, (off_t)(sizeof *all) * first) != size ? close(f) + 1 : close(f);
}}

/* One start in the whole, of which others are spoilt. */
static smg_real *start(void) {{
  smg_real *w = pages(3 * sizeof *w * (size_t)sites);
  FILE *f = fopen("start.bin", "rb");
  if (!f) return NULL;
  for (int64_t k = 0; k < 3 * sites; ++k)
    if (fread(w + k, sizeof *w, 1, f) != 1) return NULL;
    else if (k < 3 * from || k >= 3 * to) w[k] = NAN;
  fclose(f);
  return w;
}}

static void say(const char *name, int rank, const {M}_state *s) {{
  char file[99];
  smg_real found[1 + 3] = {{{M}_energy(&model, (smg_real){M}_time(s), s->w)}};
  {M}_momentum(&model, s->w, found + 1);
  sprintf(file, "%s.said.%d", name, rank);
  FILE *f = fopen(file, "ab");
  fwrite(found, sizeof *found, 4, f);
  fclose(f);
}}

int main(int argc, char **argv) {{
  int rank = 0, status = 0;
#ifdef SMG_MPI
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
#endif
  {M}_params p;
  {M}_defaults(&p);
  status += {M}_model_init(&model, &p);
  {M}_part(&model, &from, &to);
  sites = {M}_sites(&model);
  const size_t size = {M}_savesize(&model);
  smg_real *w = start(), *out = pages(size * sizeof *out), *again = pages(size * sizeof *again);
  void *mem = pages({M}_memsize(&model));
  {M}_state s;
  const int64_t n3 = 3 * sites, head = (int64_t)size - n3 * ((int64_t)size / n3), arrays = (int64_t)size / n3;
  status += {M}_init(&s, &model, mem, w, 0, 0.1);
  say(argv[1], rank, &s);
  status += {M}_steps(&s, 5);
  say(argv[1], rank, &s);
#if defined(SMG_MPI) && defined(SMG_MPI_GRID)
  {M}_save_part(&s, from, to, out);
  status += to - from < sites && {M}_restore(&s, out) != SMG_BAD_PARAMETER;    /* not what others have of it */
  {M}_save_part(&s, from, from, NULL);
#endif
  /* saved layer by layer, and restored where nothing else is known */
  for (int64_t k = from; k < to; k += to - k > 7 ? 7 : to - k) {M}_save_part(&s, k, to - k > 7 ? k + 7 : to, out);
  for (int64_t k = 0; k < (int64_t)size; ++k) again[k] = k < head ? out[k] : NAN;
  for (int64_t a = 0; a < arrays; ++a)
    memcpy(again + head + a * n3 + 3 * from, out + head + a * n3 + 3 * from, (size_t)(3 * (to - from)) * sizeof *out);
  status += {M}_init(&s, &model, mem, w, 0, 0.1);
  status += {M}_restore(&s, again);
  say(argv[1], rank, &s);
  for (int k = 0; k < 7; ++k) status += {M}_step(&s);
  status += {M}_steps(&s, 8);
  for (int64_t k = 0; k < n3; ++k) w[k] = k < 3 * from || k >= 3 * to ? NAN : -s.w[k];
  status += {M}_set_state(&s, w);
  status += {M}_steps(&s, 6);
  say(argv[1], rank, &s);
  /* refused by one rank, it is by all, and the state goes on */
  if (from == 0) w[1] = NAN;
  status += {M}_set_state(&s, w) != SMG_NOT_FINITE || s.report.site != 0;
  status += {M}_steps(&s, 1);
  {M}_save(&s, out);
  if (from == 0) status += put(argv[1], out, 0, head);
  for (int64_t a = 0; a < arrays; ++a) status += put(argv[1], out, head + a * n3 + 3 * from, 3 * (to - from));
  fprintf(stderr, "rank %d: %lld to %lld\\n", rank, (long long)from, (long long)to);
#ifdef SMG_MPI
  MPI_Finalize();
#endif
  return status != 0;
}}
"""


def programs(where, spec, *more, main=MAIN, right="", wrong=""):
    """serial and shared in `where`, with a start; with one line of the runtime wrong."""
    for file, text in generate(spec, amalgamate=True, features=("distributed",)).items():
        assert right in text or not file.endswith(f"{spec.name}.c")
        (where / file).write_text(text.replace(right, wrong) if right else text)
    (where / "main.c").write_text(main.format(M=spec.name))
    initial_state(spec, "random").astype(float).tofile(where / "start.bin")
    words = ["-std=c11", "-O0", "-Wno-psabi", "-ffp-contract=off", "-fno-math-errno", *more, *include_flags(), "-I.", "main.c", f"{spec.name}.c", "-o"]
    subprocess.run(["gcc", *words, "serial", "-lm"], cwd=where, check=True)
    subprocess.run(["mpicc", "-DSMG_MPI", "-D_DEFAULT_SOURCE", *words, "shared", "-lm"], cwd=where, check=True)


def agree(where, n, sites, divided=True) -> bool:
    """Do n ranks come to the bits of one? Each site belongs to one of them, or all of them to each."""
    if not (where / "serial.bin").exists():
        subprocess.run(["./serial", "serial.bin"], cwd=where, check=True)
    said = mpirun(n, "./shared", f"of{n}", cwd=where, OMP_WAIT_POLICY="passive")
    assert said.returncode == 0, said.stderr
    parts = sorted(tuple(map(int, found)) for found in re.findall(r"rank \d+: (\d+) to (\d+)", said.stderr))
    assert parts[0][0] == 0 and parts[-1][1] == sites and all(to > from_ for from_, to in parts)
    assert all(to == from_ for (_, to), (from_, _) in zip(parts, parts[1:])) if divided else set(parts) == {(0, sites)}
    wanted = (where / "serial.bin.said.0").read_bytes()
    return (where / f"of{n}").read_bytes() == (where / "serial.bin").read_bytes() and all((where / f"of{n}.said.{k}").read_bytes() == wanted for k in range(n))


CASES = {
    "long cubic": (LONG["long cubic"], (2, 3, 4)),
    "open cubic": (lattice("open_cubic", "cubic(6, 4, n, open)", 30, "24*n", EXCHANGE + DM + FIELD), (2, 4)),
    "damped": (LONG["damped cubic"], (3,)),
    "warm": (LONG["warm cubic"], (3,)),
    "ring of 600": (LONG["ring of 600"], (2, 4)),
    "honeycomb": (LONG["long honeycomb"], (3,)),
    "four dimensions": (LONG["long in four dimensions"], (4,)),
    "in time, by site": (LONG["in time, by site"], (2,))}


@needs_mpi
@pytest.mark.parametrize("name", [n if n == "long cubic" else pytest.param(n, marks=pytest.mark.long) for n in CASES])
def test_divided_ranks_have_the_bits_of_one(tmp_path, name):
    """Steps, energies, momenta, saved and restored states: no rank reads what it was not given, which is NaN."""
    spec, counts = CASES[name]
    programs(tmp_path, spec, *SMALL)
    sites = len(initial_state(spec, "random"))
    assert [agree(tmp_path, n, sites) for n in counts] == [True] * len(counts)


@needs_mpi
@pytest.mark.long
def test_what_cannot_be_divided_each_rank_has(tmp_path):
    """Rows of a small plane follow each other by colours, not by layers."""
    programs(tmp_path, LONG["three colours along"], *SMALL)
    assert agree(tmp_path, 2, 287, divided=False)


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("right, wrong", [("(smg_own.from > 0 ? smg_own.from : all) - far", "smg_own.from"), ("at < from ? array + from", "at < from ? k"), ("for (int64_t s0 = x; s0 < x +", "for (int64_t s0 = x + 1; s0 < x +")],
                         ids=["the sites before", "numbers of others", "half of a row"])
def test_a_fault_is_seen(tmp_path, right, wrong):
    programs(tmp_path, CASES["long cubic"][0], *SMALL, right=right, wrong=wrong)
    with pytest.raises(AssertionError):
        assert agree(tmp_path, 3, 384)


MEMORY = MAIN[:MAIN.index("/* One start")] + """
/* Memory for the state alone, in bytes, after some steps. */
int main(int argc, char **argv) {{
  int rank = 0, status = 0;
  (void)put, (void)argv, (void)argc;
#ifdef SMG_MPI
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Barrier(MPI_COMM_WORLD);
#endif
  {M}_params p;
  {M}_defaults(&p);
  status += {M}_model_init(&model, &p);
  {M}_part(&model, &from, &to);
  sites = {M}_sites(&model);
  const long before = resident();
  void *mem = pages({M}_memsize(&model));
  smg_real *w = pages(3 * sizeof *w * (size_t)sites);
  for (int64_t k = from; k < to; ++k) w[3 * k + k % 3] = 1;
  {M}_state s;
  status += {M}_init(&s, &model, mem, w, 0, 0.02);
  munmap(w, 3 * sizeof *w * (size_t)sites);
  for (int k = 0; k < 3; ++k) status += {M}_steps(&s, 3);
  (void){M}_energy(&model, 0, s.w);
  fprintf(stderr, "rank %d: %ld more\\n", rank, resident() - before);
#ifdef SMG_MPI
  MPI_Finalize();
#endif
  return status != 0;
}}
"""


def memory(said) -> list:
    return sorted(int(found) for found in re.findall(r"rank \d+: (\d+) more", said.stderr))


@needs_mpi
@pytest.mark.long
def test_memory_is_divided(tmp_path):
    """160 bytes a spin in all, and what pages and messages take; without it each rank has them all."""
    spec, sites = lattice("large", "cubic(32, 32, n, periodic)", 400, "1024*n", EXCHANGE + FIELD), 1024 * 400
    programs(tmp_path, spec, "-O1", main=MEMORY)
    one, = memory(subprocess.run(["./serial"], cwd=tmp_path, check=True, capture_output=True, text=True))
    all_ = memory(mpirun(4, "./shared", cwd=tmp_path, OMP_WAIT_POLICY="passive"))
    assert 150 * sites < one < 170 * sites
    assert len(all_) == 4 and all_[-1] < 0.32 * one and sum(all_) < 1.2 * one


@needs_mpi
@pytest.mark.long
def test_memory_that_is_touched_is_seen(tmp_path):
    spec = lattice("large", "cubic(32, 32, n, periodic)", 400, "1024*n", EXCHANGE + FIELD)
    programs(tmp_path, spec, "-O1", main=MEMORY, right="if (smg_is_divided()) smg_clear_rows(s);", wrong="if (0) smg_clear_rows(s);")
    all_ = memory(mpirun(4, "./shared", cwd=tmp_path, OMP_WAIT_POLICY="passive"))
    assert len(all_) == 4 and all_[0] > 100 * 1024 * 400


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("compiler", [c for c in COMPILERS if "++" not in c])
def test_clean_c(tmp_path, compiler):
    spec = CASES["warm"][0]
    for file, text in generate(spec, amalgamate=True, features=("distributed",)).items():
        (tmp_path / file).write_text(text)
    words = [*mpi_compiler((compiler,)), *COMPILERS[compiler], *WARNINGS, "-Wno-psabi", "-I."]
    subprocess.run([*words, "-c", f"{spec.name}.c", "-o", "model.o"], cwd=tmp_path, check=True)


def test_models_that_cannot_be_divided_are_refused():
    with pytest.raises(UsageError, match="feature distributed: only lattices processed by rows"):
        generate(smidgen.load("point_vortices"), features=("distributed",))
    with pytest.raises(UsageError, match="on a chain it must be over one kind of bond"):
        generate(SPECS["far"], features=("distributed",))
