"""`make mutants`: draw faults, plant each, run the tests, write docs/mutants.md and docs/mutants.csv."""
import argparse
import hashlib
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
if __name__ == "__main__":
    sys.path.insert(0, str(HERE.parent))

from mutants.judge import test_files  # noqa: E402
from mutants.operators import GENERATOR, STEP, candidates, stale  # noqa: E402
from mutants.record import Record  # noqa: E402
from mutants.report import Outcome, write  # noqa: E402
from mutants.trial import Trial  # noqa: E402

ROOT = HERE.parent.parent
DRAWN = {"sign": 7, "coefficient": 6, "time": 5, "jacobian": 5, "branch": 6, "tolerance": 5, "wrap": 5, "rows": 6, "method": 6,
         "comparison": 5, "index": 6, "operator": 4, "constant": 4, "statement": 4}


def drawn(found, kind: str, seed: int) -> list:
    """All mutants of a kind in the order of the draw: file after file in turn, at random within."""
    def lot(*what):
        return hashlib.sha256(repr((seed, kind, *what)).encode()).hexdigest()
    by_file = {}
    for m in sorted((m for m in found if m.kind == kind), key=lambda m: lot(m.id)):
        by_file.setdefault(m.file, []).append(m)
    rows = [by_file[file] for file in sorted(by_file, key=lot)]
    return [row[k] for k in range(max(map(len, rows), default=0)) for row in rows if k < len(row)]


def try_kind(trial, queue, wanted: int, pool, say) -> list:
    """The first `wanted` of a kind that compile and change something, and those passed over before them."""
    done, pending, queue = [], [], list(queue)
    while True:
        good = sum(o.counts for o in done)
        while queue and good + len(pending) < wanted:
            pending.append(pool.submit(trial, queue.pop(0)))
        if not pending:
            return done
        done.append(pending.pop(0).result())
        say(done[-1])


def try_all(trial, queues: dict, jobs: int, say) -> list:
    """Outcomes of all kinds; the kinds take turns at the jobs."""
    with ThreadPoolExecutor(jobs) as pool, ThreadPoolExecutor(len(queues)) as kinds:
        futures = [kinds.submit(try_kind, trial, queue, wanted, pool, say) for queue, wanted in queues.values()]
        return [o for f in futures for o in f.result()]


def say(outcome: Outcome) -> None:
    m = outcome.mutant
    print(f"{m.id:22} {outcome.what:16} {outcome.seconds:5.0f} s  {m.file}:{m.line}  {outcome.by}", flush=True)


def options():
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--jobs", type=int, default=2)
    words.add_argument("--only", help="one mutant, by its id; nothing is written")
    words.add_argument("--kind", help="mutants of this kind alone; nothing is written")
    words.add_argument("--part", type=float, default=1, help="this part of the usual number of each kind; nothing is written")
    words.add_argument("--generator", action="store_true", help="faults in the modules that decide the C; nothing is written")
    words.add_argument("--record", type=Path, default=ROOT / "out/mutants", help="the folder that lets an interrupted run go on")
    words.add_argument("--list", action="store_true", help="how many there are, and what would be drawn")
    return words.parse_args()


def listing(found, seed) -> None:
    for kind, count in DRAWN.items():
        order = drawn(found, kind, seed)
        print(f"{kind}: {len(order)} candidates, {count} drawn")
        for m in order[:count]:
            print(f"  {m.id}  {m.file}:{m.line}\n    - {m.old.strip()}\n    + {m.new.strip()}")
    for rule in stale(ROOT):
        print("fits no line:", rule)


def queues_of(found, chosen) -> dict:
    """{kind: (mutants in the order of the draw, how many are wanted)}."""
    if chosen.only:
        return {"": ([m for m in found if m.id == chosen.only], 1)}
    kinds = [chosen.kind] if chosen.kind else DRAWN
    return {k: (drawn(found, k, chosen.seed), max(1, round(DRAWN[k] * chosen.part))) for k in kinds}


def main() -> int:
    chosen = options()
    found = candidates(ROOT, GENERATOR if chosen.generator else STEP)
    if chosen.list:
        listing(found, chosen.seed)
        return 0
    whole = not (chosen.only or chosen.kind or chosen.generator or chosen.part != 1)
    with tempfile.TemporaryDirectory(prefix="mutants-") as place:
        trial = Trial(ROOT, Path(place), chosen.jobs, Record(ROOT, chosen.record))
        trial.measure(test_files(ROOT), lambda text: print(text, flush=True))
        print(f"{len(trial.tests)} tests pass on the unchanged tree in {sum(s for s, _ in trial.tests.values()):.0f} s", flush=True)
        for name in trial.failing:
            print("fails on the unchanged tree, left out:", name)
        outcomes = try_all(trial, queues_of(found, chosen), chosen.jobs, say)
        while wrong := trial.unsound(outcomes):
            print("fail without a fault, too:", *wrong, flush=True)
            outcomes = try_all(trial, queues_of(found, chosen), chosen.jobs, say)
    return write(ROOT, outcomes, trial, chosen.seed, len(found), whole)


if __name__ == "__main__":
    sys.exit(main())
