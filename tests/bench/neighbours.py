"""Times at neighbouring points: does a slightly larger step, or one site more, cost much more?

    python tests/bench/neighbours.py                 # some minutes, on a machine without other work: docs/neighbours.csv and its figure
    python tests/bench/neighbours.py --only chain    # the series whose name has this text are measured anew, the others stay
    python tests/bench/neighbours.py --page          # the table and the figure from the measurements that there are

Each series varies one number: the step size by factors of 1.1, up to the largest one of which the first steps have a solution; the number of sites, members or effects by one.
Times are those of the processor. Over step sizes they are of the first step, and of the STEPS steps that follow it; elsewhere of a step in a long run. Points of a series are measured in
turns, TURNS times each, and the least counts. Over step sizes the time alone is compared, elsewhere the time over the number of operations of the formulas.
"""
from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import smidgen
from beside_exchange import AXIS, DAMPED, FIELD, H, TWIST, Scene, bonds, operations, site
from machine import machine, put_between
from smidgen.errors import RunError

DOCS = Path(__file__).parents[2] / "docs"
BEGIN, END = "<!-- neighbours: made by `make bench-scenes TIMES=1` -->\n", "<!-- end of neighbours -->"
TURNS, STEPS = 5, 5              # of each point; steps after the first one
TURN, MOST = 0.008, 40000        # seconds and steps of a turn
GROWTH, SMALLEST = 1.1, 0.02     # of step sizes
LARGEST = 0.95                   # part of the largest step size that has a solution
LIMIT = 1.5                      # of what a neighbour costs
LATTICE = """[model]
name = "scene"
[space]
w = {{ sphere = "{sites}" }}
[parameters]
n = 8
[effects.exchange]
over = "bond(i, j) of {lattice}"
energy = "-dot(w[i], w[j])"
[starts.random]
random = 1
[starts.spiral]
theta = "1 + 0.5*sin(0.3*i)"
phi = "0.7*i"
"""
CUBE, SQUARE, CHAIN = "cubic(n, n, n, periodic)", "square(n, n, periodic)", "chain(n, periodic)"
SITES = {CUBE: "n*n*n", SQUARE: "n*n", CHAIN: "n"}
UNLIKE = (TWIST, FIELD, AXIS, bonds("-0.1*dot(w[i], w[j])^2"), site("-0.2*cos(t)*w[i].x"), site("-0.1*normal(1, i)*w[i].y"), DAMPED,
          site("-0.1*(w[i].x^4 + w[i].y^4 + w[i].z^4)"), bonds("-0.2*w[i].x*w[j].x"))


def exchange_on(lattice: str):
    return smidgen.load_text(LATTICE.format(sites=SITES[lattice], lattice=lattice))


@dataclass
class Point:
    """One number of a series: what is timed, and the number of steps that it takes in a turn; the operations of a step, and the least time of a step in ns."""
    at: float
    timed: Callable[[int], float]
    operations: float = 1
    count: int = 1
    least: float = np.inf


def seconds(work) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


# Step sizes

def over_h(start: str) -> Iterator[tuple[str, list]]:
    """The first step, and the mean of those that follow, of 8^3 spins."""
    model = smidgen.build(exchange_on(CUBE), native=True)
    w = np.array(model.start(start, h=1.0).w)
    largest = largest_h(model, w)
    sizes = SMALLEST * GROWTH ** np.arange(1 + int(np.log(LARGEST * largest / SMALLEST) / np.log(GROWTH)))

    def first(h):
        return lambda _: seconds(model.step) if model.start(w.copy(), h=h) else 0

    def following(h):
        return lambda _: seconds(lambda: model.steps(STEPS)) / STEPS if model.start(w.copy(), h=h).step() else 0

    yield f"step size, {start} start, first step", [Point(h, first(h)) for h in sizes]
    yield f"step size, {start} start, next steps", [Point(h, following(h)) for h in sizes]


def largest_h(model, w) -> float:
    """Where steps begin to fail, to a part in a hundred."""
    below, above = SMALLEST, None
    while above is None or above > 1.01 * below:
        h = 2 * below if above is None else (below * above) ** 0.5
        try:
            model.start(w.copy(), h=h).steps(1 + STEPS)
            below = h
        except RunError:
            above = h
    return below


# Numbers of sites, members and effects

def over_sites(lattice: str, numbers) -> list:
    spec = exchange_on(lattice)

    def point(n):
        model = smidgen.build(spec, parameters={"n": n}, native=True).start("random", h=0.05)
        model.steps(20)
        return Point(n, lambda count: seconds(lambda: model.steps(count)) / count, model.sites)

    return [point(n) for n in numbers]


def over_vortices(numbers) -> list:
    def point(n):
        model = smidgen.build("point_vortices", parameters={"n": n}, native=True).start("spiral", h=0.05 / n)
        model.steps(10)
        return Point(n, lambda count: seconds(lambda: model.steps(count)) / count, n * (n - 1))

    return [point(n) for n in numbers]


def over_members(spec: str, method: str, h: float, steps: int, numbers) -> list:
    """steps: of a turn, so many that the call itself takes little of it."""
    model = smidgen.build(spec, method=method)
    starts = np.random.default_rng(1).standard_normal((max(numbers), model.sites, 3))
    starts /= np.linalg.norm(starts, axis=2, keepdims=True)

    def point(members):
        return Point(members, lambda count: seconds(lambda: smidgen.ensemble(spec, start=starts[:members], method=method, h=h, steps=count, threads=1)) / count, members, steps)

    return [point(members) for members in numbers]


