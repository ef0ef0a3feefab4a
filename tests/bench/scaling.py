"""From a hundred spins to a million: time to generate and compile, size of the C, cost of a step per spin.

    python tests/bench/scaling.py [--out docs/scaling.csv] [--repeats 9]

The small and the large system take turns in one process; ratios are of medians.
"""
from __future__ import annotations

import argparse
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import smidgen
from machine import write_table
from smidgen.build.binary import FLAGS, find_compiler
from smidgen.compile.emit.emit import generate
from smidgen.run.step.prepared import scene_of
from smidgen.resources import folder, include_flags

SYSTEMS = [("heisenberg_chain", dict(n=100), dict(n=1_000_000)),
           ("j1j2_chain", dict(n=100), dict(n=1_000_000)),
           ("cubic_lattice", dict(nx=5, ny=5, nz=4), dict(nx=100, ny=100, nz=100)),
           ("honeycomb", dict(nx=10, ny=5), dict(nx=1000, ny=500))]
COLUMNS = ["system", "spins", "solver", "generate s", "compile s", "bytes of C", "ns per spin and step",
           "quartiles", "ratio to small", "iterations"]


def timed(call, *args, **more):
    start = time.perf_counter()
    result = call(*args, **more)
    return result, time.perf_counter() - start


def compile_seconds(files, name: str) -> float:
    """One fresh compilation of the model's C, outside any cache."""
    with tempfile.TemporaryDirectory() as place:
        for file, text in files.items():
            Path(place, file).write_text(text)
        command = [*find_compiler(), *FLAGS, "-fPIC", "-shared", *include_flags(), f"{name}.c",
                   "-o", "model.so", "-lm"]
        return timed(subprocess.run, command, cwd=place, check=True)[1]


def prepare(name: str, values: dict):
    """A started integrator and what it took to make it."""
    spec = smidgen.load(str(folder("specs") / f"{name}.toml"))
    files, seconds = timed(generate, scene_of(spec, None, values))
    model = smidgen.build(spec, parameters=values)
    run = spec.runs[0]
    from smidgen.language.evaluate import evaluate
    from smidgen.run.step.evaluated import parameter_values
    model.start(run.start, h=float(evaluate(run.h, parameter_values(spec, values))))
    model.steps(10)
    return model, dict(system=name, spins=model.sites, solver=model.notes["solver"],
                       **{"generate s": round(seconds, 2), "compile s": round(compile_seconds(files, name), 2),
                          "bytes of C": sum(len(files[f"{name}{end}"]) for end in (".h", ".c"))})


def measure(models, repeats: int):
    """Nanoseconds per spin and step of each model, `repeats` times, in turns."""
    counts = [max(1, 200_000 // m.sites) for m in models]
    found = [[] for _ in models]
    for _ in range(repeats):
        for m, count, row in zip(models, counts, found):
            row.append(timed(m.steps, count)[1] / count / m.sites * 1e9)
    return found


def rows(repeats: int):
    for name, *sizes in SYSTEMS:
        models, lines = zip(*[prepare(name, values) for values in sizes])
        times = measure(models, repeats)
        base = statistics.median(times[0])
        for m, line, t in zip(models, lines, times):
            q = statistics.quantiles(t, n=4)
            yield line | {"ns per spin and step": round(statistics.median(t), 1),
                          "quartiles": f"{q[0]:.1f} .. {q[2]:.1f}",
                          "ratio to small": round(statistics.median(t) / base, 2),
                          "iterations": m.report()["iterations"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/scaling.csv")
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()
    lines = list(rows(options.repeats))
    write_table(options.out, lines, COLUMNS)


if __name__ == "__main__":
    main()
