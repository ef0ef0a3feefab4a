"""Steps of a lattice by the generated solver beside KINSOL of SUNDIALS (kinsol.c), in one process.

    python tests/bench/kinsol.py [--out docs/kinsol.csv]

KINSOL, with operations on vectors compiled as the model is, has Newton with GMRES, as it is and preconditioned by the block of each site, and Anderson's acceleration of fixed points. Needs its header
files (Debian: libsundials-dev). The least time of five turns counts.
"""
from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import smidgen
from lattices import CUBIC, TEXT
from machine import write_table
from smidgen.build.binary import FLAGS, NATIVE
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags

SOURCE = Path(__file__).parent / "kinsol.c"
STEPS = {0.0247: 20, 0.1: 10, 0.2: 5, 0.3: 4, 0.35: 2}
COLUMNS = ["h", "by rows", "smidgen, ns", "sweeps or iterations", "Newton, ns", "iterations", "with blocks, ns", "iterations with blocks", "Anderson, ns", "evaluations", "apart", "energy changed"]


def program(folder: Path) -> Path:
    """The model and KINSOL in one program, and a start beside it."""
    spec = smidgen.load_text(TEXT.format(name="cubic", over=CUBIC[0], sites=CUBIC[1], n=20))
    for file, text in generate(spec).items():
        (folder / file).write_text(text)
    smidgen.build(spec).start("random", h=0.1).w.astype(float).tofile(folder / "start.bin")
    words = ["cc", *(f.replace("c11", "gnu11") for f in FLAGS), *NATIVE, "-Wno-psabi", f'-DSOURCE="{folder}/cubic.c"', "-I", folder, *include_flags(),
             SOURCE, "-lsundials_kinsol", "-lsundials_nvecserial", "-lm", "-o", folder / "steps"]
    subprocess.run([str(w) for w in words], check=True)
    return folder / "steps"


def row(steps: Path, h: float) -> dict:
    said = subprocess.run([steps, str(h), str(STEPS[h]), steps.parent / "start.bin"], capture_output=True, text=True, check=True).stdout
    ours, rows, iterations, apart, energy, *others = said.split()
    return dict(zip(COLUMNS, (h, "yes" if rows == "1" else "no", ours, iterations, *(x if x != "0.0" else "" for x in others), apart, energy)))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/kinsol.csv")
    args = parser.parse_args()
    if not any(Path(where, "kinsol/kinsol.h").exists() for where in ("/usr/include", "/usr/local/include")):
        sys.exit("no KINSOL: apt-get install libsundials-dev")
    with tempfile.TemporaryDirectory() as folder:
        steps = program(Path(folder))
        write_table(args.out, [row(steps, h) for h in STEPS], COLUMNS, f" {' '.join(NATIVE)}")


if __name__ == "__main__":
    main()
