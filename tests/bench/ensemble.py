"""Ensembles: members in lanes beside the same members one by one.

    python tests/bench/ensemble.py [ensembles.csv [trajectories.csv]]

ensembles.csv: nanoseconds a body and step of the spherical midpoint and of its composition of order 4, beside sweeps of a fixed point written by hand in lanes.
trajectories.csv: microseconds a trajectory from t = 0 to 100 by methods that choose their own steps and by one of order 12 that does not, and how far 1000 random bodies then are from where
Gauss of order 16 has them in extended precision (step 1/2).

All are built with -march=native and take turns in one process; the least time of several rounds counts.
"""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import smidgen
from smidgen.build.binary import FLAGS, NATIVE, write_files
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from machine import machine

HERE = Path(__file__).parent
BODIES = ("free_rigid_body", "irreversible_rigid_body", "forced_rigid_body")
STEPS, METHODS = (0.025, 0.05, 0.1, 0.2), ("spherical-midpoint", "spherical-midpoint-4")
OWN_STEPS, END, MEMBERS = ("dop853", "dop853-projected"), 100, 1000
TOLERANCES = (1e-9, 1e-11, 1e-12, 1e-13)
EXTRAPOLATION, COUNTS = "extrapolation-12", {BODIES[0]: (80, 100, 120, 140, 200), BODIES[1]: (120, 200, 300, 400)}     # steps


def compiled(name: str, folder: Path, source: str, *more, method: str = "spherical-midpoint") -> Path:
    """The program of a body."""
    files = generate(smidgen.load(name), method=method, features=("ensemble",))
    write_files({file: text for file, text in files.items() if not file.endswith("_abi.c")}, folder)
    words = ["cc", *(f.replace("c11", "gnu11") for f in FLAGS), *NATIVE, "-Wno-psabi", "-I", str(folder), *include_flags(),
             f"-DMODEL={name}", f'-DSOURCE="{folder}/{name}.c"', *more, str(HERE / source), "-lm", "-o", str(folder / name)]
    subprocess.run(words, check=True)
    return folder / name


def said(*words) -> list:
    return subprocess.run([*map(str, words)], check=True, capture_output=True, text=True).stdout.splitlines()


def measured(name: str, method: str, folder: Path) -> list:
    """Rows (h, in lanes, one by one, by hand or nothing, lanes of a register) of one body."""
    by_hand = name == BODIES[0] and method == METHODS[0]
    program = compiled(name, folder, "ensemble.c", f"-DBY_HAND={int(by_hand)}", method=method)
    found = [said(program, h)[0].split() for h in STEPS]
    return [[h, lanes, alone, hand if by_hand else "", *rest] for h, (lanes, alone, hand, *rest) in zip(STEPS, found)]


def starts() -> np.ndarray:
    w = np.random.default_rng(1).standard_normal((MEMBERS, 3))
    return w / np.linalg.norm(w, axis=1)[:, None]


def reference(name: str, w) -> np.ndarray:
    model = smidgen.build(smidgen.load(name), method="gauss-16", real="long double")
    return np.array([model.start(one[None].astype(np.longdouble), 0, 0.5).steps(2 * END).w[0].astype(float) for one in w])


def trajectories(name: str, folder: Path) -> list:
    """Rows (method, tolerance, errors, in lanes, one by one, steps, lanes of a register, differing states) of one body."""
    w, rows = starts(), []
    np.savetxt(folder / "starts", w, fmt="%.17g")
    exact = reference(name, w)
    for method, asked in (*((one, [(1, tolerance) for tolerance in TOLERANCES]) for one in OWN_STEPS), (EXTRAPOLATION, [(n, 0) for n in COUNTS[name]])):
        program = compiled(name, folder, "ensemble_tolerance.c", method=method)
        for count, tolerance in asked:
            times, *ends = said(program, END, count, tolerance, folder / "starts")
            error = np.abs(np.array([line.split() for line in ends], float) - exact).max(axis=1)
            lanes, alone, *rest = times.split()
            rows.append([method, tolerance or "", *(f"{np.quantile(error, part):.2g}" for part in (0.5, 0.9, 1)), lanes, alone, *rest])
    return rows


def write(file, said: str, columns, rows):
    with open(file, "w", newline="") if file else sys.stdout as out:
        print(f"# {said}; {machine()} {' '.join(NATIVE)}", file=out)
        table = csv.writer(out, lineterminator="\n")
        table.writerow(columns)
        table.writerows(rows)


def main(steps=None, whole=None):
    with tempfile.TemporaryDirectory() as folder:
        rows = [[name, method, *row] for method in METHODS for name in BODIES for row in measured(name, method, Path(folder))]
        write(steps, "ns a body and step, 1000 members, 1000 steps",
              ["body", "method", "h", "lanes_ns", "one_by_one_ns", "by_hand_ns", "lanes_in_a_register", "differing_states"], rows)
        if whole:
            rows = [[name, *row] for name in BODIES[:2] for row in trajectories(name, Path(folder))]
            write(whole, "us a trajectory to t = 100, 1000 random starts; errors: of half of them at most, of nine in ten, of all",
                  ["body", "method", "tolerance", "median_error", "error_of_90_percent", "largest_error", "lanes_us", "one_by_one_us", "steps",
                   "lanes_in_a_register", "differing_states"], rows)


if __name__ == "__main__":
    main(*sys.argv[1:])
