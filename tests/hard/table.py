"""Runs the hard cases, prints their table and writes docs/hard.md.

    PYTHONPATH=tests python -m hard.table                # both tiers, then the page
    PYTHONPATH=tests python -m hard.table --tier quick   # the quick tier, printed only
    PYTHONPATH=tests python -m hard.table --page         # the page from docs/hard.csv
    PYTHONPATH=tests python -m hard.table ring           # the cases whose name contains "ring", printed only
    PYTHONPATH=tests python -m hard.table ring --merge   # the same, and their rows replaced in the page

The exit code is 1 when a row does not hold.
"""
import argparse
import csv
import importlib
import sys
import time
from dataclasses import dataclass, fields
from pathlib import Path
from string import Template

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .case import CASES, TIERS, Case, Row

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
SUBJECTS = ("vortices", "rings", "spins", "bodies", "chains", "rough", "strengths", "nambu", "held", "driven", "edges")
MODULES = {name: importlib.import_module(f"{__package__}.{name}") for name in SUBJECTS}


@dataclass(frozen=True)
class Line:
    """A row of docs/hard.csv."""
    case: str
    tier: str
    what: str
    criterion: str
    measured: str
    holds: str


def chosen(tiers, word) -> list[Case]:
    """The cases of these tiers whose name contains `word`."""
    return [c for c in CASES if c.tier in tiers and word in c.name]


def table_of(one: Case, rows: list[Row], took: float) -> Table:
    """A case as a table for the terminal."""
    table = Table(title=f"{one.name}  [dim]({one.tier}, {took:.1f} s)[/]", title_justify="left", caption=one.about,
                  caption_justify="left", expand=True)
    for name, share in (("", 1), ("quantity", 14), ("criterion", 10), ("measured", 10)):
        table.add_column(name, ratio=share, overflow="fold")
    for row in rows:
        table.add_row("[green]✓[/]" if row.holds else "[bold red]✗[/]", *map(escape, (row.what, row.criterion, row.measured)))
    return table


def measure(cases) -> list[Line]:
    """All rows of the cases, each case printed as it ends."""
    console, found = Console(width=None if sys.stdout.isatty() else 150), []
    for one in cases:
        began = time.perf_counter()
        rows = one.run()
        console.print(table_of(one, rows, time.perf_counter() - began))
        found += [Line(one.name, one.tier, r.what, r.criterion, r.measured, "yes" if r.holds else "NO") for r in rows]
    failed = [line for line in found if line.holds != "yes"]
    console.print(f"{len(cases)} cases, {len(found)} rows, {len(failed)} failed, none skipped")
    for line in failed:
        console.print(f"[red]failed[/] {escape(f'{line.case}: {line.what}: expected {line.criterion}, found {line.measured}')}")
    return found


# -- the page ---------------------------------------------------------------------------------------

def write_table(lines):
    """docs/hard.csv."""
    with (DOCS / "hard.csv").open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow([f.name for f in fields(Line)])
        out.writerows([getattr(line, f.name) for f in fields(Line)] for line in lines)


def read_table() -> list[Line]:
    """The rows of docs/hard.csv."""
    with (DOCS / "hard.csv").open(newline="") as file:
        return [Line(**row) for row in csv.DictReader(file)]


def merged(lines) -> list[Line]:
    """The rows of docs/hard.csv with those of the cases in `lines` replaced, in the order of the cases."""
    new = {line.case for line in lines}
    old = [line for line in read_table() if line.case not in new] if (DOCS / "hard.csv").exists() else []
    return [line for c in CASES for line in (*lines, *old) if line.case == c.name]


def cell(text: str) -> str:
    """A text that a Markdown table takes as it is."""
    return text.replace("|", "\\|").replace("*", "\\*").replace("<", "&lt;")


def case_text(one: Case, lines) -> str:
    """A case in Markdown: what it asks, then its rows."""
    rows = [f"| {cell(r.what)} | {cell(r.criterion)} | {cell(r.measured)} | {r.holds} |" for r in lines if r.case == one.name]
    tier = "" if one.tier == "quick" else f" ({one.tier} tier)"
    return "\n".join([f"### {one.name}{tier}", "", one.about, "", "| quantity | criterion | measured | pass |", "|---|---|---|---|", *rows])


def subject_text(name: str, lines) -> str:
    """A subject: its laws, from the head of its module, then its cases."""
    title, _, laws = MODULES[name].__doc__.strip().partition("\n")
    return "\n\n".join([f"## {title}", laws.strip(), *(case_text(c, lines) for c in CASES if c.law == name)])


def summary(lines) -> str:
    """How many cases, and a line for each."""
    failed = sum(line.holds != "yes" for line in lines)
    head = f"{len(CASES)} cases, {len(lines)} rows, {failed} failed, none skipped."
    each = [f"| {c.name} | {c.tier} | {sum(r.case == c.name for r in lines)} | "
            f"{'yes' if all(r.holds == 'yes' for r in lines if r.case == c.name) else 'NO'} |" for c in CASES]
    return "\n".join([head, "", "| case | tier | rows | pass |", "|---|---|---|---|", *each])


def page(lines) -> str:
    """The text of docs/hard.md."""
    return Template((HERE / "hard.md.in").read_text()).substitute(
        summary=summary(lines), subjects="\n\n".join(subject_text(name, lines) for name in SUBJECTS))


def write_page():
    """docs/hard.md from docs/hard.csv."""
    (DOCS / "hard.md").write_text(page(read_table()))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("word", nargs="?", default="", help="only cases whose name contains it")
    parser.add_argument("--tier", choices=TIERS, help="only this tier")
    parser.add_argument("--merge", action="store_true", help="put the rows of these cases into the table and the page")
    parser.add_argument("--page", action="store_true", help="only write the page from the table")
    asked = parser.parse_args()
    if asked.page:
        return write_page() or 0
    cases = chosen((asked.tier,) if asked.tier else TIERS, asked.word)
    if not cases:
        parser.error(f"no case contains '{asked.word}'")
    lines = measure(cases)
    if asked.merge or len(cases) == len(CASES):
        write_table(merged(lines))
        write_page()
    return int(any(line.holds != "yes" for line in lines))


if __name__ == "__main__":
    sys.exit(main())
