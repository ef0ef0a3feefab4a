"""Explicit methods on lattices: sublattice and pair rotations, beside what memory allows.

    python tests/bench/explicit.py [--out docs/explicit.csv] [--repeats 40]

Two builds of each take turns, portable and for this processor, with a copy of an array that no cache holds: the bytes that
it reads and writes in a nanosecond. Steps are taken by tens or more in a call, for each call carries w into rows and back. A step by rows reads and writes w and its rounding errors and reads the neighbours' w, 120 bytes a turn,
and turns 1.5 spins a spin; `memory` is the time for these bytes.
"""
from __future__ import annotations

import argparse
import time

import numpy as np

import smidgen
from lattices import CUBIC, TEXT
from machine import write_table

SYSTEMS = [("sublattice-rotations", *CUBIC, 20), ("sublattice-rotations", *CUBIC, 128), ("sublattice-rotations", "square(n, n, periodic)", "n*n", 90),
           ("pair-rotations", *CUBIC, 20), ("pair-rotations", *CUBIC, 100)]
BUILDS = {"portable": dict(native=False), "native": dict(native=True)}
BYTES = {"sublattice-rotations": 1.5 * 120}
ROOM = np.ones(1 << 25)
COLUMNS = ["method", "lattice", "spins", "portable, ns", "native, ns", "million spin steps per second", "memory, ns", "native / memory"]


def turn(model) -> float:
    """Nanoseconds a spin and step."""
    count = max(10, 400_000 // model.sites)
    begin = time.perf_counter()
    model.steps(count)
    return (time.perf_counter() - begin) / count / model.sites * 1e9


def bandwidth() -> float:
    """Bytes read and written in a nanosecond."""
    half = len(ROOM) // 2
    begin = time.perf_counter()
    ROOM[:half] = ROOM[half:]
    return 2 * 8 * half / (time.perf_counter() - begin) / 1e9


def row(method: str, over: str, sites: str, n: int, repeats: int) -> dict:
    spec = smidgen.load_text(TEXT.format(name="lattice", over=over, sites=sites, n=n))
    models = {name: smidgen.build(spec, method=method, **more).start("random", h=0.0247).steps(2) for name, more in BUILDS.items()}
    found, memory = {name: [] for name in BUILDS}, []
    for _ in range(repeats if models["native"].sites < 1e5 else max(5, repeats // 4)):
        memory.append(bandwidth())
        for name, model in models.items():
            found[name].append(turn(model))
    least = {name: min(times) for name, times in found.items()}
    limit = BYTES[method] / max(memory) if method in BYTES and models["native"].sites > 1e6 else None
    return {"method": method, "lattice": over.partition("(")[0], "spins": models["native"].sites, **{f"{name}, ns": round(t, 2) for name, t in least.items()},
            "million spin steps per second": round(1e3 / least["native"]), "memory, ns": round(limit, 1) if limit else "",
            "native / memory": round(least["native"] / limit, 2) if limit else ""}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/explicit.csv")
    parser.add_argument("--repeats", type=int, default=40)
    args = parser.parse_args()
    write_table(args.out, [row(*system, args.repeats) for system in SYSTEMS], COLUMNS)


if __name__ == "__main__":
    main()
