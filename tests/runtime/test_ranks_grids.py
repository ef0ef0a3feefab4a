"""Lattices cut into blocks among MPI ranks (runtime/lattice/smg_row_grid.h): the bits of one rank for grids in two, three and four directions."""
import os
import re
import shutil
import subprocess
import sys
from itertools import product
from math import prod

import pytest
import smidgen
from smidgen import ranks
from smidgen.build.mpi import mpi_compiler
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from smidgen.resources import include_flags
from smidgen.run.step.grid import Rows, grid_of
from smidgen.run.step.prepared import prepare
from smidgen.run.step.start import initial_state
from support.strict import COMPILERS, WARNINGS
from test_distributed import MEMORY, agree, memory, programs as divided_programs
from test_late_messages import preloaded
from test_ranks import BATH, MPI, SMALL, mpirun, needs_mpi, needs_mpi4py, programs
from test_rows import DM, EXCHANGE, FIELD, FOUR, HONEY, SKEW, lattice
from test_rows_by_site import KINDS
from test_rows_families import BONDS, layers
from test_rows_in_time import field

# One program for all grids.
ANY = ("-D_DEFAULT_SOURCE", "-include", "stdlib.h", "-DSMG_MPI_GRID=" + ",".join(f'atoi(getenv("GRID_{d}"))' for d in range(4)))


def block(effects=EXCHANGE, over="cubic(16, 4, n, periodic)", n=4, sites="64*n", **more):
    return lattice("block", over, n, sites, effects, **more)


LARGE = block(over="cubic(32, 4, n, periodic)", sites="128*n")
REACHING = lattice("reaching", "reaching.all", 130, "6*n", EXCHANGE, """[lattices.reaching]
size = ["n", 6]
boundary = "periodic"
bonds.all = [{ from = 0, to = 0, offset = [1, 0] }, { from = 0, to = 0, offset = [3, 0] }, { from = 0, to = 0, offset = [0, 1] }]
""")    # rows of 65 slots and 7 empty ones
CASES = {  # -> spec, grids of ranks
    "three directions": (LARGE, ("2x1x1", "1x2x1", "1x1x2", "2x2x1", "2x1x2", "1x2x2", "1x4x1", "1x1x4", "2x2x2")),
    "open": (block(EXCHANGE + DM + FIELD, "cubic(31, 5, n, open)", 5, "155*n"), ("1x2x2", "2x2x1", "1x5x1", "2x1x3")),
    "warm": (block(EXCHANGE + BATH + "kT = 0.4\n"), ("1x2x2", "1x4x1")),
    "in time, by site": (block(EXCHANGE + field(KINDS["a wave"]).replace("omega", "2") + field(KINDS["staggered"], "more")), ("1x2x2", "1x2x1")),
    "one plane within": (block(over="cubic(18, 16, n, periodic)", n=6, sites="288*n"), ("1x1x2",)),    # of rows that are no whole vectors
    "anisotropy": (block(EXCHANGE + '[effects.easy]\nover = "site(i) of w"\nenergy = "-0.3*w[i].z^2"\n'), ("1x2x2",)),
    "empty slots at the end": (REACHING, ("3x1",)),
    "two families": (layers(*BONDS, n=48, m=6), ("2x1", "1x3", "2x2")),
    "honeycomb": (lattice("long_honeycomb", "honey.all", 32, "12*n", lattice=HONEY.replace('["n", 3]', '["n", 6]')), ("2x1", "1x2", "2x2")),
    "three colours": (lattice("skew", "skew.near", 48, "6*n", EXCHANGE + DM, SKEW.replace('["n", 4]', '["n", 6]').replace('"periodic"', '"open"')), ("2x1", "1x3", "2x2")),
    "four dimensions": (lattice("four", "four.near", 16, "64*n", EXCHANGE + DM, FOUR.replace('["n", 3, 4, 2]', '["n", 4, 4, 4]')), ("1x2x2x1", "1x1x2x2", "1x2x2x2"))}


