"""Steps of lattices shared by ranks of MPI: strong scaling (the same lattice) and weak scaling (as many spins a rank), and what messages take.

    python tests/bench/ranks.py [--out docs/ranks.csv] [--repeats 30]

Each number of ranks is a program of its own, by mpirun, and the programs take turns; of many short turns the shortest counts. The bits are compared. What each call
takes beside its steps, to begin and to gather w, is a column of its own. Where there are fewer processors than ranks, these take turns on them.
"""
from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import time

import numpy as np
import smidgen
from lattices import CHAIN, CUBIC, TEXT
from machine import write_table
from smidgen import ranks

RANKS = (1, 2, 4)
TURNS = 4
STRONG = [("cubic", *CUBIC, 40, "random", 0.0247), ("cubic", *CUBIC, 100, "random", 0.0247), ("chain", *CHAIN, 1_000_000, "smooth", 0.1)]
WEAK = ("cubic", "cubic(n, n, {k}*n, periodic)", "{k}*n*n*n", 64, "random", 0.0247)
COLUMNS = ["scaling", "system", "spins", "ranks", "ns a spin and step", "efficiency", "a call, ns a spin", "sweeps", "messages a step and rank", "KB a step and rank", "same bits"]
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}


def worker(system, repeats: int) -> dict:
    """What one rank finds of its turns."""
    name, over, sites, n, start, h = system
    model = smidgen.build(smidgen.load_text(TEXT.format(name=name, over=over, sites=sites, n=n))).start(start, h=h).steps(5)
    count, repeats = max(4, 200_000 // model.sites), repeats if model.sites < 2e5 else max(4, repeats // 4)
    call = least(lambda: model.advance(0), repeats)
    return {"seconds": (least(lambda: model.advance(count), repeats) - call) / count, "call": call, "spins": model.sites, "sweeps": model.report()["iterations"], "bits": hashlib.sha256(model.state().tobytes()).hexdigest()}


def messages(_, repeats: int) -> dict:
    """Microseconds: a largest number of all ranks; a message there and back, halved, of 8 bytes and of 1 MB."""
    from mpi4py import MPI
    comm, found = MPI.COMM_WORLD, {}
    pair = np.zeros(2)
    found["allreduce"] = least(lambda: comm.Allreduce(MPI.IN_PLACE, pair, MPI.MAX), 20 * repeats)
    for size in (8, 1 << 20):
        data, rank = np.zeros(size, np.uint8), comm.rank

        def there_and_back():
            if rank == 0:
                comm.Send(data, 1)
                comm.Recv(data, 1)
            elif rank == 1:
                comm.Recv(data, 0)
                comm.Send(data, 0)
        found[f"{size} bytes"] = least(there_and_back, 20 * repeats) / 2
    return {name: round(value * 1e6, 2) for name, value in found.items()}


def least(call, repeats: int) -> float:
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


def on_ranks(count: int, system, repeats: int) -> dict:
    """The same in a program of `count` ranks."""
    words = [sys.executable, __file__, "--repeats", repeats, "--worker", json.dumps(system)]
    words = [*(["mpirun", "-n", count] if count > 1 else []), *words]
    said = subprocess.run([str(w) for w in words], env={**os.environ, **ENVIRONMENT}, capture_output=True, text=True, check=True)
    return json.loads(said.stdout)


def row(scaling, system, count, found, one) -> dict:
    """Per spin; efficiency: of `count` times the pace of one rank. A layer of a colour goes each way after a pass, and once a step."""
    ns, n = found["seconds"] / found["spins"] * 1e9, system[3]
    passes, layer = 2 * found["sweeps"] + 1, n * n // 2 if system[0] == "cubic" else 1
    same = "" if scaling == "weak" else "yes" if found["bits"] == one["bits"] else "no"
    told = (passes * min(2, count - 1), round(2 * passes * layer * 24 / 1000, 1)) if count > 1 else (0, 0)
    efficiency = one["seconds"] / one["spins"] / (found["seconds"] / found["spins"]) / count
    return dict(zip(COLUMNS, (scaling, system[0], found["spins"], count, round(ns, 1), f"{efficiency:.2f}", round(found["call"] / found["spins"] * 1e9, 1), found["sweeps"], *told, same)))


def by_turns(systems: dict, repeats: int) -> dict:
    """number of ranks -> the quickest of some programs: all numbers take turns, for the pace of the machine changes."""
    every = [{count: on_ranks(count, system, repeats) for count, system in systems.items()} for _ in range(TURNS)]
    return {count: {**every[0][count], **{key: min(found[count][key] for found in every) for key in ("seconds", "call")}} for count in systems}


def lines(repeats: int):
    for system in STRONG:
        found = by_turns(dict.fromkeys(RANKS, system), repeats)
        yield from (row("strong", system, count, found[count], found[1]) for count in RANKS)
    systems = {count: (WEAK[0], WEAK[1].format(k=count), WEAK[2].format(k=count), *WEAK[3:]) for count in RANKS}
    found = by_turns(systems, repeats)
    yield from (row("weak", systems[count], count, found[count], found[1]) for count in RANKS)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="docs/ranks.csv")
    parser.add_argument("--repeats", type=int, default=30)
    parser.add_argument("--worker")
    args = parser.parse_args()
    if args.worker is None:
        write_table(args.out, list(lines(args.repeats)), COLUMNS)
        print(*(f"{count} ranks, microseconds: {on_ranks(count, 'messages', args.repeats)}" for count in RANKS[1:]), sep="\n")
        return
    ranks.join()
    system = json.loads(args.worker)
    found = (messages if system == "messages" else worker)(system, args.repeats)
    if ranks.first():
        print(json.dumps(found))


if __name__ == "__main__":
    main()
