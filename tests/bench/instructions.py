"""Instructions a step of every kernel of speed.md, ensembles.csv and explicit.csv: what other work on the machine does not disturb.

    python tests/bench/instructions.py                                    # some minutes: docs/instructions.csv
    python tests/bench/instructions.py --only gauss --out out/now.csv     # rows whose spec, method or layout has this text
    python tests/bench/instructions.py --out out/now.csv --against docs/instructions.csv

Each model is compiled once, for any processor of this architecture (no -march=native), and takes N and 2 N steps under callgrind: the difference, divided by N (and by
the members of an ensemble), is what a step costs once the history is full. `--against` prints the ratios to another table; the exit code is 1 where one is
above --limit. Counts of one compiler are the same on every machine; those of two are not to be compared.
If round-off decides in which steps there is one more iteration, N is so large that this hardly matters: a run of 16 spins takes 108 iterations by Newton in one hundred
steps and 122 in the next.
"""
from __future__ import annotations

import argparse
import csv
import datetime
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import smidgen
from few import SPINS, random_graph
from lattices import CHAIN, CUBIC, TEXT
from smidgen.build.binary import FLAGS, compiler_version, find_compiler
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.resources import include_flags
from smidgen.run.step.start import initial_state

HERE = Path(__file__).parent
OUT = HERE.parents[1] / "docs" / "instructions.csv"
KEY = ("spec", "method", "h", "layout")
COLUMNS = (*KEY, "steps", "instructions")
CALLGRIND = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null")
BODIES = ("free_rigid_body", "irreversible_rigid_body", "forced_rigid_body")
SQUARE = ("square(n, n, periodic)", "n*n")
MEMBERS = 16
DAMPED = """
[effects.damping]
over = "site(i) of w"
damping = "0.1"
"""
WARM = DAMPED + 'kT = "0.3"\n'
MIDPOINT = "spherical-midpoint"
BY_SITES = ("-DSMG_ROW_BOUND=0",)       # no h is small enough for a state by rows


@dataclass(frozen=True)
class Kernel:
    """One row: spec is a file's name or has its text in `text`; values and start are its defaults and its first where nothing is said; pushed: vectors that the tangent map carries along;
    flags: more of the compiler."""
    spec: str
    method: str = MIDPOINT
    h: float = 0.1
    layout: str = "sites"
    steps: int = 100
    text: str = ""
    values: tuple = ()
    start: str = ""
    tolerance: float = 0
    solver: str = "auto"
    features: tuple = ()
    members: int = 1
    pushed: int = 0
    flags: tuple = ()

    @property
    def key(self) -> tuple:
        return self.spec, self.method, str(self.h), self.layout


def lattice(name: str, over: str, sites: str, n: int, start: str, h: float, layout: str, more: str = "", **rest) -> Kernel:
    """Exchange on a lattice, as lattices.py has it."""
    return Kernel(f"{name} {n}{' ' + start if start != 'random' else ''}", h=h, layout=layout, start=start, steps=4 if sites_of(sites, n) > 1e5 else 12,
                  text=TEXT.format(name="lattice", over=over, sites=sites, n=n) + more, **rest)


def sites_of(sites: str, n: int) -> int:
    return n ** (sites.count("n"))


def lattices() -> list:
    """Rows of lattices.csv and explicit.csv; the large ones are as large as it takes for wavefronts."""
    small, large, flat, wide = ("cubic", *CUBIC, 20, "random"), ("cubic", *CUBIC, 76, "random"), ("square", *SQUARE, 90, "random"), ("square", *SQUARE, 660, "random")
    rings = [("chain", *CHAIN, 100, "smooth"), ("chain", *CHAIN, 100, "random")]
    found = [lattice(*small, h, "rows") for h in (0.0247, 0.15, 0.2)]
    found += [lattice(*one, 0.0247, "rows") for one in (large, flat, wide)] + [lattice(*one, 0.1, "rows") for one in (*rings, ("chain", *CHAIN, 400_000, "smooth"))]
    found += [lattice(*one, 0.0247, "rows to 1e-12", tolerance=1e-12) for one in (small, large)]
    found += [lattice(*one, 0.0247, "site to site", flags=BY_SITES) for one in (small, flat)] + [lattice(*one, 0.1, "site to site", flags=BY_SITES) for one in rings]
    found += [lattice(*one, 0.0247, "rows", method="sublattice-rotations") for one in (small, large, flat)]
    found += [lattice(*one, 0.0247, "rows", method="pair-rotations") for one in (small, large)]
    found += [replace(lattice(*small, 0.1, "rows", method="gauss-4"), steps=24)]
    found += [lattice(*small, 0.1, "rows", method=method) for method in ("gauss-8", "spherical-midpoint-4", "sublattice-rotations-4")]
    found += [lattice(*small, 0.0247, "rows, damped", DAMPED), lattice(*small, 0.0247, "rows, thermal", WARM)]
    return found


def few(folder: str) -> list:
    """Rows of few.csv, scaling.csv and dop853.csv, and one body."""
    random_graph(folder)
    sites = [Kernel("point_vortices"), Kernel("spins 16", text=SPINS), Kernel("random graph", text=str(Path(folder, "graph.toml")), steps=4)]
    sites += [Kernel("point_vortices", layout="newton", solver="newton"), Kernel("spins 16", layout="newton", solver="newton", steps=400, text=SPINS)]
    sites += [Kernel(name, values=values, steps=10) for name, values in (("heisenberg_chain", (("n", 100),)), ("j1j2_chain", (("n", 100),)),
                                                                         ("cubic_lattice", (("nx", 5), ("ny", 5), ("nz", 4))), ("honeycomb", (("nx", 10), ("ny", 5))))]
    methods = ("dop853", "extrapolation-12", "gauss-4", "gauss-8", "spherical-midpoint-4", "classical-midpoint", "cf4", "rattle")
    return sites + [Kernel(name, method) for name in ("free_rigid_body", "point_vortices") for method in methods] + [Kernel("free_rigid_body", "dop853", 10.0, steps=20)]


