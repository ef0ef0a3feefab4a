"""One mutant is tried: planted in a copy of the tree, looked at by the compiler, run through the tests, healed."""
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue

from support.features import ANYWHERE, DIVIDED
from smidgen.methods import MIDPOINTS as METHODS

from .judge import LONGEST, baseline, failing, judge, order_of
from .plant import Tree
from .record import Record
from .report import Outcome

# Together they use every template and header.
SPHERICAL, CLASSICAL, VESELOV = METHODS
MODELS = tuple("/".join(words) for words in (
    *((name, method, "auto") for name, method in (
        ("free_rigid_body", "axis-splitting"), ("free_rigid_body", "dop853-projected"), ("free_rigid_body", "cf4"), ("free_rigid_body", "spherical-midpoint-8"),
        ("free_rigid_body", "isospectral-midpoint"), ("free_rigid_body", "exponential-midpoint"), ("free_rigid_body", "rattle"),
        ("heisenberg_chain", "gauss-6"), ("heisenberg_chain", "sublattice-rotations"),
        ("heisenberg_chain", "pair-rotations"), ("heisenberg_chain", "spherical-midpoint-4"), ("point_vortices", "gauss-10"),
        ("point_vortices", "geodesic-midpoint"))),
    ("free_rigid_body", SPHERICAL, "auto"), ("free_rigid_body", VESELOV, "auto"), ("product", SPHERICAL, "rotation"),
    ("cubic_lattice", SPHERICAL, "auto"), ("glass", SPHERICAL, "newton"), ("heisenberg_chain", CLASSICAL, "auto"),
    ("heisenberg_chain", SPHERICAL, "auto", *ANYWHERE), ("heisenberg_chain", SPHERICAL, "auto", *DIVIDED)))



class Trial:
    """The trees of the jobs, what the unchanged tree gives, and what is known from before."""

    def __init__(self, root: Path, place: Path, jobs: int, record: Record):
        self.trees, self.jobs, self.record = Queue(), jobs, record
        for k in range(jobs):
            self.trees.put(Tree(root, place / str(k)))
        self.lock, self.plain, self.known = threading.Lock(), {}, record.tried()

    def measure(self, files, say) -> None:
        """Which tests pass on the unchanged tree, and how long each takes; those measured before are not run again. Raises
        RuntimeError where that tree itself does not compile: every fault would be passed over."""
        if self.with_tree(lambda tree: tree.digests("few", "syntax", "headers", *MODELS)) is None:
            raise RuntimeError("the unchanged tree does not compile: python tests/mutants/compiles.py few syntax headers")
        measured = self.record.unchanged(files)
        with ThreadPoolExecutor(self.jobs) as pool:
            for file, found in pool.map(self.measure_one, [f for f in files if f not in measured]):
                measured[file] = found
                say(f"{file}: {len(found['tests'])} pass, {len(found['failing'])} do not")
        self.tests = {name: of for m in measured.values() for name, of in m["tests"].items()}
        self.failing = sorted(name for m in measured.values() for name in m["failing"])
        self.dear = [name for name, (seconds, _) in self.tests.items() if seconds > LONGEST]

    def measure_one(self, file: str):
        found = self.with_tree(lambda tree: baseline(tree, file))
        self.record.keep({file: found})
        return file, found

    def with_tree(self, work):
        tree = self.trees.get()
        try:
            return work(tree)
        finally:
            self.trees.put(tree)

    def __call__(self, mutant) -> Outcome:
        if mutant.id in self.known:
            return self.known[mutant.id]
        outcome = self.with_tree(lambda tree: self.on(tree, mutant))
        self.record.add(outcome)
        self.known[mutant.id] = outcome
        return outcome

    def on(self, tree: Tree, mutant) -> Outcome:
        began = time.monotonic()
        tree.plant(mutant)
        try:
            what, by = self.verdict(tree, mutant)
        finally:
            tree.heal(mutant)
        return Outcome(mutant, what, by, time.monotonic() - began)

    def verdict(self, tree: Tree, mutant):
        """('caught', by which test), ('does not compile', ''), ('changes nothing', '') or ('survived', '')."""
        sharp, quick = order_of(self.tests, mutant)
        if tree.digests("few", "syntax", *MODELS, *(["headers"] if mutant.file.startswith("runtime/") else [])) is None:
            return "does not compile", ""
        found = judge(tree, self.tests, sharp) or judge(tree, self.tests, quick)
        if found:
            return "caught", found
        return ("changes nothing" if self.same(tree, mutant) else "survived"), ""

    def unsound(self, outcomes) -> list[str]:
        """The tests that noticed a fault and fail without one as well: they are not asked again, nor believed."""
        noticed = sorted({o.test for o in outcomes if o.what == "caught"})
        wrong = self.with_tree(lambda tree: failing(tree, self.tests, noticed))
        for name in wrong:
            self.tests.pop(name, None)
        self.known = {id: o for id, o in self.known.items() if o.test not in wrong}
        self.failing += wrong
        return wrong

    def same(self, tree: Tree, mutant) -> bool:
        """Is the object code of every model what it is without the fault? A few models first: most faults show there."""
        if tree.digests("few", "objects") != self.without(tree, mutant, "few", "objects"):
            return False
        now, before = tree.digests("all", "text"), self.without(tree, mutant, "all", "text")
        if now is None or now.keys() != before.keys():
            return False
        differ = [name for name in now if now[name] != before[name]]
        if mutant.file.startswith("runtime/"):
            differ = list(now)
        return not differ or tree.digests("all", "objects", *differ) == self.without(tree, mutant, "all", "objects", *differ)

    def without(self, tree: Tree, mutant, *what):
        """The digests of the tree as it is without the fault; kept, for others will ask."""
        with self.lock:
            if what not in self.plain:
                tree.heal(mutant)
                self.plain[what] = tree.digests(*what)
                tree.plant(mutant)
            return self.plain[what]
