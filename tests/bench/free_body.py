"""One step of the free rigid body at h = 0.1: generated code beside hand-written C of the same method.

    python tests/bench/free_body.py [--out docs/free_body.csv] [--repeats 61] [--steps 20000]

Same flags, same start, same stop (no component moves by more than a unit in its last place). The hand-written
designs have no status, no branch check and no carry. All take turns in one process; the ratio is of medians.
"""
from __future__ import annotations

import argparse
import csv
import io
import subprocess
import tempfile
from pathlib import Path

import smidgen
from machine import write_table
from smidgen.build.binary import FLAGS, find_compiler
from smidgen.compile.emit.emit import generate
from smidgen.resources import folder, include_flags

HERE = Path(__file__).parent / "free_body"
DEGREES = (5, 6)


def compile_all(place: Path) -> Path:
    """The driver with the hand-written designs, the prototype and the generated model."""
    files = generate(smidgen.load(str(folder("specs") / "free_rigid_body.toml")))
    for name, text in files.items():
        (place / name).write_text(text)
    common = [*find_compiler(), *FLAGS, "-D_POSIX_C_SOURCE=200809L", f"-I{HERE}", *include_flags(), f"-I{place}"]
    objects = []
    sources = [(HERE / "bench.c", ()), (HERE / "hand.c", ()), (HERE / "generated.c", ()), (place / "free_rigid_body.c", ())]
    sources += [(HERE / "generic_prototype.c", (f"-DDEGREE={d}",)) for d in DEGREES]
    for k, (source, more) in enumerate(sources):
        objects.append(str(place / f"{k}.o"))
        subprocess.run([*common, *more, "-c", str(source), "-o", objects[-1]], check=True)
    program = place / "bench"
    subprocess.run([*common, *objects, "-lm", "-o", str(program)], check=True)
    return program


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/free_body.csv")
    parser.add_argument("--repeats", type=int, default=61)
    parser.add_argument("--steps", type=int, default=20000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        program = compile_all(Path(place))
        said = subprocess.run([str(program), str(options.repeats), str(options.steps)], check=True,
                              capture_output=True, text=True).stdout
    rows = list(csv.DictReader(io.StringIO(said)))
    hand = [r for r in rows if not r["design"].startswith(("gener", "generic"))]
    best = {key: min(float(r[key]) for r in hand) for key in ("min ns", "median ns")}
    for r in rows:
        r["ratio of medians"] = f"{float(r['median ns']) / best['median ns']:.2f}"
        r["ratio of minima"] = f"{float(r['min ns']) / best['min ns']:.2f}"
    write_table(options.out, rows)


if __name__ == "__main__":
    main()
