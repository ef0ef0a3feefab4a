"""Threads that share the rows of a lattice, under ThreadSanitizer: no number is written by one and read by another without an order between them.

The functions of OpenMP that gcc calls are those of tests/runtime/omp_in_sight.c, for the sanitizer does not see what the library's own make wait.
Vectors of lanes load more than they use: slots that are masked out afterwards, which another thread may be writing. So there is one lane here,
and beyond the ends of a ring only the value that is used is read (EXACT); the same bits with vectors are for tests/runtime/test_rows.py to show.
"""
import os
import subprocess
from pathlib import Path

import pytest
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from smidgen.run.step.start import initial_state
from test_ranks import LONG, MAIN
from test_rows import SPECS

EXACT = ("  smg_take_slots(all, pitch, run->start + b->start + j, v);\n  if (!around",
         "  if (around && !smg_all_within(b, p, 1)) {\n    smg_take_slots(all, pitch, run->start + b->around + j, v);\n    return;\n  }\n"
         "  smg_take_slots(all, pitch, run->start + b->start + j, v);\n  if (!around")
OMP = Path(__file__).parent / "omp_in_sight.c"
SMALL = ("-DSMG_SHARE=8", "-DSMG_LANES=1")
WAVE = ("-DSMG_SHARE=8", "-DSMG_LANES=1", "-DSMG_WAVE_FROM=0", "-DSMG_WAVE_BLOCK=8", "-DSMG_BLOCKS_TO=0", "-DSMG_LARGE_PLANE=100")
SUBLATTICES = "sublattice-rotations"
# name -> (spec, method, macros): by shares of a colour, by stages of a wavefront, by turns of sublattices
CASES = {"shares": (LONG["long cubic"], "spherical-midpoint", SMALL), "shares with a field": (LONG["long open cubic"], "spherical-midpoint", SMALL),
         "blocks": (SPECS["plain cubic"], "spherical-midpoint", SMALL), "wavefront of a ring": (LONG["ring of 600"], "spherical-midpoint", WAVE),
         "wavefront of planes": (LONG["long cubic"], "spherical-midpoint", WAVE), "three colours": (LONG["three colours along"], "spherical-midpoint", SMALL),
         "damped shares": (LONG["damped cubic"], "spherical-midpoint", SMALL), "warm shares": (LONG["warm cubic"], "spherical-midpoint", SMALL), "damped wavefront": (LONG["damped cubic"], "spherical-midpoint", WAVE),
         "sublattices": (LONG["long cubic"], SUBLATTICES, SMALL)}
# what is wrong -> (the case, the line, what stands there instead)
FAULTS = {"a maximum without a lock": ("shares", "#define SMG_ONE_BY_ONE SMG_PRAGMA(omp critical)", "#define SMG_ONE_BY_ONE"),
          "shares that overlap": ("shares", "smg_part_of(all, smg_thread(), smg_threads());", "smg_part_of(all, smg_thread() / 2, smg_threads());"),
          "stages that do not wait": ("wavefront of a ring", "omp for schedule(dynamic, 1))", "omp for schedule(dynamic, 1) nowait)")}


def sanitizes(where) -> bool:
    """Does gcc have the sanitizer, and does what it makes run here?"""
    (where / "empty.c").write_text("int main(void) { return 0; }\n")
    made = subprocess.run(["gcc", "-fsanitize=thread", "empty.c", "-o", "empty"], cwd=where, capture_output=True, check=False)
    return made.returncode == 0 and subprocess.run(["./empty"], cwd=where, capture_output=True, check=False).returncode == 0


def report(where, case, right="", wrong="", threads=3) -> str:
    """What the sanitizer says of a run on three threads; "" where it saw nothing and the bits are those of one thread."""
    if not sanitizes(where):
        pytest.skip("gcc has no ThreadSanitizer that runs here")
    spec, method, macros = CASES[case]
    for name, text in generate(spec, method, amalgamate=True).items():
        assert name != f"{spec.name}.c" or right in text and EXACT[0] in text
        (where / name).write_text(text.replace(*EXACT).replace(right, wrong) if right else text.replace(*EXACT))
    (where / "main.c").write_text(MAIN.format(M=spec.name))
    initial_state(spec, "random").astype(float).tofile(where / "start.bin")
    words = ["gcc", "-std=gnu11", "-O1", "-g", "-w", "-ffp-contract=off", "-fopenmp", "-fsanitize=thread", *macros, *include_flags(), "-I."]
    subprocess.run([*words, "main.c", f"{spec.name}.c", str(OMP), "-lm", "-lpthread", "-o", "shared"], cwd=where, check=True)
    found = [subprocess.run(["./shared", f"of{n}"], cwd=where, capture_output=True, text=True, check=False, env={**os.environ, "OMP_NUM_THREADS": str(n)}) for n in (1, threads)]
    same = (where / "of1.0").read_bytes() == (where / f"of{threads}.0").read_bytes()
    return "".join(run.stderr for run in found) + "other bits" * (not same)


@pytest.mark.parametrize("case", [name if name == "shares" else pytest.param(name, marks=pytest.mark.long) for name in CASES])
def test_no_thread_reads_what_another_may_be_writing(tmp_path, case):
    assert report(tmp_path, case) == ""


@pytest.mark.parametrize("fault", [name if name == "a maximum without a lock" else pytest.param(name, marks=pytest.mark.long) for name in FAULTS])
def test_races_are_seen(tmp_path, fault):
    assert "data race" in report(tmp_path, *FAULTS[fault])
