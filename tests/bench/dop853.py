"""Dormand and Prince of order 8: generated code beside C written by hand for one system, in time and in instructions.

    python tests/bench/dop853.py                 # a minute: docs/dop853.csv
    python tests/bench/dop853.py --instructions  # also by callgrind, which other work on the machine does not disturb
    python tests/bench/dop853.py --native        # all compiled for this processor

The free body and four vortices, each with a carry of what sums lose and without; one compiler, the same flags, the same control of
the step, the same ends to round-off. All take turns in one process: a ratio is that of neighbours in time, and the table has its
median and its quartiles.
"""
from __future__ import annotations

import argparse
import dataclasses
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import smidgen
from machine import write_table
from smidgen.build.binary import FLAGS, NATIVE, find_compiler
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from smidgen.run.settings import settle
from smidgen.run.step.start import initial_state

HERE, OUT = Path(__file__).with_name("dop853"), Path(__file__).resolve().parents[2] / "docs" / "dop853.csv"
SYSTEMS = {"free_rigid_body": 1, "point_vortices": 2}       # SYSTEM of hand.c
TOLERANCE = 1e-12       # of the method itself
HS = (0.1, 10.0)        # one step of the method in each step of the run, and many
SECONDS = 1e-3          # of one measurement
PAIRS = {"sums with a carry": ("generated", "hand_carry"), "plain sums": ("generated_plain", "hand"), "with a carry beside plain": ("generated", "hand")}
SAME = 1e-11            # the ends differ by round-off and its growth
COLUMNS = ("system", "h", "compared", "generated_ns", "hand_ns", "ratio", "lower_quartile", "upper_quartile", "instructions", "hand_instructions", "instruction_ratio")


def compiled(name: str, place: Path, more=()) -> Path:
    """The program of all contenders on a system."""
    flags = [*find_compiler(), *FLAGS, *more, "-D_POSIX_C_SOURCE=200809L", f"-I{HERE}", *include_flags(), f"-I{place}", f"-DSYSTEM={SYSTEMS[name]}"]
    sources = [(HERE / "bench.c", ()), *((HERE / "hand.c", (f"-DNAME={n}", f"-DCARRY={c}")) for n, c in (("hand", 0), ("hand_carry", 1)))]
    for model, own in (("generated", ()), ("generated_plain", ("-DSMG_PLAIN_SUMS=1",))):
        for file, text in generate(dataclasses.replace(smidgen.load(name), name=f"{model}_model"), "dop853").items():
            (place / file).write_text(text)
        sources += [(place / f"{model}_model.c", own), (HERE / "generated.c", (f"-DNAME={model}", f"-DNAME_OF_MODEL={model}_model", f'-DHEADER="{model}_model.h"'))]
    objects = [place / f"{k}.o" for k in range(len(sources))]
    for (source, own), to in zip(sources, objects):
        subprocess.run([*flags, *own, "-c", source, "-o", to], check=True)
    subprocess.run([*find_compiler(), *objects, "-lm", "-o", place / "bench"], check=True)
    return place / "bench"


def asked(program, h: float, steps: int, what, w, before=()) -> subprocess.CompletedProcess:
    """What it says."""
    return subprocess.run([*before, program, repr(h), repr(TOLERANCE), str(steps), str(what), *(f"{x:.17g}" for x in w)], check=True, capture_output=True, text=True)


def instructions(program, h: float, name: str, w, steps=(100, 300)) -> float:
    """Of one step of a contender: the difference of two runs, by callgrind."""
    tool = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null")
    counts = [int(re.search(r"Collected : (\d+)", asked(program, h, n, name, w, tool).stderr)[1]) for n in steps]
    return (counts[1] - counts[0]) / (steps[1] - steps[0])


def checked(program, h: float, w) -> None:
    """Do all get to the same end?"""
    ends = {line.split(",")[0]: np.array(line.split(",")[1:], float) for line in asked(program, h, round(20 / h), 0, w).stdout.split()}
    apart = max(np.abs(end - ends["hand"]).max() for end in ends.values())
    if not apart < SAME:
        raise SystemExit(f"dop853.py: the ends differ by {apart:.1e}")


def rows_of(name: str, repeats: int, counted: bool, more) -> list[dict]:
    """Rows of one system."""
    spec = smidgen.load(name)
    settings, rows = settle(spec), []
    w = np.array(initial_state(spec, settings.start, settings.parameters, settings.seed), float).ravel()
    with tempfile.TemporaryDirectory() as place:
        program = compiled(name, Path(place), more)
        for h in HS:
            checked(program, h, w)
            once = max(float(x) for x in asked(program, h, 20, 1, w).stdout.split(","))
            steps = max(1, round(1e9 * SECONDS / once))
            table = np.array([line.split(",") for line in asked(program, h, steps, repeats, w).stdout.split()], float)
            ns = dict(zip(("hand", "hand_carry", "generated", "generated_plain"), table.T))
            count = {n: instructions(program, h, n, w) for n in ns} if counted else {}
            rows += [row(name, h, said, ns[a], ns[b], count.get(a), count.get(b)) for said, (a, b) in PAIRS.items()]
    return rows


def row(name: str, h: float, said: str, ns, hand, count, hand_count) -> dict:
    """One line of the table."""
    low, middle, high = np.percentile(ns / hand, (25, 50, 75))
    counts = (f"{count:.0f}", f"{hand_count:.0f}", f"{count / hand_count:.3f}") if count else ("", "", "")
    return dict(zip(COLUMNS, (name, h, said, f"{np.median(ns):.4g}", f"{np.median(hand):.4g}", f"{middle:.3f}", f"{low:.3f}", f"{high:.3f}", *counts)))


def words(rows) -> str:
    """Markdown."""
    lines = ["| system | h | compared | generated, ns a step of h | by hand | ratio | quartiles | ratio of instructions |", "|---|---|---|---|---|---|---|---|"]
    for r in rows:
        lines.append(f"| {r['system']} | {r['h']} | {r['compared']} | {r['generated_ns']} | {r['hand_ns']} | {r['ratio']} | {r['lower_quartile']} to {r['upper_quartile']} | {r['instruction_ratio'] or '-'} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, write, tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="SPEC", default=list(SYSTEMS))
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--repeats", type=int, default=401)
    parser.add_argument("--instructions", action="store_true")
    parser.add_argument("--native", action="store_true")
    args = parser.parse_args()
    rows = [r for name in args.names for r in rows_of(name, args.repeats, args.instructions, NATIVE if args.native else ())]
    write_table(args.out, rows, COLUMNS, " -march=native" * args.native)
    print(words(rows))


if __name__ == "__main__":
    sys.exit(main())
