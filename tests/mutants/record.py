"""What was tried before: an interrupted run goes on where it stopped.

`outcomes.jsonl` receives a line a mutant as soon as its outcome is known. That a test notices a fault holds as
long as the line is there and the test passes without the fault; that none does, as long as the file in which it is
planted and the tests stay as they are.
`tests.json` has what each file of tests gave on the unchanged tree, and in how many seconds.
"""
import hashlib
import json
import threading
from dataclasses import asdict
from pathlib import Path

from .operators import Mutant
from .report import Outcome


def digest(files) -> str:
    """Of the contents of files, in order of their names."""
    both = hashlib.sha256()
    for path in sorted(files):
        both.update(path.name.encode() + b"\0" + path.read_bytes())
    return both.hexdigest()[:16]


class Record:
    """Outcomes by mutant, and tests by file; safe to use from several threads."""

    def __init__(self, root: Path, place: Path):
        self.root, self.place = root, place
        self.place.mkdir(parents=True, exist_ok=True)
        self.tests = digest(p for p in (root / "tests").rglob("*.*") if p.suffix in (".py", ".c", ".h") and "mutants" not in p.parts)
        self.lock = threading.Lock()

    def tried(self) -> dict:
        """{id: Outcome} of the mutants whose outcome is known."""
        path, found = self.place / "outcomes.jsonl", {}
        for line in path.read_text().splitlines() if path.exists() else ():
            entry = json.loads(line)
            file = self.root / entry["mutant"]["file"]
            same = file.exists() and digest([file]) == entry["code"] and entry["tests"] == self.tests
            if same or entry["what"] == "caught":
                found[entry["mutant"]["id"]] = Outcome(Mutant(**entry["mutant"]), entry["what"], entry["by"], entry["seconds"])
        return found

    def add(self, outcome: Outcome) -> None:
        code = digest([self.root / outcome.mutant.file])
        with self.lock, open(self.place / "outcomes.jsonl", "a") as out:
            out.write(json.dumps(asdict(outcome) | {"code": code, "tests": self.tests}) + "\n")

    def unchanged(self, files) -> dict:
        """{file of tests: {"seconds": {test: s}, "failing": [test]}} of those measured as they are now."""
        path = self.place / "tests.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        return {f: known[f] for f in files if f in known and known[f]["digest"] == digest([self.root / f])}

    def keep(self, measured: dict) -> None:
        """Add what files of tests gave on the unchanged tree."""
        with self.lock:
            path = self.place / "tests.json"
            known = json.loads(path.read_text()) if path.exists() else {}
            known |= {f: m | {"digest": digest([self.root / f])} for f, m in measured.items()}
            path.write_text(json.dumps(known))
