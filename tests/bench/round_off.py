"""How round-off grows, and what it costs to make it grow less: writes docs/round_off*.csv and docs/round_off.md.

    python tests/bench/round_off.py              # hours: measures everything, then writes the page
    python tests/bench/round_off.py free cost    # some of its tables again
    python tests/bench/round_off.py --page       # writes the page from the tables that are there

Tables: free, irreversible, chain (the growth), distance (to the same map in quadruple precision), cost, lanes.
"""
import argparse
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from machine import machine
from round_off.programs import VARIANTS, cost_of, lanes_of, numbers, program
from round_off.page import write_page

import smidgen
from smidgen.start import initial_state

HERE = Path(__file__).resolve().parent
DOCS = HERE.parent.parent / "docs"
GROWTH, COST = DOCS / "round_off.csv", DOCS / "round_off_cost.csv"
COLUMNS = ("table", "variant", "orbits", "steps", "quantity", "rms", "mean", "machine")
COSTS = ("table", "variant", "median", "least", "greatest", "machine")
ORBITS, H = 40, 0.1
REACH = {"free": (10**5, 10**6, 10**7, 10**8), "irreversible": (10**5, 10**6, 10**7),
         "chain": (10**4, 10**5, 10**6)}
BODIES = {"free": ("free_rigid_body", "1 2 4 0"), "irreversible": ("irreversible_rigid_body", "1 2 4 0.6666666666666666")}


