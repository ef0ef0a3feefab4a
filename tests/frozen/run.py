"""`make frozen UPDATE=1`, then a change, then `make frozen`: which integrators have other bits than before?

Every shipped spec and scene in the sizes that select its layouts, by every method, feature, solver and precision that it is offered. The table is
out/frozen.csv, made on the machine that compares, since sines and logarithms are those of its C library. Compiled without optimisation,
which decides no bit and takes a fifth of the time; some 6,700 integrators take a quarter of an hour on two idle cores.
"""
import argparse
import csv
import os
import shutil
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
if __name__ == "__main__":
    sys.path.insert(0, str(HERE.parent))

from frozen.cases import cases  # noqa: E402
from frozen.states import bits  # noqa: E402
from smidgen.build import binary  # noqa: E402
from support.strict import CALLS  # noqa: E402

TABLE = HERE.parent.parent / "out" / "frozen.csv"
HEAD = ("spec", "values", "method", "solver", "features", "real", "small", "large")


def prepare(cache: str) -> None:
    """In each process: a cache of its own, and builds without optimisation."""
    os.environ["SMIDGEN_CACHE"] = cache
    binary.FLAGS = (*(f for f in binary.FLAGS if not f.startswith("-O")), "-O0", CALLS)


def found(case) -> tuple[str, tuple[str, str]]:
    return case.key, bits(case)


def all_bits(chosen, jobs: int) -> dict:
    """key -> digests, with a count on a terminal."""
    place = tempfile.mkdtemp(prefix="smidgen-frozen-")
    try:
        with ProcessPoolExecutor(jobs, initializer=prepare, initargs=(place,)) as pool:
            table = {}
            for key, digests in pool.map(found, chosen, chunksize=8):
                table[key] = digests
                if sys.stderr.isatty():
                    print(f"\r{len(table)} of {len(chosen)}", end="", file=sys.stderr)
        return table
    finally:
        shutil.rmtree(place, ignore_errors=True)


def kept() -> dict:
    """key -> digests of the table; none before it was first written."""
    if not TABLE.exists():
        return {}
    with TABLE.open(newline="") as file:
        rows = [*csv.reader(file)][1:]
    return {",".join(row[:6]): tuple(row[6:]) for row in rows}


def write(table: dict) -> None:
    TABLE.parent.mkdir(exist_ok=True)
    TABLE.write_text("\n".join((",".join(HEAD), *(",".join((key, *digests)) for key, digests in table.items()))) + "\n")


def compare(table: dict, before: dict) -> int:
    """Say what differs; how many do."""
    missing = "not there"
    changed = [key for key in {**before, **table} if before.get(key, missing) != table.get(key, missing)]
    for key in changed:
        print(f"{key}: {before.get(key, missing)} before, {table.get(key, missing)} now")
    print(f"{len(table)} integrators, {len(changed)} differ from {TABLE.name}")
    return len(changed)


def main() -> int:
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--update", action="store_true", help="write the table anew")
    words.add_argument("--only", default="", help="cases whose key contains this text")
    words.add_argument("--jobs", type=int, default=2)
    given = words.parse_args()
    chosen = [case for case in cases() if given.only in case.key]
    table = all_bits(chosen, given.jobs)
    if not given.update:
        return int(compare(table, {key: digests for key, digests in kept().items() if given.only in key}) > 0)
    write({**(kept() if given.only else {}), **table})
    print(f"{len(table)} integrators written to {TABLE.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
