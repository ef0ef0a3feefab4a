"""docs/mutants.csv: what became of every mutant; docs/mutants.md: the summary, and the survivors explained."""
import csv
import tomllib
from dataclasses import dataclass
from pathlib import Path

from .operators import SPARED, Mutant

HERE = Path(__file__).parent
COLUMNS = ("id", "kind", "file", "line", "old", "new", "outcome", "by", "seconds")
LEAST = 0.95        # part of the mutants that the tests must catch


@dataclass(frozen=True)
class Outcome:
    """what: 'caught' (by which test), 'survived', or one that does not count: 'does not compile', 'changes nothing'."""
    mutant: Mutant
    what: str
    by: str
    seconds: float

    @property
    def counts(self) -> bool:
        return self.what in ("caught", "survived")

    @property
    def test(self) -> str:
        """The test that noticed it."""
        return self.by.removesuffix(" (crash)").removesuffix(" (hang)")


def explanations() -> dict:
    return tomllib.loads((HERE / "explained.toml").read_text())


def write(root: Path, outcomes, trial, seed: int, candidates: int, whole: bool) -> int:
    """Say how it went and, of a whole run, write the two files. Exit status: 0 when enough were caught, all else explained."""
    counted = [o for o in outcomes if o.counts]
    lived = [o for o in counted if o.what == "survived"]
    print(f"{len(counted) - len(lived)} of {len(counted)} caught; survivors: {[o.mutant.id for o in lived]}")
    if whole:
        (root / "docs/mutants.md").write_text(page(outcomes, trial, seed, candidates))
        with open(root / "docs/mutants.csv", "w", newline="") as out:
            rows = csv.writer(out, lineterminator="\n")
            rows.writerow(COLUMNS)
            rows.writerows(row(o) for o in outcomes)
    unexplained = [o.mutant.id for o in lived if o.mutant.id not in explanations()]
    if unexplained:
        print("no reason in explained.toml:", *unexplained)
    return int(bool(unexplained) or len(lived) > (1 - LEAST) * len(counted))


def row(o: Outcome):
    m = o.mutant
    return m.id, m.kind, m.file, m.line, m.old.strip(), m.new.strip(), o.what, o.by, f"{o.seconds:.0f}"


def table(head, rows) -> str:
    return "\n".join([f"| {' | '.join(head)} |", "|" + "---|" * len(head),
                      *(f"| {' | '.join(map(str, r))} |" for r in rows)])


def tally(outcomes, of) -> list:
    """Rows (name, tried, caught) by a property of the mutant."""
    names = sorted({of(o.mutant) for o in outcomes})
    mine = {n: [o for o in outcomes if of(o.mutant) == n] for n in names}
    return [(n, len(mine[n]), sum(o.what == "caught" for o in mine[n])) for n in names]


def code(text: str) -> str:
    return "`" + text.strip().replace("|", "\\|") + "`"


def survivor(o: Outcome) -> str:
    m = o.mutant
    reason = explanations().get(m.id, {}).get("reason", "not explained yet")
    return f"**{m.id}**, {m.file}\n\n    - {m.old.strip()}\n    + {m.new.strip()}\n\n{reason.strip()}\n"


def killers(counted) -> list:
    """(file of tests, how many mutants it caught first)."""
    files = [o.by.partition("::")[0].removeprefix("tests/") for o in counted if o.what == "caught"]
    return sorted(((f, files.count(f)) for f in set(files)), key=lambda r: (-r[1], r[0]))


def page(outcomes, trial, seed: int, candidates: int) -> str:
    counted = [o for o in outcomes if o.counts]
    lived = [o for o in counted if o.what == "survived"]
    passed = [o for o in outcomes if not o.counts]
    none = ["None.\n"]
    return "\n".join([
        "# Mutants\n", "This page is written by `make mutants`. A mutant is a copy of the code with one small fault planted in it; the tests should catch it. All mutants and their results are in [mutants.csv](mutants.csv).\n",
        f"Of {candidates} faults that could be planted in the templates and the runtime, seed {seed} drew "
        f"{len(counted)}; the tests caught **{len(counted) - len(lived)}** ({100 * (1 - len(lived) / max(1, len(counted))):.1f} %). "
        "Tests that compare generated C with a stored text, or only compile it, were not used.\n",
        f"Mutants that did not count: {sum(o.what == 'does not compile' for o in passed)} that could not generate or compile a model, "
        f"{sum(o.what == 'changes nothing' for o in passed)} that did not change the object code of any model.\n",
        "## Survivors\n", *([survivor(o) for o in lived] or none),
        "## By kind\n", table(("kind", "planted", "caught"), tally(counted, lambda m: m.kind)) + "\n",
        "## By place\n", table(("file", "planted", "caught"), tally(counted, lambda m: m.file)) + "\n",
        "## First to notice\n", table(("test file", "mutants caught first"), killers(counted)) + "\n",
        "## Where no faults are planted\n",
        table(("files", "lines that match", "reason"), [(f"`{f}`", code(p), why) for f, p, why in SPARED]) + "\n",
        "## Tests left out\n", "Tests that are too expensive, or that fail even without a mutant:\n",
        *([f"- {name}" for name in (*trial.failing, *trial.dear)] or none)])