def orbits(count=ORBITS, seed=5):
    """Starts on the sphere, uniform, and steps within 5 % of H: rows x y z h."""
    rng = np.random.default_rng(seed)
    w = rng.normal(size=(count, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    return np.column_stack([w, H * (1 + 0.1 * (rng.random(count) - 0.5))])


def words(rows) -> str:
    """Numbers as text that reads back the same."""
    return " ".join(repr(float(x)) for x in np.ravel(rows))


def ask(path, arguments, given: str):
    """The numbers that a program prints, line by line."""
    said = subprocess.run([path, *map(str, arguments)], input=given, capture_output=True, text=True, check=True)
    return np.array([[float(x) for x in line.split()] for line in said.stdout.splitlines()])


def bodies(table, where, steps):
    """Growth of dH and d|w|^2 of one rigid body, of all variants. H of the irreversible body is no constant of the map."""
    name, constants = BODIES[table]
    starts = orbits()
    for variant in VARIANTS:
        path = program(where, name, variant, "body.c")
        found = ask(path, [*constants.split(), *steps], words(starts)).reshape(len(starts), len(steps), 2)
        for q, quantity in enumerate(("H", "|w|^2")):
            if table == "free" or q == 1:
                yield from grown(table, variant, len(starts), steps, quantity, found[:, :, q])


def grown(table, variant, count, steps, quantity, found):
    for n, column in zip(steps, found.T):
        yield dict(table=table, variant=variant, orbits=count, steps=n, quantity=quantity,
                   rms=float(np.sqrt(np.mean(column**2))), mean=float(np.mean(column)), machine=machine())


def chain(table, where, steps):
    """The smooth chain of 100 spins: rms of d|w_i|^2, and H against the run of pairs of doubles."""
    spec = smidgen.load(HERE.parent.parent / "specs" / "heisenberg_chain.toml")
    start = initial_state(spec, "smooth", {"n": 100})
    exact = None
    for variant in ("double-double", *(v for v in VARIANTS if v != "double-double")):
        path = program(where, "heisenberg_chain", variant, "chain.c")
        found = ask(path, [H, *steps], f"{len(start)} {words(start)}").reshape(1, len(steps), 2)
        yield from grown(table, variant, len(start), steps, "|w|^2", found[:, :, 1])
        exact = found if exact is None else exact
        if exact is not found:
            yield from grown(table, variant, 1, steps, "H", found[:, :, 0] - exact[:, :, 0])


def states(where, name, variant, starts, steps, real=""):
    """States after these numbers of steps as pairs of doubles: (orbits, steps, 3, 2)."""
    path = program(where, name, variant, "states.c", real)
    return np.array([ask(path, [repr(float(row[3])), *steps], f"1 {words(row[:3])}").reshape(len(steps), 3, 2)
                     for row in starts])


def apart(a, b):
    """Distances of states given as pairs, to the digits of pairs: (orbits, steps)."""
    d = a - b
    return np.sqrt(np.sum((d[..., 0] + d[..., 1])**2, axis=-1))


def distance(table, where, steps=(10**3, 10**4, 10**5, 10**6)):
    """Distance to the same map in quadruple precision; beyond 1e6 steps to the run of pairs of doubles, whose own
    distance to it the table holds."""
    starts, far = orbits(8), (10**3, 10**4, 10**5, 10**6, 10**7)
    quad = states(where, "free_rigid_body", "default", starts, steps, "-DSMG_QUAD")
    for variant in VARIANTS:
        found = states(where, "free_rigid_body", variant, starts, far)
        yield from grown(table, variant, len(starts), steps, "to quad", apart(found[:, :len(steps)], quad))
        if variant == "double-double":
            pairs = found
    for variant in VARIANTS:
        found = states(where, "free_rigid_body", variant, starts, far)
        if variant != "double-double":
            yield from grown(table, variant, len(starts), far, "to double-double", apart(found, pairs))


def cost(table, where, repeats=15):
    """ns per step, interleaved."""
    for name in ("free_rigid_body", "irreversible_rigid_body", "heisenberg_chain"):
        for variant, times in cost_of(where, name, repeats).items():
            yield timed(f"{table} {name}", variant, times)


def lanes(table, where, repeats=9):
    """ns per step and trajectory of the prototype in lanes."""
    for variant, times in lanes_of(where, repeats).items():
        yield timed(table, variant, times)


def timed(table, variant, times):
    return dict(table=table, variant=variant, median=float(np.median(times)), least=float(min(times)),
                greatest=float(max(times)), machine=machine())


def keep(path, columns, rows):
    """Rows into the table, in the place of those of the same table, variant and quantity."""
    rows = [{k: str(v) for k, v in row.items()} for row in rows]
    same = {(r["table"], r["variant"], r.get("quantity")) for r in rows}
    old = [r for r in numbers(path) if (r["table"], r["variant"], r.get("quantity")) not in same]
    with open(path, "w", newline="") as handle:
        writer = csv.DictWriter(handle, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(old + rows, key=lambda r: r["table"]))


MEASURES = {"free": bodies, "irreversible": bodies, "chain": chain, "distance": distance, "cost": cost, "lanes": lanes}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="*", choices=[[], *MEASURES])
    parser.add_argument("--page", action="store_true", help="only write the page")
    parser.add_argument("--reach", type=float, help="stop after so many steps")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for table in [] if chosen.page else chosen.tables or MEASURES:
            measure(table, Path(folder), chosen.reach)
    write_page(GROWTH, COST, HERE / "round_off.md.in", DOCS / "round_off.md")


def measure(table, where, reach):
    """One table: measured variant by variant, kept as soon as it is there."""
    steps = [n for n in REACH.get(table, ()) if not reach or n <= reach]
    rows = MEASURES[table](table, where, steps) if steps else MEASURES[table](table, where)
    path, columns = (COST, COSTS) if table in ("cost", "lanes") else (GROWTH, COLUMNS)
    for row in rows:
        print(*(row[c] for c in columns[:-1]), flush=True)
        keep(path, columns, [row]) if columns is COSTS else keep_step(path, columns, row)


def keep_step(path, columns, row):
    """One row of a table of growth: its number of steps counts too."""
    row = {k: str(v) for k, v in row.items()}
    key = ("table", "variant", "quantity", "steps")
    rows = [r for r in numbers(path) if any(r[k] != row[k] for k in key)] + [row]
    with open(path, "w", newline="") as handle:
        writer = csv.DictWriter(handle, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda r: (r["table"], r["quantity"], r["variant"], int(r["steps"]))))


if __name__ == "__main__":
    sys.exit(main())
