"""Nanoseconds a body and step of an ensemble: in lanes, the same states one by one, and sweeps of a fixed point written by hand in lanes.

    python tests/bench/ensemble.py [ensembles.csv]

All are built with -march=native and take turns in one process; the least time of several rounds counts.
"""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import smidgen
from smidgen.build.binary import FLAGS, NATIVE, write_files
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from machine import machine

HERE = Path(__file__).parent
BODIES = ("free_rigid_body", "irreversible_rigid_body", "forced_rigid_body")
STEPS = (0.025, 0.05, 0.1, 0.2)


def measured(name: str, folder: Path) -> list:
    """Rows (h, in lanes, one by one, by hand or nothing, lanes of a register) of one body."""
    files = generate(smidgen.load(name), features=("ensemble",))
    write_files({file: text for file, text in files.items() if not file.endswith("_abi.c")}, folder)
    words = ["cc", *(f.replace("c11", "gnu11") for f in FLAGS), *NATIVE, "-Wno-psabi", "-I", str(folder), *include_flags(),
             f"-DMODEL={name}", f'-DSOURCE="{folder}/{name}.c"', f"-DBY_HAND={int(name == BODIES[0])}", str(HERE / "ensemble.c"), "-lm", "-o", str(folder / name)]
    subprocess.run(words, check=True)
    said = [subprocess.run([folder / name, str(h)], check=True, capture_output=True, text=True).stdout.split() for h in STEPS]
    return [[h, lanes, alone, hand if name == BODIES[0] else "", *rest] for h, (lanes, alone, hand, *rest) in zip(STEPS, said)]


def main():
    with tempfile.TemporaryDirectory() as folder:
        rows = [[name, *row] for name in BODIES for row in measured(name, Path(folder))]
    with open(sys.argv[1], "w", newline="") if len(sys.argv) > 1 else sys.stdout as out:
        print(f"# ns a body and step, 1000 members, 1000 steps; {machine()} {' '.join(NATIVE)}", file=out)
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["body", "h", "lanes_ns", "one_by_one_ns", "by_hand_ns", "lanes_in_a_register", "differing_states"])
        table.writerows(rows)


if __name__ == "__main__":
    main()
