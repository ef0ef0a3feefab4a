"""`choose` and the error estimate of `run` on Hamiltonians that nobody has looked at: those of the fuzzer.

    python tests/bench/choose_random.py                  # 100 of them, half an hour: choose_random.csv in docs/cost/lanes_N; continues where it stopped
    python tests/bench/choose_random.py --count 5 --out a.csv
    python tests/bench/choose_random.py --rows --count 30    # lattices that go by rows: choose_rows.csv
    python tests/bench/choose_random.py --summary        # what the table shows

Each runs until its fastest site has turned by ANGLE, and an end error is drawn between 1e-3 and 1e-10. True errors are against
the witness, which shares no code with what is chosen. The cost is that of the pick beside the best of the whole sweep of
`smidgen cost`, timed in turn with it. Each estimate is of the chosen run, and of the default method with a step drawn at random.
"""
from __future__ import annotations

import argparse
import csv
import functools
import math
import multiprocessing
import random
import signal
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import smidgen
from machine import cost_tables
from fuzz.by_rows import row_text
from fuzz.invent import any_space, files_of
from smidgen.check.witness import Witness
from smidgen.cost.measure.case import Case, candidates
from smidgen.cost.frontier import seconds_for
from smidgen.cost.measure.reference import reference
from smidgen.cost.measure.sweep import ladder
from smidgen.cost.measure.timing import take_times
from smidgen.errors import SmidgenError, UsageError
from smidgen.run.settings import settle

COLUMNS = ("seed", "sites", "time", "asked", "status", "method", "h", "steps", "tolerance", "error", "seconds", "best", "best_seconds",
           "estimate", "plain_h", "plain_error", "plain_estimate", "known")
ANGLE = 20.0            # of the fastest site of the start over a run
ERRORS = -10.0, -3.0    # powers of ten that are asked for
STEPS = 0.05, 0.5       # turns in a step of the run by the default method, in radians
SWEEP = 0.05            # seconds that a run of the sweep takes at most
ROUND_OFF = 1e-14       # errors below it count as this
LIMIT = 600             # seconds of the clock for one Hamiltonian, of which nearly all are the compiler's
REFUSED = "choose refuses:"     # where the end is known: a failure


def drawn(seed: int, folder: str, rows: bool = False):
    """(spec, case, error asked for, turn of a step of the default method) of a seed."""
    text, dice = (row_text if rows else any_space)(random.Random(seed)), random.Random(f"choose {seed}")
    for name, content in {"model.toml": text, **files_of(text)}.items():
        Path(folder, name).write_text(content, encoding="utf-8")
    spec = smidgen.load(Path(folder, "model.toml"))
    rate = Case(spec, settle(spec), 1.0).rate
    if not rate > 0:
        raise UsageError("nothing moves")
    return spec, Case(spec, settle(spec), ANGLE / rate), 10 ** dice.uniform(*ERRORS), math.exp(dice.uniform(*map(math.log, STEPS)))


def row_of(seed: int, methods=None, rows: bool = False) -> dict:
    """The row of a seed; `status` says why there is no more of it."""
    row = {"seed": seed}
    with tempfile.TemporaryDirectory() as folder:
        try:
            spec, case, asked, turn = drawn(seed, folder, rows)
            row.update(sites=len(case.w), time=case.time, asked=asked)
            known = reference(case)
            witness = Witness(spec, case.settings.parameters, case.settings.effects)
            end = witness.flow(case.w, 0.0, [case.time])[0]
            row["known"] = max(known.error, case.distance(known.end, end))
            if not row["known"] < asked / 20:
                return {**row, "status": "the end is not known"}
            chosen(spec, case, asked, known, row, methods)
            if row["status"] == "ok":
                estimated(spec, case, turn, known, row)
        except SmidgenError as error:
            row["status"] = " ".join(str(error).split())[:120]
    return row


def chosen(spec, case: Case, asked: float, known, row: dict, methods) -> None:
    """The pick, its true error and estimate, and the best of the sweep."""
    try:
        pick = smidgen.choose(spec, error=asked, time=case.time, methods=methods)
    except SmidgenError as error:
        row["status"] = f"{REFUSED} {' '.join(str(error).split())[:100]}"
        return
    run = smidgen.run(spec, **pick.settings, estimate=True)
    rows = [r for name in candidates(case, methods) for r in ladder(case, name, known, SWEEP)]
    take_times(case, [pick.row, *rows], 2.0)
    times = {name: seconds_for([r for r in rows if r.method == name], "end_error", asked) for name in {r.method for r in rows}}
    best = min((n for n in times if times[n] == times[n]), key=times.get, default="")
    row.update(method=pick.row.method, h=pick.row.h, steps=pick.row.steps, tolerance=pick.settings.get("tolerance", ""), status="ok",
               error=case.distance(run.final, known.end), seconds=pick.row.seconds, best=best, best_seconds=times.get(best, math.nan),
               estimate=in_units_of(case, run))