def members() -> list:
    """Rows of ensembles.csv, and the methods of trajectories.csv: in lanes, and one by one."""
    rows = [(name, MIDPOINT, h) for name in BODIES for h in (0.025, 0.05, 0.1, 0.2)]
    rows += [(name, method, h) for name in BODIES[:2] for method, h in (("dop853", 100.0), ("dop853-projected", 100.0), ("extrapolation-12", 1.0))]
    how = (("lanes", ("ensemble",)), ("one by one", ()))
    return [Kernel(name, method, h, layout, 2 if h == 100 else 40, features=features, members=MEMBERS) for name, method, h in rows for layout, features in how]


def kernels(folder: str) -> list:
    found = [*few(folder), *members(), *lattices()]
    assert len({k.key for k in found}) == len(found)
    return found


def spec_of(kernel: Kernel):
    """Its spec, with its values as defaults."""
    text = kernel.text
    spec = smidgen.load(Path(text)) if text.endswith(".toml") else smidgen.load_text(text) if text else smidgen.load(kernel.spec)
    return select(spec, None, dict(kernel.values))


def starts_of(kernel: Kernel, spec) -> np.ndarray:
    """Of all members, the numbers of one after those of the other."""
    if kernel.members > 1:
        w = np.random.default_rng(1).standard_normal((kernel.members, 3))
        return w / np.linalg.norm(w, axis=1)[:, None]
    return initial_state(spec, kernel.start or spec.starts[0].name)


def compiled(kernel: Kernel, spec, place: Path, more=()) -> Path:
    """The program of a kernel, with its starts beside it; more: flags."""
    for file, text in generate(spec, kernel.method, kernel.solver, features=kernel.features).items():
        (place / file).write_text(text)
    np.asarray(starts_of(kernel, spec), float).tofile(place / "starts")
    own = (f"-DMODEL={spec.name}", f'-DSOURCE="{place}/{spec.name}.c"', f"-DLANES={int('ensemble' in kernel.features)}", f"-DPUSHED={kernel.pushed}", *kernel.flags)
    subprocess.run([*find_compiler(), *FLAGS, *more, "-I", place, *include_flags(), *own, HERE / "instructions.c", "-lm", "-o", place / "steps"], check=True)
    return place / "steps"


def counted(kernel: Kernel, program: Path, steps: int) -> int:
    """Instructions of so many steps, with all that comes before them."""
    words = [*CALLGRIND, program, steps, kernel.h, kernel.tolerance, kernel.members, program.with_name("starts")]
    said = subprocess.run([*map(str, words)], capture_output=True, text=True)
    if said.returncode:
        raise SystemExit(f"instructions.py: {kernel.key}: exit code {said.returncode}\n{said.stderr}")
    return int(re.search(r"Collected : (\d+)", said.stderr)[1])


def row(kernel: Kernel) -> dict:
    """Its line of the table."""
    with tempfile.TemporaryDirectory() as place:
        program = compiled(kernel, spec_of(kernel), Path(place))
        first, both = (counted(kernel, program, n * kernel.steps) for n in (1, 2))
    line = dict(zip(COLUMNS, (*kernel.key, kernel.steps, f"{(both - first) / kernel.steps / kernel.members:.1f}")))
    print(*line.values(), sep=",", file=sys.stderr, flush=True)
    return line


def written(path: Path, lines: list) -> None:
    with open(path, "w", newline="") as f:
        f.write(f"# instructions a step (of one member) by callgrind; {compiler_version(find_compiler())}; {' '.join(FLAGS)}; {datetime.date.today()}\n")
        table = csv.DictWriter(f, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(lines)


def read(path: Path) -> dict:
    """Instructions by key."""
    with open(path, newline="") as f:
        f.readline()
        return {tuple(line[name] for name in KEY): float(line["instructions"]) for line in csv.DictReader(f)}


def compared(now: dict, before: dict, limit: float) -> int:
    """Prints the ratios, the worst last; 1 if one is above the limit."""
    ratios = sorted((now[key] / before[key], key) for key in now if key in before)
    for ratio, key in ratios:
        print(f"{ratio:.4f}  {'  '.join(key)}  {before[key]:.0f} -> {now[key]:.0f}")
    above = [ratio for ratio, _ in ratios if ratio > limit]
    print(f"{len(ratios)} compared, {len(now) - len(ratios)} are new; above {limit}: {len(above)}; the worst: {ratios[-1][0]:.4f}" if ratios else "nothing to compare")
    return int(bool(above))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="TEXT", default="")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--against", type=Path, metavar="FILE")
    parser.add_argument("--limit", type=float, default=1.02)
    parser.add_argument("--processes", type=int, choices=(1, 2), default=2)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(args.processes) as pool:
        lines = list(pool.map(row, [k for k in kernels(folder) if args.only in ",".join(k.key)]))
    if args.out or not args.only:
        written(args.out or OUT, lines)
    now = {tuple(line[name] for name in KEY): float(line["instructions"]) for line in lines}
    return compared(now, read(args.against), args.limit) if args.against else 0


if __name__ == "__main__":
    sys.exit(main())
