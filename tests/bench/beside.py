"""Time a step of every kernel of instructions.py, beside another checkout of smidgen, in turns on one core.

    python tests/bench/beside.py BEFORE                       # BEFORE: a checkout with its .venv; half an hour; out/beside.csv
    python tests/bench/beside.py BEFORE --only gauss --repeats 15

Both compile each model for this processor (-march=native) and take the same starts. N and 2 N steps of both are run in turns, by processor time; the difference
of the medians is the time of N steps. Printed are the ratios now / before, their geometric mean and the largest one. Wants a machine that does nothing else.
"""
from __future__ import annotations

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
COLUMNS = ("spec", "method", "h", "layout", "steps", "before_us", "now_us", "ratio")
WITHIN = 0.08                  # seconds that N steps take at least


# ------------------------------------------------- in either checkout: the programs
def build(place: Path, only: str) -> None:
    """Every kernel's program in a folder of its own; prints their keys, in order."""
    sys.path[0] = str(Path.cwd() / "tests" / "bench")
    import instructions
    instructions.FLAGS = [*instructions.FLAGS, "-march=native"]
    place.mkdir(parents=True, exist_ok=True)
    found = [k for k in instructions.kernels(str(place)) if only in ",".join(k.key)]
    for number, kernel in enumerate(found):
        own = place / str(number)
        own.mkdir(exist_ok=True)
        instructions.compiled(kernel, instructions.spec_of(kernel), own)
    print(json.dumps([[*k.key, k.steps, k.tolerance, k.members] for k in found]))


def built(checkout: Path, place: Path, only: str) -> dict:
    """key -> (its folder, steps, tolerance, members), compiled by a checkout with the interpreter of its environment."""
    words = [checkout / ".venv" / "bin" / "python", "-B", __file__, "--build", place, "--only", only]
    said = subprocess.run([*map(str, words)], cwd=checkout, capture_output=True, text=True)
    if said.returncode:
        raise SystemExit(f"beside.py: {checkout}: {said.stderr[-2000:]}")
    rows = json.loads(said.stdout.splitlines()[-1])
    return {tuple(row[:4]): (place / str(n), *row[4:]) for n, row in enumerate(rows)}


# ------------------------------------------------- the times
def seconds(program: Path, starts: Path, steps: int, h: str, tolerance: float, members: int) -> float:
    """Processor time of one run."""
    child = subprocess.Popen([str(program), str(steps), h, str(tolerance), str(members), str(starts)])
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"beside.py: {program}: exit code {child.returncode}")
    return used.ru_utime + used.ru_stime


def enough(run, steps: int) -> int:
    """So many steps that they take WITHIN."""
    while run(2 * steps) - run(steps) < WITHIN and steps < 1 << 24:
        steps *= 2
    return steps


def pair(before: tuple, now: tuple, h: str, repeats: int) -> tuple:
    """(steps, microseconds a step of a member before, now)."""
    folder, steps, tolerance, members = now
    runs = [lambda n, place=place: seconds(place / "steps", folder / "starts", n, h, tolerance, members) for place in (before[0], folder)]
    steps = max(enough(run, steps) for run in runs)
    taken = {(which, n): [] for which in (0, 1) for n in (1, 2)}
    for _ in range(repeats):
        for which, n in taken:
            taken[which, n].append(runs[which](n * steps))
    medians = [statistics.median(b - a for a, b in zip(taken[which, 1], taken[which, 2])) for which in (0, 1)]
    return steps, *(1e6 * t / steps / members for t in medians)


def line(key: tuple, before: tuple, now: tuple, repeats: int) -> dict:
    steps, was, is_now = pair(before, now, key[2], repeats)
    print(f"{is_now / was:.3f}  {'  '.join(key)}  {was:.4g} -> {is_now:.4g} us", flush=True)
    return dict(zip(COLUMNS, (*key, steps, f"{was:.6g}", f"{is_now:.6g}", f"{is_now / was:.4f}")))


def told(lines: list) -> None:
    ratios = sorted((float(one["ratio"]), one) for one in lines)
    mean = statistics.geometric_mean([ratio for ratio, _ in ratios])
    print(f"{len(ratios)} kernels: geometric mean {mean:.3f}; above 1.08: {sum(ratio > 1.08 for ratio, _ in ratios)}; the largest: {ratios[-1][0]:.3f}")


def written(path: Path, lines: list) -> None:
    from machine import machine
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as f:
        f.write(f"# microseconds a step (of one member), in turns; -march=native; {machine()}; load {os.getloadavg()[0]:.1f}\n")
        table = csv.DictWriter(f, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path, nargs="?", metavar="BEFORE")
    parser.add_argument("--only", metavar="TEXT", default="")
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "beside.csv")
    parser.add_argument("--build", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.build:
        return build(args.build, args.only) or 0
    with tempfile.TemporaryDirectory() as folder:
        before, now = (built(checkout.resolve(), Path(folder, name), args.only) for name, checkout in (("before", args.before), ("now", ROOT)))
        lines = [line(key, before[key], now[key], args.repeats) for key in now if key in before]
    written(args.out, lines)
    told(lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
