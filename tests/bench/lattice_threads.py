"""Steps of lattices shared by threads: strong scaling (the same lattice) and weak scaling (twice the spins by two threads).

    python tests/bench/lattice_threads.py [--out docs/threads.csv] [--repeats 40]

One and two threads take turns in one process, by the clock; of many short turns the shortest counts. The bits are compared.
"""
from __future__ import annotations

import argparse
import time

import numpy as np
import smidgen
from lattices import CHAIN, CUBIC, TEXT
from machine import write_table

THREADS = (1, 2)
STRONG = [("cubic", *CUBIC, 20, "random", 0.0247), ("cubic", *CUBIC, 40, "random", 0.0247), ("cubic", *CUBIC, 100, "random", 0.0247),
          ("chain", *CHAIN, 10_000, "smooth", 0.1), ("chain", *CHAIN, 1_000_000, "smooth", 0.1)]
DOUBLE = ("cubic(n, n, 2*n, periodic)", "2*n*n*n")      # of a cubic lattice
WEAK = [("cubic", *CUBIC, 20, "random", 0.0247), ("cubic", *CUBIC, 40, "random", 0.0247), ("cubic", *CUBIC, 80, "random", 0.0247)]
COLUMNS = ["scaling", "system", "spins of one thread", "one thread, ns", "two threads, ns", "efficiency", "same bits"]


def started(name, over, sites, n, start, h, threads):
    spec = smidgen.load_text(TEXT.format(name=name, over=over, sites=sites, n=n))
    return smidgen.build(spec, threads=threads).start(start, h=h).steps(5)


def turn(model) -> float:
    """Seconds a step."""
    count = max(10, 40_000 // model.sites)     # each call carries w into rows and back
    begin = time.perf_counter()
    model.steps(count)
    return (time.perf_counter() - begin) / count


def least(models, repeats: int) -> list[float]:
    """The shortest turn of each."""
    times = [[turn(model) for model in models] for _ in range(repeats if models[0].sites < 1e5 else max(4, repeats // 8))]
    return np.min(times, axis=0).tolist()


def strong(system, repeats: int) -> dict:
    models = [started(*system, threads) for threads in THREADS]
    one, two = least(models, repeats)
    same = all(np.array_equal(models[0].w, model.w) for model in models)
    return row("strong", system, models[0].sites, one, two, one / two / 2, "yes" if same else "no")


def weak(system, repeats: int) -> dict:
    name, _, _, *rest = system
    models = [started(*system, 1), started(name, *DOUBLE, *rest, 2)]
    one, two = least(models, repeats)
    return row("weak", system, models[0].sites, one, two / 2, one / two, "")


def row(scaling, system, spins, one, two, efficiency, same) -> dict:
    """Nanoseconds a spin."""
    return dict(zip(COLUMNS, (scaling, system[0], spins, round(one / spins * 1e9, 1), round(two / spins * 1e9, 1), f"{efficiency:.2f}", same)))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/threads.csv")
    parser.add_argument("--repeats", type=int, default=40)
    args = parser.parse_args()
    lines = [*(strong(system, args.repeats) for system in STRONG), *(weak(system, args.repeats) for system in WEAK)]
    write_table(args.out, lines, COLUMNS)


if __name__ == "__main__":
    main()