def placed(grid: str) -> dict:
    """The environment of a program for all grids."""
    return {f"GRID_{d}": n for d, n in enumerate((grid.split("x") + ["1"] * 4)[:4])}


def bits(where, grid: str, *words, times=1, **environment) -> list:
    """What each rank ends with, or None where one failed."""
    said = mpirun(prod(map(int, grid.split("x"))), *words, "./shared", "of", times, cwd=where, OMP_WAIT_POLICY="passive", **placed(grid), **environment)
    count = prod(map(int, grid.split("x")))
    return [(where / f"of.{k}").read_bytes() for k in range(count)] if said.returncode == 0 else None


def wanted(where) -> bytes:
    subprocess.run(["./serial", "serial"], cwd=where, check=True, env={**os.environ, **MPI, **placed("1")})
    return (where / "serial.0").read_bytes()


def check(where, grids, *words, **more):
    one = wanted(where)
    for grid in grids:
        found = bits(where, grid, *words, **more)
        assert found is not None and all(other == one for other in found), grid


@needs_mpi
@pytest.mark.parametrize("name", [n if n == "warm" else pytest.param(n, marks=pytest.mark.long) for n in CASES])
def test_blocks_have_the_bits_of_one_rank(tmp_path, name):
    """Also a state saved and restored, one step at a time, and a state that was set."""
    spec, grids = CASES[name]
    programs(tmp_path, spec, *SMALL, *ANY)
    check(tmp_path, grids)


@needs_mpi
@pytest.mark.long
def test_late_messages_change_no_bit_of_blocks(tmp_path):
    """Of faces, edges and corners: on eight ranks each has seven others to exchange with."""
    programs(tmp_path, LARGE, *SMALL, *ANY)
    preloaded(tmp_path)
    for seed, grid in enumerate(("1x2x2", "2x2x2", "2x1x2", "1x2x2")):
        check(tmp_path, (grid,), "env", f"LD_PRELOAD={tmp_path / 'late.so'}", f"LATE_SEED={seed + 1}", f"MALLOC_PERTURB_={seed + 1}", times=2)


# what is wrong -> the line, and what stands there instead
FAULTS = {"what is sent is turned again": ("  for (int k = 0; k < tells; ++k) smg_take_off(&smg_halo.inner, told + k);", "  (void)told;"),
          "nothing comes around": ("    around[d] = k % 3 - 1;", "    around[d] = 0;"),
          "a face too few": ("  found.to[d] = smg_grid(d) > 1 ? smg_down(end + moved - 1, step) + 1", "  found.to[d] = smg_grid(d) > 1 ? smg_down(end + moved - 1, step)"),
          "x and y alone": ("    smg_repeat_type(3, pitch, some + k);", "    smg_repeat_type(2, pitch, some + k);"),
          "the last strip": ("k##_end = smg_strips(c, &smg_my_box); k < k##_end", "k##_end = smg_strips(c, &smg_my_box); k + 1 < k##_end")}


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_seen(tmp_path, fault):
    right, wrong = FAULTS[fault]
    programs(tmp_path, block(), *SMALL, *ANY, right=right, wrong=wrong)
    preloaded(tmp_path)
    one = wanted(tmp_path)
    assert any(bits(tmp_path, "1x2x2", "env", f"LD_PRELOAD={tmp_path / 'late.so'}", f"LATE_SEED={seed + 1}") != [one] * 4 for seed in range(3))


