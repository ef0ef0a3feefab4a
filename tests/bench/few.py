"""Few sites of all pairs and a random graph: a step by the solver that `auto` takes beside one by Newton, in one process.

    python tests/bench/few.py [--out docs/few.csv] [--repeats 60]

Three builds of each spec take turns: portable, for this processor (the same bits), and solver newton. Of many short turns the shortest
counts: on a machine with other work the median tells of that.
"""
from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
import smidgen
from machine import write_table

SPINS = """
[model]
name = "spins"
[space]
w = { sphere = 16 }
[effects.exchange]
over = "pair(i, j) of w"
energy = "-dot(w[i], w[j])/16"
[starts.random]
random = 1
"""
GRAPH = """
[model]
name = "random_graph"
[space]
w = { sphere = 1000 }
[graphs.g]
file = "edges.csv"
[effects.exchange]
over = "edge(i, j) of g"
energy = "-dot(w[i], w[j])"
[starts.random]
random = 1
"""
BUILDS = {"portable": dict(native=False), "native": {}, "newton": dict(solver="newton")}
COLUMNS = ["system", "h", "solver", *(f"{name}, ns" for name in BUILDS), "newton / portable", "newton / native"]


def random_graph(folder: str):
    rng, edges = np.random.default_rng(1), set()
    while len(edges) < 3000:
        i, j = map(int, rng.integers(1000, size=2))
        if i != j:
            edges.add((min(i, j), max(i, j)))
    Path(folder, "edges.csv").write_text("".join(f"{i},{j}\n" for i, j in sorted(edges)))
    Path(folder, "graph.toml").write_text(GRAPH)
    return smidgen.load(Path(folder, "graph.toml"))


def turn(model, count: int) -> float:
    """Nanoseconds a step, of the processor's time."""
    begin = time.process_time_ns()
    model.steps(count)
    return (time.process_time_ns() - begin) / count


def row(name: str, spec, start: str, h: float, counts: dict, repeats: int) -> dict:
    models = {build: smidgen.build(spec, **how).start(start, h=h).steps(8 * counts[build]) for build, how in BUILDS.items()}
    found = {build: [] for build in BUILDS}
    for k in range(repeats):
        for build, model in models.items():
            if counts[build] > 1 or k < 3:
                found[build].append(turn(model, counts[build]))
    least = {build: min(times) for build, times in found.items()}
    return {"system": name, "h": h, "solver": models["native"].notes["reason"],
            **{f"{build}, ns": round(t) for build, t in least.items()},
            "newton / portable": round(least["newton"] / least["portable"], 1), "newton / native": round(least["newton"] / least["native"], 1)}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/few.csv")
    parser.add_argument("--repeats", type=int, default=60)
    args = parser.parse_args()
    many = dict.fromkeys(BUILDS, 2000)
    with tempfile.TemporaryDirectory() as folder:
        lines = [row("4 vortices", smidgen.load("point_vortices"), "four", 0.1, many, args.repeats),
                 row("16 spins, all pairs", smidgen.load_text(SPINS), "random", 0.1, many, args.repeats),
                 row("random graph, 1000 sites, 3000 edges", random_graph(folder), "random", 0.1, {"portable": 20, "native": 20, "newton": 1}, args.repeats)]
    write_table(args.out, lines, COLUMNS)


if __name__ == "__main__":
    main()
