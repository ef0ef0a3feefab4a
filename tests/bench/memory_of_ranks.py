"""Memory of a distributed run: the largest resident memory of each rank, added up, per spin.

    python tests/bench/memory_of_ranks.py [--ranks 4] [--n 400] [--layers 316] [--steps 8] [--folder DIR]

The run writes states and energies at its beginning and at its end. With the default lattice of 5e7 spins it needs 8.5 GB of memory and 5 GB of disk.
"""
from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from smidgen.cli import main

ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}
SPEC = """[model]
name = "magnet"
title = "A cubic magnet"
[space]
w = { sphere = "n*n*m" }
[parameters]
n = { default = 16, meaning = "spins in two directions" }
m = { default = 16, meaning = "layers" }
J = { default = 1.0, meaning = "exchange" }
B = { default = 0.3, meaning = "field" }
[effects.exchange]
over = "bond(i, j) of cubic(n, n, m, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-B*w[i].z"
[starts.warm]
theta = "0.1 + 0.05*cos(2.3*i^2)"
phi = "1.7*i^2"
[runs.demo]
start = "warm"
h = 0.05
steps = 8
output = { what = ["states", "energy"] }
"""


def worker(words) -> None:
    """One rank: the command, then the largest memory that it had."""
    code = main(words)
    print(json.dumps({"code": int(code), "kilobytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}), file=sys.__stdout__, flush=True)


def measured(args, folder) -> dict:
    Path(folder, "magnet.toml").write_text(SPEC)
    words = ["run", "magnet.toml", "--set", f"n={args.n}", "--set", f"m={args.layers}", "--steps", args.steps, "--every", args.steps, "--distributed", "--out", "magnet.h5"]
    command = [*(["mpirun", "-n", args.ranks] if args.ranks > 1 else []), sys.executable, Path(__file__).resolve(), "--worker", *words]
    said = subprocess.run(list(map(str, command)), cwd=folder, env={**os.environ, **ENVIRONMENT}, stdout=subprocess.PIPE, text=True, check=True).stdout
    found = [json.loads(line) for line in said.splitlines() if line.startswith('{"code"')]
    total, spins = 1024 * sum(one["kilobytes"] for one in found), args.n ** 2 * args.layers
    return {"ranks": len(found), "spins": spins, "GB": round(total / 1e9, 3), "bytes per spin": round(total / spins, 1), "code": max(one["code"] for one in found)}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in (("ranks", 4), ("n", 400), ("layers", 316), ("steps", 8)):
        parser.add_argument(f"--{name}", type=int, default=value)
    parser.add_argument("--folder", help="where the result is written, and removed")
    parser.add_argument("--worker", nargs=argparse.REMAINDER)
    return parser.parse_args()


if __name__ == "__main__":
    given = arguments()
    if given.worker:
        worker(given.worker)
    else:
        with tempfile.TemporaryDirectory(dir=given.folder) as place:
            print(json.dumps(measured(given, place)))
