"""Lattices by rows on several ranks of MPI (runtime/lattice/smg_row_ranks.h): the bits of one, in C and by `smidgen run`, and no rank that waits for ever."""
import importlib.util
import os
import shutil
import subprocess
import sys

import pytest
import smidgen
from smidgen import ranks
from smidgen.build.mpi import mpi_compiler
from smidgen.compile.emit.emit import generate
from smidgen.errors import MissingTool
from smidgen.resources import include_flags
from smidgen.run.step.start import initial_state
from support.strict import COMPILERS, WARNINGS
from test_rows_by_site import BLOCKS as SITED_BLOCKS, KINDS, SOME as SITED
from test_rows_in_time import field
from test_rows import DM, EXCHANGE, FIELD, FOUR, HONEY, PLANES, SKEW, SPECS, lattice
from test_rows_families import BONDS, layers

MISSING = [name for name in ("mpicc", "mpirun") if not shutil.which(name)]
needs_mpi = pytest.mark.skipif(bool(MISSING), reason=f"no {', '.join(MISSING)}: apt-get install libopenmpi-dev openmpi-bin")
needs_mpi4py = pytest.mark.skipif(bool(MISSING) or not importlib.util.find_spec("mpi4py"), reason="no MPI, or no mpi4py: pip install mpi4py")
LIMIT = 600         # seconds: ranks wait for each other, on a busy machine for long
MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}
SMALL = "-DSMG_MPI_SHARE=8 -DSMG_MPI_LOOK=8".split()     # parts so small that each rank has some of few sites, and looks at messages

MAIN = """
#ifdef SMG_MPI
#include <mpi.h>
#endif
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "{M}.h"

/* Five steps, a saved state restored, one step seven times, eight more, and six from a state that was set: in memory of its own. */
static int integrate(const {M}_model *model, const double *start, smg_real *out) {{
  const size_t n = 3 * (size_t){M}_sites(model);
  smg_real *w = malloc(n * sizeof *w);
  void *mem = malloc({M}_memsize(model));
  {M}_state s;
  for (size_t k = 0; k < n; ++k) w[k] = start[k];
  int status = {M}_init(&s, model, mem, w, 0, 0.1);
  status += {M}_steps(&s, 5);
  {M}_save(&s, out);
  status += {M}_init(&s, model, mem, w, 0, 0.1);
  status += {M}_restore(&s, out);
  for (int k = 0; k < 7; ++k) status += {M}_step(&s);
  status += {M}_steps(&s, 8);
  for (size_t k = 0; k < n; ++k) w[k] = -s.w[k];
  status += {M}_set_state(&s, w);
  status += {M}_steps(&s, 6);
  {M}_save(&s, out);
  free(mem);
  free(w);
  return status;
}}

/* NAME [TIMES]: the state that every rank ends with, in NAME.rank; each time again in memory full of another byte, and of the same bits. */
int main(int argc, char **argv) {{
  int rank = 0, status = 0;
#ifdef SMG_MPI
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
#endif
  {M}_params p;
  {M}_model model;
  {M}_defaults(&p);
  status += {M}_model_init(&model, &p);
  const size_t n = 3 * (size_t){M}_sites(&model), size = {M}_savesize(&model);
  smg_real *out = malloc(size * sizeof *out), *again = malloc(size * sizeof *again);
  double *start = malloc(n * sizeof *start);
  FILE *f = fopen("start.bin", "rb");
  if (argc < 2 || !f || fread(start, sizeof *start, n, f) != n) return 9;
  fclose(f);
  status += integrate(&model, start, out);
  for (int k = 1; k < (argc > 2 ? atoi(argv[2]) : 1); ++k) {{
    mallopt(M_PERTURB, 1 + k % 255);
    status += integrate(&model, start, again);
    if (memcmp(out, again, size * sizeof *out) != 0) fprintf(stderr, "rank %d: other bits, time %d\\n", rank, k), status += 100;
  }}
  char name[99];
  sprintf(name, "%s.%d", argv[1], rank);
  f = fopen(name, "wb");
  status += !f || fwrite(out, sizeof *out, size, f) != size || fclose(f);
#ifdef SMG_MPI
  MPI_Finalize();
#endif
  return status != 0;
}}
"""