@needs_mpi
@pytest.mark.long
def test_threads_share_the_strips_of_a_block(tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    programs(tmp_path, LARGE, *SMALL, *ANY, "-fopenmp", "-DSMG_SHARE=8")
    check(tmp_path, ("1x2x1", "2x1x1"))


@needs_mpi
@pytest.mark.long
def test_other_midpoints_too(tmp_path):
    programs(tmp_path, block(), *SMALL, *ANY, method="spherical-midpoint-4")
    check(tmp_path, ("1x2x2",))


@needs_mpi
@pytest.mark.long
def test_init_refuses_what_cannot_be_cut_so(tmp_path):
    """Too few vectors in a row, too few cells, a coupling that reaches beyond the next block, another number of ranks."""
    programs(tmp_path, block(), *SMALL, *ANY)
    wanted(tmp_path)
    assert [bits(tmp_path, grid) for grid in ("2x1x1", "1x1x5")] == [None, None]
    assert mpirun(3, "./shared", "of", cwd=tmp_path, **placed("1x2x2")).returncode != 0


@needs_mpi
@pytest.mark.long
def test_the_last_part_of_a_row_may_be_shorter_than_others(tmp_path):
    """Of nine vectors the last one has a single site of each colour: bonds of three cells reach beyond it."""
    programs(tmp_path, REACHING, *SMALL, *ANY)
    assert bits(tmp_path, "9x1") is None
    with pytest.raises(UsageError, match="too few vectors of 8 for 9 parts"):
        cut(REACHING, "9x1", 9)
    assert cut(REACHING, "8x1", 8) == (8, 1)


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("compiler", [c for c in COMPILERS if "++" not in c])
@pytest.mark.parametrize("features", [(), ("tangent",)])
def test_clean_c(tmp_path, compiler, features):
    for file, text in generate(LARGE, amalgamate=True, features=features).items():
        (tmp_path / file).write_text(text)
    words = [*mpi_compiler((compiler,)), *COMPILERS[compiler], *WARNINGS, "-DSMG_MPI_GRID=1,2,2", "-Wno-psabi", "-I."]
    subprocess.run([*words, "-c", "block.c", "-o", "model.o"], cwd=tmp_path, check=True)


# Memory divided too: steps by blocks, w by layers

DIVIDED = {"three directions": ("2x1x1", "1x2x2", "2x1x2", "2x2x1", "1x4x1"), "warm": ("1x2x2",), "in time, by site": ("1x2x2",), "open": ("1x2x2",)}


def divided_agree(where, grid: str, sites: int, monkeypatch) -> bool:
    """By ranks that know nothing of the sites of others."""
    for old in where.glob("of*"):
        old.unlink()
    for name, value in placed(grid).items():
        monkeypatch.setenv(name, value)
    return agree(where, prod(map(int, grid.split("x"))), sites)


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("name", DIVIDED)
def test_divided_blocks_have_the_bits_of_one_rank(tmp_path, monkeypatch, name):
    """Steps, energies, momenta, saved and restored states: no rank reads what it was not given, which is NaN."""
    spec = CASES[name][0]
    divided_programs(tmp_path, spec, *SMALL, *ANY)
    assert [divided_agree(tmp_path, grid, len(initial_state(spec, "random")), monkeypatch) for grid in DIVIDED[name]] == [True] * len(DIVIDED[name])


LOST = {"what is restored": ("  smg_move_saved(s, SMG_TO_BLOCKS);", "  (void)0;"), "what is saved": ("  if (!out) smg_move_saved(s, SMG_TO_LAYERS);", ""),
        "w of others": ("    smg_carry_w(s, SMG_TO_BLOCKS);", "    (void)0;"), "a rank": ("  for (int k = 1, n = smg_mpi_parts; k < n; ++k) {", "  for (int k = 1, n = smg_mpi_parts; k + 1 < n; ++k) {")}


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("fault", LOST)
def test_what_is_not_carried_is_missed(tmp_path, monkeypatch, fault):
    right, wrong = LOST[fault]
    divided_programs(tmp_path, block(), *SMALL, *ANY, right=right, wrong=wrong)
    try:
        assert not divided_agree(tmp_path, "1x2x2", 256, monkeypatch)
    except AssertionError:
        pass        # a rank ended the run


@needs_mpi
@pytest.mark.long
def test_memory_is_divided_among_blocks(tmp_path, monkeypatch):
    """Layers of others that a rank has held for a while are given back."""
    for name, value in placed("1x2x2").items():
        monkeypatch.setenv(name, value)
    spec, sites = block(EXCHANGE + FIELD, "cubic(256, 128, n, periodic)", 16, "32768*n"), 32768 * 16
    divided_programs(tmp_path, spec, "-O1", *ANY, main=MEMORY)
    all_ = memory(mpirun(4, "./shared", cwd=tmp_path, OMP_WAIT_POLICY="passive"))
    assert len(all_) == 4 and sum(all_) < 1.35 * 160 * sites


# The command

def cut(spec, asked: str, count: int) -> tuple:
    return grid_of(Rows(prepare(spec, "spherical-midpoint")), asked, count)


def test_auto_takes_the_smallest_surface():
    cube, flat = block(over="cubic(64, n, 64, periodic)", n=64, sites="4096*n"), block(over="cubic(16, 4, n, periodic)", n=40)
    assert [cut(cube, "auto", count) for count in (2, 4, 8, 16)] == [(1, 1, 2), (1, 1, 4), (1, 2, 4), (1, 4, 4)]     # of equal surfaces that with longer rows
    assert cut(flat, "auto", 8) == (1, 1, 8) and cut(flat, "1x2x4", 8) == (1, 2, 4)


REFUSED = [("2x2x2", 4, "these are 8 blocks, but the number of ranks is 4"), ("2x2", 4, "this lattice has 3 directions"), ("2x1x1", 2, "too few vectors of 8 for 2 parts"),
           ("1x5x1", 5, "direction 1 has 4 cells, too few for 5 parts"), ("auto", 7, "there is no grid of 7 ranks")]


@pytest.mark.parametrize("asked, count, said", REFUSED)
def test_what_cannot_be_cut_so_is_refused(asked, count, said):
    with pytest.raises(UsageError, match=re.escape(said)):
        cut(block(), asked, count)


@pytest.mark.parametrize("spec, said", [(block(over="cubic(18, 4, n, periodic)", sites="72*n"), "direction 1 cannot be cut, because 9 slots of a colour, no multiple of 8"),
                                        (block(over="cubic(16, 4, n, periodic)", n=5), "the periodic direction 2 is not a multiple of the number of colours")])
def test_lattices_that_no_grid_cuts_are_refused(spec, said):
    with pytest.raises(UsageError, match=re.escape(said)):
        cut(spec, "1x2x1", 2)


BETWEEN = '[effects.push]\nover = "bond(i, j) of cubic(16, 4, n, periodic)"\ntorque = "0.1*cross(w[i], cross(w[i], w[j]) - w[j])"\n'


def test_torques_on_bonds_count_too():
    assert cut(block(BETWEEN), "1x1x2", 2) == (1, 1, 2)
    with pytest.raises(UsageError, match="the periodic direction 2 is not a multiple of the number of colours"):
        cut(block(EXCHANGE + BETWEEN, "cubic(16, 4, n, open)", 5), "1x1x2", 2)


def test_a_grid_is_three_numbers_or_auto(monkeypatch):
    monkeypatch.setattr(ranks, "grid", None)
    for asked in ("2", "1x2x2", "auto", None):
        ranks.arrange(asked)
        assert ranks.grid == asked
    for asked in ("0x2", "axb", "2x", "", "1x1x1x1x2"):
        with pytest.raises(UsageError, match="give the number of ranks along each direction"):
            ranks.arrange(asked)


# Which of the grids that it is given, in fours of numbers, C takes.
FITS = """#include <stdlib.h>
#include <stdio.h>
#include "{M}.c"
int main(int argc, char **argv) {{
  static const char *names[4] = {{"GRID_0", "GRID_1", "GRID_2", "GRID_3"}};
  {M}_params p;
  {M}_model model;
  smg_coefficients c;
  {M}_defaults(&p);
  int status = {M}_model_init(&model, &p);
  smg_begin(&c, &model, 0);
  for (int k = 1; k + 3 < argc; k += 4) {{
    int64_t ranks = 1;
    for (int d = 0; d < 4; ++d) setenv(names[d], argv[k + d], 1), ranks *= atoi(argv[k + d]);
    printf("%d", smg_grid_fits(&c, ranks));
  }}
  return status;
}}
"""


@needs_mpi
@pytest.mark.parametrize("name", [n if n == "honeycomb" else pytest.param(n, marks=pytest.mark.long) for n in CASES])
def test_the_command_and_c_cut_the_same(tmp_path, name):
    spec = CASES[name][0]
    rows = Rows(prepare(spec, "spherical-midpoint"))
    grids = list(product((1, 2, 3, 4, 5, 8, 9), repeat=len(rows.size)))[1:]
    for file, text in generate(spec).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "fits.c").write_text(FITS.format(M=spec.name))
    subprocess.run(["mpicc", "-DSMG_MPI", "-std=c11", "-w", "-ffp-contract=off", *SMALL, *ANY, *include_flags(), "-I.", "fits.c", "-o", "fits", "-lm"], cwd=tmp_path, check=True)
    said = subprocess.run(["./fits", *(str(n) for grid in grids for n in (*grid, 1, 1, 1)[:4])], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    taken = [grid for grid in grids if not rows.refused(grid)]
    assert [grid for grid, fits in zip(grids, said) if fits == "1"] == taken and len(said) == len(grids)
    assert taken and len(taken) < len(grids)


MAGNET = block(EXCHANGE + FIELD)
GIVEN = ("magnet.toml", "--start", "random", "--h", "0.1", "--steps", "12", "--every", "4", "--what", "states,energy")
DRIVER = """
import importlib, os, sys
from smidgen import ranks
from smidgen.build import binary
from smidgen.cli import main
binary.FLAGS = tuple("-O0" if f == "-O3" else f for f in binary.FLAGS)
run = importlib.import_module("smidgen.run.run")
saves, real = 0, run._save
def save(*given):
    global saves
    real(*given)
    saves += 1
    if os.environ.get("KILL") and saves == 2 and ranks.variable(ranks.RANK) == 1: os._exit(9)
run._save = save
sys.exit(main())
"""


@needs_mpi4py
@pytest.mark.long
def test_a_run_goes_on_with_another_grid(tmp_path, monkeypatch):
    """From a checkpoint of four ranks that were killed, on four and on two in other grids; the file is that of one process. So with memory divided."""
    (tmp_path / "magnet.toml").write_text(MAGNET.sources[0][1])
    (tmp_path / "driver.py").write_text(DRIVER)
    monkeypatch.setenv("CC", f"gcc -Wno-psabi {' '.join(SMALL)}")

    def run(count, *words, **environment):
        return mpirun(count, sys.executable, "driver.py", "run", *words, cwd=tmp_path, **environment)
    assert subprocess.run([sys.executable, "driver.py", "run", *GIVEN, "--out", "one.h5"], cwd=tmp_path, capture_output=True).returncode == 0
    assert run(4, *GIVEN, "--out", "all.h5", "--checkpoint", "2", "--grid", "1x2x2", KILL="1").returncode == 9
    shutil.copytree(tmp_path / "all.h5.checkpoint", tmp_path / "two.h5.checkpoint")
    one = smidgen.load_result(tmp_path / "one.h5")
    for count, name, grid in ((4, "all.h5", "1x4x1"), (2, "two.h5", "auto")):
        said = run(count, "--resume", name, "--grid", grid)
        assert said.returncode == 0, said.stderr
        found = smidgen.load_result(tmp_path / name)
        assert found.w["w"].tobytes() == one.w["w"].tobytes() and found.final.tobytes() == one.final.tobytes()
    said = run(4, *GIVEN, "--no-estimate", "--out", "parts.h5", "--distributed", "--checkpoint", "3", "--grid", "1x2x2")
    assert said.returncode == 0, said.stderr
    parts = smidgen.load_result(tmp_path / "parts.h5")
    assert parts.w["w"].tobytes() == one.w["w"].tobytes() and parts["energy"].tobytes() == one["energy"].tobytes()
    said = run(2, "free_rigid_body", "--steps", "5", "--grid", "auto")
    assert said.returncode == 2 and "can be cut into blocks" in said.stderr