def estimated(spec, case: Case, turn: float, known, row: dict) -> None:
    """The default method with a random step."""
    steps = case.fewest(turn)
    run = smidgen.run(spec, h=case.time / steps, steps=steps, method="spherical-midpoint", estimate=True)
    row.update(plain_h=case.time / steps, plain_error=case.distance(run.final, known.end), plain_estimate=in_units_of(case, run))


def in_units_of(case: Case, run) -> float | None:
    """The estimate of a run, which is in units of the largest |w| of its end, in those of the case, of its start."""
    found = run.meta["end_error"]
    return None if found is None else found * float(np.linalg.norm(run.final, axis=1).max()) / case.size


def too_long(*_):
    raise SmidgenError(f"more than {LIMIT} s")


def many(seeds, count: int, path: Path, jobs: int, methods, rows: bool) -> None:
    """Rows of seeds until `count` Hamiltonians have a choice; those that the file has are not done again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    done = rows_of(path)
    found, had = sum(r["status"] == "ok" for r in done), {int(r["seed"]) for r in done}
    with open(path, "a", newline="") as out, multiprocessing.get_context("spawn").Pool(jobs) as pool:
        table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        if not had:
            table.writeheader()
        for row in pool.imap(functools.partial(within_limit, methods=methods, rows=rows), (s for s in seeds if s not in had)):
            if found >= count:
                return
            found += row.get("status") == "ok"
            table.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
            out.flush()
            print(f"{found}/{count}  seed {row['seed']}: {row.get('status')}", file=sys.stderr, flush=True)


def within_limit(seed: int, methods, rows: bool) -> dict:
    """The row of a seed, in a process of the pool."""
    signal.signal(signal.SIGALRM, too_long)
    signal.alarm(LIMIT)
    try:
        return row_of(seed, methods, rows)
    finally:
        signal.alarm(0)


def rows_of(path: Path) -> list[dict]:
    """The rows of a file, none where there is no file."""
    if not path.exists():
        return []
    with open(path, newline="") as lines:
        return list(csv.DictReader(lines))


def ratio_of(row: dict, estimate: str, error: str) -> float:
    """The estimate by the error, each at least ROUND_OFF and what the reference is off by."""
    mine, true = (max(float(row[name]), float(row["known"]), ROUND_OFF) for name in (estimate, error))
    return mine / true


def words(rows) -> str:
    """What they show."""
    good, failed = ([r for r in rows if r["status"].startswith(word)] for word in ("ok", REFUSED))
    late = sum(r["status"].startswith("more than") for r in rows)
    of = len(good) + len(failed)
    met = sum(float(r["error"]) <= float(r["asked"]) for r in good)
    costs = [float(r["seconds"]) / float(r["best_seconds"]) for r in good if r["best"]]
    said = [f"{of} random Hamiltonians were used. Another {len(rows) - of - late} were omitted because the final state is not resolved or nothing moves, and {late} because they took too long.",
            f"The requested error was met for {met} of {of}; {len(failed)} were refused.",
            f"The time was at most 1.5 times that of the best row of the sweep for {sum(c <= 1.5 for c in costs)} of {of}"
            + (f" (median {np.median(costs):.2f}, largest {max(costs):.2f}; for {len(good) - len(costs)} no row of the sweep is accurate enough)." if costs else ".")]
    for what, error, estimate in (("the chosen run", "error", "estimate"), ("the default method", "plain_error", "plain_estimate")):
        ratios = [ratio_of(r, estimate, error) for r in good if r[error] and r[estimate]]
        said.append(f"The estimated error of {what} was within a factor of 3 of the true error for {sum(1 / 3 <= x <= 3 for x in ratios)} of {len(ratios)}, with "
                    f"ratios between {min(ratios):.2g} and {max(ratios):.2g}. No estimate was given for {sum(not r[estimate] for r in good if r[error])}.")
    return "\n".join(f"- {line}" for line in said)


def main() -> None:
    """Measure, then tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--methods", type=lambda text: tuple(text.split(",")), metavar="A,B", help="of these only, choice and sweep; default: all")
    parser.add_argument("--jobs", type=int, default=2, help="number of processes to run at the same time")
    parser.add_argument("--seed", type=int, default=0, help="the first")
    parser.add_argument("--rows", action="store_true", help="lattices that go by rows, in place of any Hamiltonian")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--summary", action="store_true", help="measure nothing")
    args = parser.parse_args()
    args.out = args.out or cost_tables() / ("choose_rows.csv" if args.rows else "choose_random.csv")
    if not args.summary:
        many(range(args.seed, args.seed + 10 * args.count), args.count, args.out, args.jobs, args.methods, args.rows)
    print(words(rows_of(args.out)))


if __name__ == "__main__":
    main()