def mpirun(count, *words, cwd, limit=LIMIT, **environment):
    return subprocess.run(["mpirun", "-n", str(count), *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=limit, env={**os.environ, **MPI, **environment})


def programs(where, spec, *more, right="", wrong="", method="spherical-midpoint"):
    """serial and shared in `where`, with a start; with one line wrong."""
    for file, text in generate(spec, method=method, amalgamate=bool(right)).items():
        assert right in text or not file.endswith(f"{spec.name}.c")
        (where / file).write_text(text.replace(right, wrong) if right else text)
    (where / "main.c").write_text(MAIN.format(M=spec.name))
    initial_state(spec, "random").astype(float).tofile(where / "start.bin")
    words = ["-std=c11", "-O0", "-Wno-psabi", "-ffp-contract=off", "-fno-math-errno", *more, *include_flags(), "-I.", "main.c", f"{spec.name}.c", "-o"]
    subprocess.run(["gcc", *words, "serial", "-lm"], cwd=where, check=True)
    subprocess.run(["mpicc", "-DSMG_MPI", *words, "shared", "-lm"], cwd=where, check=True)


def check_bits(where, counts):
    subprocess.run(["./serial", "serial"], cwd=where, check=True, env={**os.environ, **MPI})
    wanted = (where / "serial.0").read_bytes()
    for n in counts:
        said = mpirun(n, "./shared", f"of{n}", cwd=where, OMP_WAIT_POLICY="passive")
        assert said.returncode == 0, said.stderr
        assert [(where / f"of{n}.{k}").read_bytes() == wanted for k in range(n)] == [True] * n


BATH = """[effects.bath]
over = "site(i) of w"
damping = 0.2
"""
LONG = {  # along their slowest direction, so that four ranks have parts of them and send each other messages; most of SPECS are too small for that
    "long cubic": lattice("long_cubic", "cubic(4, 4, n, periodic)", 24, "16*n", EXCHANGE),
    "damped cubic": lattice("damped_cubic", "cubic(4, 4, n, periodic)", 24, "16*n", EXCHANGE + BATH),
    "warm cubic": lattice("warm_cubic", "cubic(4, 4, n, periodic)", 24, "16*n", EXCHANGE + BATH + "kT = 0.4\n"),
    "long open cubic": lattice("long_open_cubic", "cubic(5, 3, n, open)", 31, "15*n"),
    "ring of 600": lattice("ring", "chain(n, periodic)", 600, "n", EXCHANGE + FIELD + DM),
    "further neighbours of 900": lattice("further", "chain(n, periodic, 2)", 900, "n", EXCHANGE + EXCHANGE.replace("exchange", "near").replace("{over}", "chain(n, periodic)")),
    "long honeycomb": lattice("long_honeycomb", "honey.all", 40, "12*n", lattice=HONEY.replace('["n", 3]', '[6, "n"]')),
    "three colours along": lattice("long_skew", "skew.near", 41, "7*n", EXCHANGE + DM, SKEW.replace('["n", 4]', '[7, "n"]').replace('"periodic"', '"open"')),
    "long in four dimensions": lattice("long_four", "four.near", 20, "48*n", EXCHANGE + DM, FOUR.replace('["n", 3, 4, 2]', '[4, 3, 4, "n"]'))}
LONG["in time, by site"] = lattice("driven", "cubic(4, 4, n, periodic)", 24, "16*n", EXCHANGE + field(KINDS["a wave"]).replace("omega", "2") + field(KINDS["staggered"], "more"))
LONG["two families"] = layers(*BONDS, n=12, m=60)
SPECS = {**SPECS, "by site": SITED, "blocks by site": SITED_BLOCKS}
C_CASES = {"by site": (3,), "blocks by site": (2,), "odd cubic": (2,), "plain cubic": (2, 3, 4), "open cubic": (3,), "honeycomb": (2, 3), "ladder": (3,), "ring of 601": (4,), "open chain of 35": (2,), "further neighbours of 50": (2,),
           "three colours": (3,), "odd square": (3,), "four dimensions": (4,), "far": (2,)}


@needs_mpi
@pytest.mark.parametrize("name", [n if n == "odd cubic" else pytest.param(n, marks=pytest.mark.long) for n in C_CASES])
def test_ranks_have_the_same_bits(tmp_path, name):
    """Each rank has the whole state, with what rounding cut off and the history; restored, it goes on."""
    programs(tmp_path, SPECS[name], *SMALL)
    check_bits(tmp_path, C_CASES[name])


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("method", ["spherical-midpoint-4", "classical-midpoint"])
def test_other_midpoints_have_the_same_bits(tmp_path, method):
    programs(tmp_path, LONG["long cubic"], *SMALL, method=method)
    check_bits(tmp_path, (2, 4))


@needs_mpi
@pytest.mark.parametrize("name", [n if n == "long cubic" else pytest.param(n, marks=pytest.mark.long) for n in LONG])
def test_ranks_that_send_messages_have_the_same_bits(tmp_path, name):
    """tests/runtime/test_late_messages.py counts the messages."""
    programs(tmp_path, LONG[name], *SMALL)
    check_bits(tmp_path, (2, 3, 4))


@needs_mpi
@pytest.mark.parametrize("right, wrong", [("inner = {all.from + first, all.to - last}", "inner = {all.from, all.to - last}"), ("inner = {all.from + first, all.to - last}", "inner = {all.from + first, all.to}"),
                                          ("inner = {all.from + first", "inner = {all.from + first")], ids=["the first ones", "the last ones", "nothing"])
def test_ends_are_turned_before_they_are_sent(tmp_path, right, wrong):
    programs(tmp_path, LONG["long cubic"], *SMALL, right=right, wrong=wrong)
    subprocess.run(["./serial", "serial"], cwd=tmp_path, check=True, env={**os.environ, **MPI})
    said = mpirun(2, "./shared", "of2", cwd=tmp_path)
    agree = said.returncode == 0 and (tmp_path / "of2.0").read_bytes() == (tmp_path / "serial.0").read_bytes()
    assert agree == (right == wrong)


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("more", [("-fopenmp", "-DSMG_SHARE=8"), ("-DSMG_LONG_DOUBLE",), ("-march=native", "-DSMG_PLAIN_SUMS=1")], ids=["threads", "long double", "plain sums"])
def test_other_builds_too(tmp_path, monkeypatch, more):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    programs(tmp_path, SPECS["plain cubic"], *SMALL, *more)
    check_bits(tmp_path, (2, 3))


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("name", ["even", "odd and open"])
def test_planes_whose_rows_follow_as_they_lie(tmp_path, name):
    programs(tmp_path, PLANES[name], *SMALL, "-DSMG_LARGE_PLANE=0")
    check_bits(tmp_path, (2, 3))


@needs_mpi
@pytest.mark.long
def test_too_few_sites_for_all_ranks(tmp_path):
    """Some have no part, or one does all alike; so where a field grows for ever and no step goes by rows."""
    driven = FIELD.replace("0.3*w[i].x", "0.3*t*w[i].x")
    for n, spec in enumerate((SPECS["ring of 33"], SPECS["ring of 5"], lattice("driven", "square(n, 6, periodic)", 6, "6*n", EXCHANGE + driven))):
        (tmp_path / str(n)).mkdir()
        programs(tmp_path / str(n), spec, *SMALL)
        check_bits(tmp_path / str(n), (4,))


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("compiler", [c for c in COMPILERS if "++" not in c])
def test_clean_c(tmp_path, compiler):
    spec = SPECS["honeycomb"]
    for file, text in generate(spec, amalgamate=True).items():
        (tmp_path / file).write_text(text)
    words = [*mpi_compiler((compiler,)), *COMPILERS[compiler], *WARNINGS, "-Wno-psabi", "-I."]
    subprocess.run([*words, "-c", f"{spec.name}.c", "-o", "model.o"], cwd=tmp_path, check=True)


@needs_mpi
def test_a_tangent_map_compiles_for_ranks(tmp_path):
    """Each of them finds all of it."""
    for file, text in generate(LONG["long cubic"], features=("tangent",)).items():
        (tmp_path / file).write_text(text)
    subprocess.run(["mpicc", "-DSMG_MPI", "-std=c11", *include_flags(), "-I.", "-fsyntax-only", "long_cubic.c"], cwd=tmp_path, check=True)


# The command. Faults are planted by the driver: at the third checkpoint one rank is killed, interrupted, or fails.

DRIVER = """
import importlib, os, signal, sys
from smidgen import ranks
from smidgen.build import binary
from smidgen.cli import main
binary.FLAGS = tuple("-O0" if f == "-O3" else f for f in binary.FLAGS)
run = importlib.import_module("smidgen.run.run")
fault, at = os.environ.get("FAULT"), int(os.environ.get("AT", "0"))
saves, real = 0, run._save
def save(*given):
    global saves
    real(*given)
    saves += 1
    if saves == 3 and (ranks.variable(ranks.RANK) or 0) == at:
        if fault == "kill": os._exit(9)
        if fault == "interrupt": os.kill(os.getpid(), signal.SIGINT)
        if fault == "error": raise run.UsageError("planted")
run._save = save
sys.exit(main())
"""

FILM = lattice("film", "square(n, 12, periodic)", 12, "12*n")


@pytest.fixture
def film(tmp_path, monkeypatch):
    """A film of 144 spins in a folder, and run(count, *words): the command on so many ranks."""
    (tmp_path / "film.toml").write_text(FILM.sources[0][1])
    (tmp_path / "driver.py").write_text(DRIVER)
    monkeypatch.setenv("CC", f"gcc -Wno-psabi {' '.join(SMALL)}")

    def run(count, *words, fault="", at=0, **environment):
        words = [sys.executable, "driver.py", "run", *map(str, words)]
        environment |= {"FAULT": fault, "AT": str(at)}
        return mpirun(count, *words, cwd=tmp_path, **environment) if count else subprocess.run(
            words, cwd=tmp_path, capture_output=True, text=True, env={**os.environ, **environment})
    run.where = tmp_path
    return run


GIVEN = ("film.toml", "--start", "random", "--h", "0.1", "--steps", "12", "--every", "4", "--what", "states,energy")


@needs_mpi4py
@pytest.mark.parametrize("count", [2, pytest.param(3, marks=pytest.mark.long)])
def test_a_run_writes_the_file_of_one(film, count):
    assert film(0, *GIVEN, "--out", "one.npz").returncode == 0
    said = film(count, *GIVEN, "--out", "all.npz")
    assert said.returncode == 0, said.stderr
    assert (film.where / "all.npz").read_bytes() == (film.where / "one.npz").read_bytes()
    assert said.stdout.count("wrote all.npz") == 1 and "ranks" not in said.stderr


@needs_mpi4py
@pytest.mark.long
@pytest.mark.parametrize("fault, at, code", [("kill", 0, 9), ("kill", 1, 9), ("interrupt", 1, 130)])
def test_stopped_it_goes_on(film, fault, at, code):
    """From the checkpoint of some ranks on others, or one; the file is that of a run that was not stopped."""
    assert film(0, *GIVEN, "--out", "one.h5").returncode == 0
    assert film(2, *GIVEN, "--out", "all.h5", "--checkpoint", "2", fault=fault, at=at).returncode == code
    again = film(3 if fault == "kill" and at else 0, "--resume", "all.h5")
    assert again.returncode == 0, again.stderr
    found, wanted = (smidgen.load_result(film.where / name) for name in ("all.h5", "one.h5"))
    assert (found.w["w"] == wanted.w["w"]).all() and (found.final == wanted.final).all()


@needs_mpi4py
@pytest.mark.long
@pytest.mark.parametrize("at", [0, 1])
def test_one_rank_that_fails_ends_all(film, at):
    said = film(2, *GIVEN, "--out", "all.h5", "--checkpoint", "2", fault="error", at=at)
    assert said.returncode == 2 and "smidgen: planted" in said.stderr


@needs_mpi4py
@pytest.mark.long
def test_what_all_find_is_said_once(film):
    """A file that cannot be written, which rank 0 alone sees; a step that fails; a model whose steps have no parts."""
    said = film(2, *GIVEN, "--out", "nowhere/all.npz")
    assert said.returncode == 8 and said.stderr.count("smidgen: cannot write") == 1
    said = film(2, *GIVEN, CC=f"gcc {' '.join(SMALL)} -DSMG_ROW_PASSES=5")
    assert said.returncode == 4 and said.stderr.count("no convergence") == 1
    said = film(2, "free_rigid_body", "--steps", "5")
    assert said.returncode == 0 and "note: each of the 2 ranks took all steps" in said.stderr


def test_what_is_missing_is_said(film, monkeypatch, capsys):
    from smidgen.cli import main
    monkeypatch.setenv("MPICC", "no-such-mpicc")
    with pytest.raises(MissingTool, match="running on several ranks requires no-such-mpicc, .*libopenmpi-dev"):
        mpi_compiler(("gcc",))
    monkeypatch.setenv(ranks.SIZE[0], "2")
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    assert main(["run", str(film.where / "film.toml")]) == 2
    assert "pip install 'smidgen[mpi]'" in capsys.readouterr().err
