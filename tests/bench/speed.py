"""Writes docs/speed.md from the tables free_body, lattices, explicit, threads, few and scaling (.csv) in docs/, which the other benches measure.

    python tests/bench/speed.py
"""
from __future__ import annotations

import csv
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
LATTICES = ("system", "spins", "start", "h", "tolerance", "sweeps", "portable, ns", "native, ns", "fast, ns", "site by site, ns", "site by site / portable",
            "site by site / native")
EXPLICIT = ("method", "lattice", "spins", "portable, ns", "native, ns", "million spin steps per second", "memory, ns", "native / memory")
THREADS = ("scaling", "system", "spins of one thread", "one thread, ns", "two threads, ns", "efficiency", "same bits")
FEW = ("system", "h", "portable, ns", "native, ns", "newton, ns", "newton / portable", "newton / native")

PAGE = """# Speed

`make bench` regenerates this page. Timings are medians of interleaved measurements in one process. Ratios are more reliable than times.

The line above each table gives the machine, the load and the date. The last table, "From a hundred spins to a million", is dated 2026-11-21. It was measured on another machine, with a version of smidgen that did not step lattices by rows. It shows how times and the size of the C depend on the number of spins, but not how long a step takes with this version.

## One step of the free rigid body, h = 0.1

{body_machine}

The table compares the generated step with hand-written C steps of the same method. All are compiled with the same flags, and use the same initial guess and the same stopping criterion (no component changes by more than a unit in the last place). The generated step also returns a status, checks the branch, and stores the rounding error of the state (the carry); the hand-written steps do none of this.

{body}

The hand-written designs are in `tests/bench/free_body/hand.c`. The generated step solves for u = W - w and q = 1/|w + W| together, by
Newton's method, starting from an extrapolation of degree 6. Because the field is divergence-free on the tangent plane, the inverse of the 2x2 matrix is obtained from two products with DX (by the Cayley-Hamilton theorem), and its determinant gives the branch check. [costs.md](costs.md#what-each-guarantee-costs-vectors-of-8-lanes) shows what the carry and the branch check cost. The ratio depends on the processor:

{processors}

## Lattices and chains, by rows in lanes

{lattice_machine}

{lattices}

Times are in nanoseconds per spin and step.

- `portable` is compiled for any processor of this architecture, with two lanes.
- `native` is compiled for this processor (`-march=native`), as `smidgen.build` does, and gives the same bits.
- `fast` also uses fused multiply-add operations (`--fast`), and gives different bits.
- `site by site` is the time for models that cannot be stepped [by rows](lattices.md#processing-lattices-by-rows); here it is measured with the same model, built so that it is stepped site by site.
- `sweeps` is the number of sweeps in the last step, after which there is one more evaluation.

All variants are timed alternately. A call takes at least ten steps. If the state is output after every step, w is converted to rows and back each time, which takes about 10 ns per spin.

## Explicit steps on lattices

{explicit_machine}

{explicit}

Times are in nanoseconds per spin and step, from random starts, with h = 0.0247. Both methods are stepped by rows in lanes. A step of sublattice rotations rotates the spins of one colour twice and those of the other once; it conserves the energy to round-off and is not symplectic. A step of pair rotations rotates the ends of eleven bonds for each pair of spins of the cubic lattice; it is symplectic and conserves the total spin to round-off. `memory` is the time for moving the same number of bytes by copying a large array.

## Lattices shared by threads

{threads_machine}

{threads}

Times are wall-clock times in nanoseconds per spin and step. For strong scaling, both runs use the same lattice; for weak scaling, two threads have twice as many spins. Efficiency is the speed with two threads divided by twice the speed with one.

## Few sites, and graphs

{few_machine}

{few}

Times are in nanoseconds per step: compiled for any processor of this architecture (`portable`), for this processor as `smidgen.build` does (`native`), and with Newton's method only (`--solver newton`). All are timed alternately.

For thousands of single bodies side by side, see [ensembles.md](ensembles.md).

## Instructions per step

`python tests/bench/instructions.py` uses callgrind to count the instructions of these steps and of those of ensembles, compiled for any processor of this architecture. The count is the difference between runs of N and 2N steps of the same program, see [instructions.csv](instructions.csv). Times depend on the machine and its load, but these counts depend only on the compiler; with `--against FILE` they show the cost of a change. The rows `lanes` and `one by one` are counts for one member of an ensemble, all others for a whole state.

## From a hundred spins to a million

{scaling_machine}

{scaling}

Generating the C takes the same time for any size and gives the same C, except for the digits of the default size.
`iterations` is the number of sweeps, or of Newton iterations, in the last step.
"""


def table(name: str, columns):
    """(machine line, markdown table) of a CSV file in docs/."""
    text = (DOCS / name).read_text().splitlines()
    rows = list(csv.DictReader(text[1:]))
    lines = ["| " + " | ".join(columns.values()) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(row[key] for key in columns) + " |" for row in rows]
    return text[0].removeprefix("# "), "\n".join(lines)


def processors(*names: str) -> str:
    """The ratio of the generated step on each machine that a table is of."""
    tables = [(DOCS / name).read_text().splitlines() for name in names]
    ratios = [next(row["ratio of medians"] for row in csv.DictReader(lines[1:]) if row["design"] == "generated") for lines in tables]
    return "\n".join(f"- {lines[0].removeprefix('# ').partition(';')[0]}: {ratio} ([{name}]({name}))" for name, lines, ratio in zip(names, tables, ratios))


def main():
    body_machine, body = table("free_body.csv", {"design": "design", "median ns": "median ns", "min ns": "least ns",
                                                 "ratio of medians": "ratio to the fastest by hand",
                                                 "energy error": "energy error at the end"})
    lattice_machine, lattices = table("lattices.csv", {name: name for name in LATTICES})
    explicit_machine, explicit = table("explicit.csv", {name: name for name in EXPLICIT})
    threads_machine, threads = table("threads.csv", {name: name for name in THREADS})
    few_machine, few = table("few.csv", {name: name for name in FEW})
    scaling_machine, scaling = table("scaling.csv", {
        "system": "system", "spins": "spins", "solver": "solver", "generate s": "generate, s",
        "compile s": "compile, s", "bytes of C": "bytes of C", "ns per spin and step": "ns per spin and step",
        "ratio to small": "ratio", "iterations": "iterations"})
    (DOCS / "speed.md").write_text(PAGE.format(body_machine=body_machine, body=body, processors=processors("free_body.csv", "free_body_xeon.csv"), lattice_machine=lattice_machine, lattices=lattices,
                                               explicit_machine=explicit_machine, explicit=explicit, threads_machine=threads_machine, threads=threads, few_machine=few_machine, few=few,
                                               scaling_machine=scaling_machine, scaling=scaling))


if __name__ == "__main__":
    main()
