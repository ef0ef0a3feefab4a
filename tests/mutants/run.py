"""`make mutants`: draw faults, plant each, run the tests, write docs/mutants.md and docs/mutants.csv."""
import argparse
import hashlib
import json
import re
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue

HERE = Path(__file__).resolve().parent
if __name__ == "__main__":
    sys.path.insert(0, str(HERE.parent))

from mutants.judge import LONGEST, baseline, judge, test_files  # noqa: E402
from mutants.operators import candidates  # noqa: E402
from mutants.plant import Tree  # noqa: E402
from mutants.report import Outcome, write  # noqa: E402
from mutants.rules import RULES  # noqa: E402

ROOT = HERE.parent.parent
DRAWN = {"sign": 10, "coefficient": 8, "time": 6, "jacobian": 8, "branch": 8, "tolerance": 7, "wrap": 8,
         "comparison": 7, "index": 9, "operator": 5, "constant": 5, "statement": 5}


def drawn(found, kind: str, seed: int) -> list:
    """All mutants of a kind in the order of the draw: file after file in turn, at random within."""
    def lot(*what):
        return hashlib.sha256(repr((seed, kind, *what)).encode()).hexdigest()
    by_file = {}
    for m in sorted((m for m in found if m.kind == kind), key=lambda m: lot(m.id)):
        by_file.setdefault(m.file, []).append(m)
    rows = [by_file[file] for file in sorted(by_file, key=lot)]
    return [row[k] for k in range(max(map(len, rows), default=0)) for row in rows if k < len(row)]


class Trial:
    """The trees of the jobs, what the unchanged tree gives, and how one mutant is tried."""

    def __init__(self, place: Path, jobs: int):
        self.trees = Queue()
        for k in range(jobs):
            self.trees.put(Tree(ROOT, place / str(k)))
        self.lock, self.plain = threading.Lock(), {}

    def measure(self, jobs: int, kept: Path | None):
        """The unchanged tree: which tests pass, and how long each takes; from the file `kept`, if it is there."""
        if kept and kept.exists():
            self.seconds, self.failing = json.loads(kept.read_text())
        else:
            self.measure_now(jobs)
        if kept:
            kept.write_text(json.dumps([self.seconds, self.failing]))
        self.dear = [name for name, s in self.seconds.items() if s > LONGEST]

    def measure_now(self, jobs: int):
        files = test_files(ROOT)
        shares = [files[k::jobs] for k in range(jobs)]
        with ThreadPoolExecutor(jobs) as pool:
            parts = list(pool.map(lambda share: self.with_tree(lambda tree: baseline(tree, share)), shares))
        self.seconds = {name: s for passed, _ in parts for name, s in passed.items()}
        self.failing = [name for _, failed in parts for name in failed]

    def with_tree(self, work):
        tree = self.trees.get()
        try:
            return work(tree)
        finally:
            self.trees.put(tree)

    def __call__(self, mutant) -> Outcome:
        return self.with_tree(lambda tree: self.on(tree, mutant))

    def on(self, tree: Tree, mutant) -> Outcome:
        began = time.monotonic()
        tree.plant(mutant)
        try:
            what, by = self.verdict(tree, mutant)
        finally:
            tree.heal(mutant)
        return Outcome(mutant, what, by, time.monotonic() - began)

    def verdict(self, tree: Tree, mutant):
        runtime = mutant.file.startswith("runtime/")
        if tree.digests("few", "syntax") is None:
            return "does not compile", ""
        found = judge(tree, self.seconds, mutant.kind, runtime or mutant.file == "gen/ordering.py")
        if found:
            return "caught", found
        return ("changes nothing", "") if self.same(tree, mutant) else ("survived", "")

    def same(self, tree: Tree, mutant) -> bool:
        """Is the object code of every model what it is without the fault?"""
        if mutant.file.startswith("runtime/"):
            return tree.digests("few", "objects") == self.without(tree, mutant, "few", "objects")
        now, before = tree.digests("all", "text"), self.without(tree, mutant, "all", "text")
        if now is None or now.keys() != before.keys():
            return False
        differ = [name for name in now if now[name] != before[name]]
        return not differ or tree.digests("all", "objects", *differ) == self.without(tree, mutant, "all", "objects", *differ)

    def without(self, tree: Tree, mutant, *what):
        """The digests of the tree as it is without the fault; kept, for others will ask."""
        with self.lock:
            if what not in self.plain:
                tree.heal(mutant)
                self.plain[what] = tree.digests(*what)
                tree.plant(mutant)
            return self.plain[what]


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


def stale() -> list:
    """Rules that fit no line any more."""
    texts = {p: p.read_text() for p in ROOT.glob("*/**/*.*") if p.suffix in (".h", ".j2", ".py")}
    return [rule for rule in RULES if not any(
        p.relative_to(ROOT).match(rule[1]) and re.search(rule[2], text, re.MULTILINE) for p, text in texts.items())]


def options():
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--jobs", type=int, default=2)
    words.add_argument("--only", help="one mutant, by its id")
    words.add_argument("--kind", help="mutants of this kind alone; nothing is written")
    words.add_argument("--part", type=float, default=1, help="this part of the usual number of each kind; nothing is written")
    words.add_argument("--times", type=Path, help="a file that keeps what the unchanged tree takes from one run to the next")
    words.add_argument("--list", action="store_true", help="how many there are, and what would be drawn")
    return words.parse_args()


def listing(found, seed) -> None:
    for kind, count in DRAWN.items():
        order = drawn(found, kind, seed)
        print(f"{kind}: {len(order)} candidates, {count} drawn")
        for m in order[:count]:
            print(f"  {m.id}  {m.file}:{m.line}\n    - {m.old.strip()}\n    + {m.new.strip()}")
    for rule in stale():
        print("fits no line:", rule)


def queues_of(found, chosen) -> dict:
    """{kind: (mutants in the order of the draw, how many are wanted)}."""
    if chosen.only:
        return {"": ([m for m in found if m.id == chosen.only], 1)}
    kinds = [chosen.kind] if chosen.kind else DRAWN
    return {k: (drawn(found, k, chosen.seed), max(1, round(DRAWN[k] * chosen.part))) for k in kinds}


def main() -> int:
    chosen, found = options(), candidates(ROOT)
    if chosen.list:
        listing(found, chosen.seed)
        return 0
    whole = not (chosen.only or chosen.kind or chosen.part != 1)
    with tempfile.TemporaryDirectory(prefix="mutants-") as place:
        trial = Trial(Path(place), chosen.jobs)
        trial.measure(chosen.jobs, chosen.times)
        print(f"{len(trial.seconds)} tests pass on the unchanged tree in {sum(trial.seconds.values()):.0f} s", flush=True)
        for name in trial.failing:
            print("fails on the unchanged tree, left out:", name)
        outcomes = try_all(trial, queues_of(found, chosen), chosen.jobs, say)
    return write(ROOT, outcomes, trial, chosen.seed, len(found), whole)


if __name__ == "__main__":
    sys.exit(main())
