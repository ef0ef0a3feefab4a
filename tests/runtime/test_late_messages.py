"""Bits of ranks when messages are late and overtake each other, when fresh memory is not zero, and under valgrind's memcheck."""
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from test_ranks import MPI, SMALL, mpirun, needs_mpi, programs
from test_rows import SPECS

LATE = Path(__file__).parents[1] / "runtime" / "late_messages.c"
CASES = ("plain cubic", "odd cubic", "ring of 601", "honeycomb", "three colours")
RUNS = int(os.environ.get("SMIDGEN_RANK_RUNS", "200"))      # of each case in the long tier; SMIDGEN_RANK_RUNS=2500 makes 10,000
needs_valgrind = pytest.mark.skipif(not shutil.which("valgrind"), reason="no valgrind: apt-get install valgrind")


def wanted(where) -> bytes:
    """The state that one process ends with."""
    subprocess.run(["./serial", "serial"], cwd=where, check=True, env={**os.environ, **MPI})
    return (where / "serial.0").read_bytes()


def check_late_runs(where, name, runs, **planted):
    """Each run with delays of its own, fresh memory filled with another byte, on 2 and 3 ranks in turn."""
    programs(where, SPECS[name], *SMALL, **planted)
    subprocess.run(["mpicc", "-O1", "-shared", "-fPIC", str(LATE), "-o", "late.so"], cwd=where, check=True)
    bits = wanted(where)
    for run in range(runs):
        ranks = 2 + run % 2
        said = mpirun(ranks, "env", f"LD_PRELOAD={where / 'late.so'}", f"LATE_SEED={run + 1}", f"MALLOC_PERTURB_={run % 255 + 1}", "./shared", "of", cwd=where)
        assert said.returncode == 0, said.stderr
        assert [(where / f"of.{k}").read_bytes() == bits for k in range(ranks)] == [True] * ranks, f"run {run}"


@needs_mpi
def test_late_messages_change_no_bit(tmp_path):
    check_late_runs(tmp_path, "odd cubic", 2)


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_late_messages_change_no_bit_in_many_runs(tmp_path, name):
    check_late_runs(tmp_path, name, RUNS)


@needs_mpi
@pytest.mark.long
@needs_valgrind
@pytest.mark.parametrize("name", CASES)
def test_no_rank_reads_what_was_never_written(tmp_path, name):
    """Of what memcheck says, what a function of smidgen or of the program takes part in; the MPI library has reports of its own."""
    programs(tmp_path, SPECS[name], *SMALL, "-g", "-DSMG_LANES=2")
    assert reports(tmp_path, SPECS[name].name) == []
    assert [(tmp_path / f"of.{k}").read_bytes() == wanted(tmp_path) for k in range(2)] == [True] * 2


@needs_mpi
@pytest.mark.long
@needs_valgrind
def test_memcheck_sees_arrays_that_are_not_cleared(tmp_path):
    spec = SPECS["odd cubic"]
    programs(tmp_path, spec, *SMALL, "-g", "-DSMG_LANES=2", right="for (size_t k = 0; k < used; ++k) mem[k] = 0;", wrong="(void)used;")
    assert reports(tmp_path, spec.name) != []


def reports(where, name: str) -> list:
    """What memcheck says of functions of smidgen or of the model in a run on two ranks."""
    said = mpirun(2, "valgrind", "-q", "--log-file=memcheck.%p", "./shared", "of", cwd=where)
    assert said.returncode == 0, said.stderr
    found = [block for log in where.glob("memcheck.*") for block in re.split(r"==\d+== \n", log.read_text())]
    return [block for block in found if innermost(block).startswith(("smg_", name))]


def innermost(block: str) -> str:
    """The innermost function of a report."""
    found = re.search(r"at 0x[0-9A-F]+: (\S+)", block)
    return found[1] if found else ""
