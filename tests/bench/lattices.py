"""Lattices and chains: a step by rows in lanes beside one from site to site, in one process.

    python tests/bench/lattices.py [--out docs/lattices.csv] [--repeats 60]

Four builds of each spec take turns: portable, for this processor (the same bits), with products and sums in one operation as well (--fast, other bits),
and with the feature `extended`, whose steps go from site to site. Turns are of ten steps or more. Of many short turns the shortest counts: on a machine with other work the median tells of that.
"""
from __future__ import annotations

import argparse
import time

import smidgen
from machine import write_table

TEXT = """
[model]
name = "{name}"
[space]
w = {{ sphere = "{sites}" }}
[parameters]
n = {n}
[effects.exchange]
over = "bond(i, j) of {over}"
energy = "-dot(w[i], w[j])"
[starts.random]
random = 1
[starts.smooth]
theta = "0.7 + 0.3*sin(6*pi*i/n) + 0.05*cos(18*pi*i/n)"
phi = "2*pi*i/n"
"""
CUBIC, CHAIN = ("cubic(n, n, n, periodic)", "n*n*n"), ("chain(n, periodic)", "n")
SYSTEMS = [("cubic", *CUBIC, 20, "random", 0.0247, 0), ("cubic", *CUBIC, 20, "random", 0.0247, 1e-12), ("cubic", *CUBIC, 20, "random", 0.15, 0),
           ("cubic", *CUBIC, 20, "random", 0.2, 0), ("square", "square(n, n, periodic)", "n*n", 90, "random", 0.0247, 0),
           ("square", "square(n, n, periodic)", "n*n", 1000, "random", 0.0247, 0), ("cubic", *CUBIC, 100, "random", 0.0247, 0), ("cubic", *CUBIC, 100, "random", 0.0247, 1e-12),
           ("chain", *CHAIN, 100, "smooth", 0.1, 0), ("chain", *CHAIN, 100, "random", 0.1, 0),
           ("chain", *CHAIN, 1_000_000, "smooth", 0.1, 0)]
BUILDS = {"portable": dict(native=False), "native": dict(native=True), "fast": dict(fast=True), "site by site": dict(features=("extended",))}
COLUMNS = ["system", "spins", "start", "h", "tolerance", "sweeps", *(f"{name}, ns" for name in BUILDS), "site by site / portable", "site by site / native"]


def started(system, more):
    name, over, sites, n, start, h, tolerance = system
    model = smidgen.build(smidgen.load_text(TEXT.format(name=name, over=over, sites=sites, n=n)), **more)
    return model.start(start, h=h, tolerance=tolerance or None).steps(10)


def turn(model) -> float:
    """Nanoseconds a spin and step."""
    count = max(10, 200_000 // model.sites)      # each call carries w into rows and back
    begin = time.perf_counter()
    model.steps(count)
    return (time.perf_counter() - begin) / count / model.sites * 1e9


def row(system, repeats: int) -> dict:
    models = {name: started(system, more) for name, more in BUILDS.items()}
    found = {name: [] for name in BUILDS}
    for _ in range(repeats if models["portable"].sites < 1e5 else max(3, repeats // 20)):
        for name, model in models.items():
            found[name].append(turn(model))
    least = {name: min(times) for name, times in found.items()}
    name, _, _, _, start, h, tolerance = system
    return {"system": name, "spins": models["portable"].sites, "start": start, "h": h, "tolerance": tolerance or "round-off",
            "sweeps": models["portable"].report()["iterations"], **{f"{name}, ns": round(t, 1) for name, t in least.items()},
            **{f"site by site / {name}": round(least["site by site"] / least[name], 1) for name in ("portable", "native")}}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/lattices.csv")
    parser.add_argument("--repeats", type=int, default=60)
    args = parser.parse_args()
    lines = [row(system, args.repeats) for system in SYSTEMS]
    write_table(args.out, lines, COLUMNS)


if __name__ == "__main__":
    main()
