"""Counts of gcov, merged over programs."""
import json
import subprocess
from pathlib import Path


def counts(data: Path, runtime: Path) -> dict:
    """{header: {line number: [times each branch was taken]}} over all programs whose notes lie below `data`.

    Lines without a branch have an empty list; a header that no program includes is missing.
    """
    merged = {}
    for notes in sorted(data.rglob("*.gcno")):
        for file in files_of(notes):
            path = Path(file["file"])
            if runtime in path.parents:
                merge(merged.setdefault(path.name, {}), file["lines"])
    return merged


def files_of(notes: Path) -> list:
    """What gcov says of one program; of one that never ran, too."""
    said = subprocess.run(["gcov", "--branch-probabilities", "--branch-counts", "--json-format", "--stdout", notes.name],
                          cwd=notes.parent, capture_output=True, text=True, check=True)
    return [file for line in said.stdout.splitlines() if line.startswith("{") for file in json.loads(line)["files"]]


def merge(into: dict, lines: list) -> None:
    """Add the counts of one program; a line holds the same branches in each."""
    for line in lines:
        taken = into.setdefault(line["line_number"], [])
        found = [b["count"] for b in line["branches"] if not b["throw"]]
        taken += [0] * (len(found) - len(taken))
        for k, count in enumerate(found):
            taken[k] += count