def over_effects(effects) -> list:
    def point(k):
        scene = Scene("", effects[:k])
        model = smidgen.build(smidgen.load_text(scene.text()), native=True).start("s", h=H)
        model.steps(20)
        return Point(k + 1, lambda count: seconds(lambda: model.steps(count)) / count, model.sites * operations(scene))

    return [point(k) for k in range(len(effects) + 1)]


FAMILIES = {
    "step size, random": lambda: over_h("random"),
    "step size, spiral": lambda: over_h("spiral"),
    "sites of a chain": lambda: [("sites of a chain", over_sites(CHAIN, range(32, 161)))],
    "sides of a square": lambda: [("sides of a square", over_sites(SQUARE, range(32, 81)))],
    "sides of a cube": lambda: [("sides of a cube", over_sites(CUBE, range(32, 49)))],
    "short sides of a square": lambda: [("short sides of a square", over_sites(SQUARE, range(6, 32)))],
    "short sides of a cube": lambda: [("short sides of a cube", over_sites(CUBE, range(4, 32)))],
    "point vortices": lambda: [("point vortices", over_vortices(range(32, 331)))],
    "members, free body": lambda: [("members, free body", over_members("free_rigid_body", "spherical-midpoint", 0.1, 200000, range(32, 97)))],
    "members, four vortices": lambda: [("members, four vortices", over_members("point_vortices", "gauss-4", 0.1, 4000, range(32, 65)))],
    "unlike effects": lambda: [("unlike effects", over_effects(UNLIKE))],
    "effects on the same bonds": lambda: [("effects on the same bonds", over_effects((bonds("-dot(w[i], w[j])"),) * 9))],
}


def measured(points: list) -> None:
    for point in points:
        for _ in range(3 if point.count == 1 else 0):
            point.count = max(1, int(TURN / max(TURN / MOST, point.timed(point.count))))
    for _ in range(TURNS):
        for point in points:
            point.least = min(point.least, point.timed(point.count) * 1e9)


def lines_of(series: str, points: list) -> list:
    cost = [p.least / p.operations for p in points]
    return [dict(series=series, at=f"{p.at:.4g}", ns=f"{p.least:.1f}", operations=f"{p.operations:.6g}", factor=f"{cost[k] / cost[k - 1]:.3f}" if k else "") for k, p in enumerate(points)]


# The table and the figure

def read() -> list:
    path = DOCS / "neighbours.csv"
    return list(csv.DictReader(path.read_text().splitlines()[1:])) if path.exists() else []


def written(lines: list) -> None:
    with open(DOCS / "neighbours.csv", "w", newline="") as out:
        out.write(f"# {machine()}\n")
        table = csv.DictWriter(out, ("series", "at", "ns", "operations", "factor"), lineterminator="\n")
        table.writeheader()
        table.writerows(lines)


def grouped(lines: list) -> dict:
    found = {}
    for line in lines:
        found.setdefault(line["series"], []).append(line)
    return found


def row(series: str, lines: list) -> str:
    factors = [(float(line["factor"]), line) for line in lines if line["factor"]]
    largest, line = max(factors, key=lambda f: f[0])
    above = sum(f > LIMIT for f, _ in factors)
    return f"| {series} | {lines[0]['at']} to {lines[-1]['at']} | {len(lines)} | {largest:.2f} | {line['at']} | {above} |\n"


def page(lines: list) -> str:
    head = f"| series | from, to | points | largest factor | at | factors above {LIMIT} |\n|---|---|---:|---:|---:|---:|\n"
    with open(DOCS / "neighbours.csv") as table:
        said = table.readline().lstrip("# ").rstrip()
    return f"{said}.\n\n" + head + "".join(row(series, points) for series, points in grouped(lines).items())


def figure(lines: list) -> None:
    series = grouped(lines)
    fig = Figure(figsize=(10, 2.2 * -(-len(series) // 3)), layout="constrained")
    for k, (name, points) in enumerate(series.items()):
        ax = fig.add_subplot(-(-len(series) // 3), 3, k + 1)
        at = [float(p["at"]) for p in points]
        ax.plot(at, [float(p["ns"]) / float(p["operations"]) for p in points], ".-", lw=0.8, ms=3)
        ax.set_title(name, fontsize=8)
        ax.tick_params(labelsize=7)
        if name.startswith("step size"):
            ax.set(xscale="log", yscale="log", xticks=(0.02, 0.05, 0.1, 0.2, 0.5), xticklabels=("0.02", "0.05", "0.1", "0.2", "0.5"))
            ax.minorticks_off()
        else:
            ax.set_ylim(bottom=0)
    fig.supylabel("ns per step (step sizes), or per step and operation", fontsize=8)
    fig.savefig(DOCS / "img" / "neighbours.png", dpi=110)


def show(lines: list) -> None:
    put_between(DOCS / "beside_exchange.md", BEGIN, END, page(lines))
    figure(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="TEXT", default="", help="series whose name has this text")
    parser.add_argument("--page", action="store_true", help="only write the table and the figure")
    args = parser.parse_args()
    for name, family in FAMILIES.items() if not args.page else ():
        if args.only not in name:
            continue
        for series, points in family():
            measured(points)
            made = lines_of(series, points)
            written([line for line in read() if line["series"] != series] + made)
            print(row(series, made), end="", file=sys.stderr, flush=True)
    show(read())


if __name__ == "__main__":
    main()
