"""How round-off grows, and what it costs to make it grow less: docs/round_off.csv, _cost.csv and .md.

    python tests/bench/round_off.py               # three quarters of an hour: measures everything, then writes the page
    python tests/bench/round_off.py free cost     # some of its tables again
    python tests/bench/round_off.py --page        # the page, from the tables that are there
"""
import argparse
import sys
import tempfile
from dataclasses import astuple, replace
from pathlib import Path

from machine import machine
from round_off.costs import costs
from round_off.growth import TABLES, measured
from round_off.page import page
from round_off.rows import Cost, Growth, keep_row, read_rows

HERE = Path(__file__).resolve().parent
DOCS = HERE.parent.parent / "docs"


def measure(table: str, where: Path, docs: Path):
    """One table; a row is kept as soon as it is there."""
    path = docs / ("round_off_cost.csv" if table == "cost" else "round_off.csv")
    for row in costs(where) if table == "cost" else measured(table, where):
        print(*astuple(row)[:-1], file=sys.stderr, flush=True)
        keep_row(path, replace(row, machine=machine()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="*", help=f"of {', '.join(TABLES)}; all by default")
    parser.add_argument("--page", action="store_true", help="only write the page")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the tables and the page go")
    given = parser.parse_args()
    if unknown := set(given.tables) - set(TABLES):
        parser.error(f"no table {', '.join(sorted(unknown))}; there are: {', '.join(TABLES)}")
    with tempfile.TemporaryDirectory() as folder:
        for table in () if given.page else given.tables or TABLES:
            measure(table, Path(folder), given.docs)
    (given.docs / "round_off.md").write_text(page(read_rows(given.docs / "round_off.csv", Growth),
                                                  read_rows(given.docs / "round_off_cost.csv", Cost),
                                                  (HERE / "round_off.md.in").read_text()))


if __name__ == "__main__":
    sys.exit(main())
