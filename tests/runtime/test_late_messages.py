"""Bits of ranks when messages are late and overtake each other, when fresh memory is not zero, and under valgrind's memcheck."""
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from smidgen.resources import folder
from test_ranks import LONG, MPI, SMALL, mpirun, needs_mpi, programs

LATE = Path(__file__).parent / "late_messages.c"
RANKS = [folder("runtime") / "lattice" / name for name in ("smg_row_ranks.h", "smg_row_halo.h")]
CASES = tuple(LONG)
RUNS = int(os.environ.get("SMIDGEN_RANK_RUNS", "1000"))     # of each case in the long tier, over 10,000 together
TIMES = 25              # runs of one start of the ranks, each in fresh memory full of another byte
needs_valgrind = pytest.mark.skipif(not shutil.which("valgrind"), reason="no valgrind: apt-get install valgrind")


def wanted(where) -> bytes:
    """The state that one process ends with."""
    subprocess.run(["./serial", "serial"], cwd=where, check=True, env={**os.environ, **MPI})
    return (where / "serial.0").read_bytes()


def preloaded(where) -> None:
    """late.so, and programs that call no other function of MPI that begins or completes a message."""
    subprocess.run(["mpicc", "-O1", "-Wall", "-Werror", "-shared", "-fPIC", str(LATE), "-o", "late.so"], cwd=where, check=True)
    called = set(re.findall(r"\bMPI_(?:I?[sr]end|I?recv|Wait|Test|Start|Send|Recv)\w*(?=\()", "".join(p.read_text() for p in RANKS)))
    assert called <= set(re.findall(r"^int (MPI_\w+)", LATE.read_text(), re.MULTILINE))


def late_run(where, ranks, run, times=1):
    """Some runs with delays of their own, fresh memory filled with a byte of its own; what they said, or None where they did not end."""
    words = ("env", f"LD_PRELOAD={where / 'late.so'}", f"LATE_SEED={run + 1}", f"MALLOC_PERTURB_={run % 255 + 1}", "./shared", "of", times)
    try:
        return mpirun(ranks, *words, cwd=where, limit=60 + 4 * times)
    except subprocess.TimeoutExpired:
        return None


def check_late_runs(where, name, runs, times):
    """On 2 and 3 ranks in turn, which send each other messages; every so many runs processes start anew."""
    programs(where, LONG[name], *SMALL)
    preloaded(where)
    bits = wanted(where)
    for run in range(-(-runs // times)):
        ranks = 2 + run % 2
        said = late_run(where, ranks, run, times)
        assert said is not None and said.returncode == 0, said and said.stderr
        assert min(map(int, re.findall(r"late_messages: (\d+)", said.stderr))) > 100 * times
        assert [(where / f"of.{k}").read_bytes() == bits for k in range(ranks)] == [True] * ranks, f"run {run}"


WAIT = "    MPI_Waitall(smg_halo.messages[colour], smg_halo.message[colour], MPI_STATUSES_IGNORE);"
# what is wrong with messages -> the lines, and what stands there instead
FAULTS = {"no wait": (WAIT, "    (void)0;"),
          "a test in place of a wait": (WAIT, "  {\n    int all = 0;\n    MPI_Testall(smg_halo.messages[colour], smg_halo.message[colour], &all, MPI_STATUSES_IGNORE);\n  }"),
          "no wait for the late ones": ("  for (int64_t colour = 1; colour < SMG_COLOURS; ++colour) smg_await_colour(colour);\n", ""),
          "one request is not waited for": (WAIT, WAIT.replace("messages[colour],", "messages[colour] - 1,")),
          "what is sent is turned again": ("inner = {all.from + first, all.to - last}", "inner = {all.from, all.to - last}"),
          "what is read is not all waited for": ("  MPI_Waitall(2 * smg_halo.partners, asked, MPI_STATUSES_IGNORE);", "  MPI_Waitall(2 * smg_halo.partners - 1, asked, MPI_STATUSES_IGNORE);")}


@needs_mpi
@pytest.mark.parametrize("name, fault", [("long cubic", "a test in place of a wait"), *(pytest.param("long cubic", fault, marks=pytest.mark.long) for fault in FAULTS),
                                         *(pytest.param(name, "no wait", marks=pytest.mark.long) for name in CASES[1:])])
def test_a_message_that_is_not_waited_for_is_noticed(tmp_path, name, fault):
    """At the first of some runs, or at one of them; without late.so most of these faults pass unnoticed here."""
    right, wrong = FAULTS[fault]
    programs(tmp_path, LONG[name], *SMALL, right=right, wrong=wrong)
    preloaded(tmp_path)
    bits = wanted(tmp_path)

    def noticed(run):
        said = late_run(tmp_path, 2, run)
        return said is None or said.returncode != 0 or any((tmp_path / f"of.{k}").read_bytes() != bits for k in range(2))
    assert any(noticed(run) for run in range(5))


@needs_mpi
def test_late_messages_change_no_bit(tmp_path):
    check_late_runs(tmp_path, "long cubic", 4, 2)


@needs_mpi
@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_late_messages_change_no_bit_in_many_runs(tmp_path, name):
    check_late_runs(tmp_path, name, RUNS, TIMES)


@needs_mpi
@pytest.mark.long
@needs_valgrind
@pytest.mark.parametrize("name", CASES)
def test_no_rank_reads_what_was_never_written(tmp_path, name):
    """Of what memcheck says, what a function of smidgen or of the program takes part in; the MPI library has reports of its own."""
    programs(tmp_path, LONG[name], *SMALL, "-g", "-DSMG_LANES=2")
    assert reports(tmp_path, LONG[name].name) == []
    assert [(tmp_path / f"of.{k}").read_bytes() == wanted(tmp_path) for k in range(2)] == [True] * 2


@needs_mpi
@pytest.mark.long
@needs_valgrind
def test_memcheck_sees_arrays_that_are_not_cleared(tmp_path):
    spec = LONG["long cubic"]
    programs(tmp_path, spec, *SMALL, "-g", "-DSMG_LANES=2", right="for (size_t k = (size_t)kept; k < used; ++k) mem[k] = 0;", wrong="(void)used;")
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
