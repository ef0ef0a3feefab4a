"""How many random specs went through, by layout, method and compiler: docs/fuzz_specs.csv, and its tables in docs/fuzzing.md.

    python -m fuzz.table ../out/fuzz/specs.csv --count 1000 --seed 0
    python -m fuzz.table ../out/fuzz/scenes.csv --scenes        # docs/fuzz_scenes.csv

Of scenes it says, too, how many have what.
"""
from __future__ import annotations

import argparse
import collections
import csv
import re
from pathlib import Path

from smidgen.methods import METHODS

from .program import COUNT
from .specs import SCENES

DOCS = Path(__file__).parents[2] / "docs"
BEGIN, END = "<!-- random {0} -->\n", "<!-- end of random {0} -->"
MADE = (*SCENES, "damping", "kT", "torque", "pinned", "absent", "random of sites", "random of bonds", "tracer")
LEVELS = ("-O0", "-O1", "-O2", "-O3")
VERDICTS = ("fine", "refused", "fault")
ENDED = "ended from outside"      # a process that took too long has told nothing
NEVER = "none: refused before the first step"
ALL = str(COUNT)                  # steps; those judged by residuals say nothing else


def layout(row) -> str:
    return row["layout"] or NEVER


def counted(rows) -> list[dict]:
    """One row for each layout, method, program and library that came up: how many specs, and how many of each verdict."""
    found = collections.defaultdict(collections.Counter)
    for r in rows:
        found[layout(r), r["method"] or "none", r["program"] or ENDED, r["library"] or ENDED][r["verdict"]] += 1
    return [dict(zip(("layout", "method", "program", "library"), key), specs=sum(n.values()), **{v: n[v] for v in VERDICTS}) for key, n in sorted(found.items())]


def tables(counts, code: str, seeds: str, fewer: int, what="specs") -> str:
    """Markdown: layouts by kinds of methods, compilers by levels, and what came of all. fewer: specs whose steps were not all judged."""
    total = {v: sum(c[v] for c in counts) for v in ("specs", *VERDICTS)}
    kinds = sorted({kind(c["method"]) for c in counts})
    head = (f"{total['specs']} {what}, {seeds}: {total['fine']} passed, {total['refused']} refused with a status, "
            f"{total['fault']} faults; generator, witness and target {code}. The witness took fewer steps than the program in {fewer} of them, to limit its time. "
            "Rows are the layouts that were actually used, not those for which the specs were written.\n")
    return "\n".join([head, grid(counts, "layout", "layout", kinds, lambda c: kind(c["method"])), "",
                      grid(counts, "program", "program, under the sanitizers", LEVELS, lambda c: c["program"].split()[1], lambda text: text.split()[0]), "",
                      grid(counts, "library", "library", LEVELS, lambda c: c["library"].split()[1], lambda text: text.split()[0]), ""])


def grid(counts, key, title, columns, column_of, shown=str) -> str:
    cells = collections.Counter()
    for c in counts:
        cells[shown(c[key]), column_of(c)] += c["specs"]
    names = sorted({row for row, _ in cells})
    lines = [f"| {title} | {' | '.join(columns)} | all |", f"|---|{'---|' * (len(columns) + 1)}"]
    return "\n".join(lines + [f"| {n} | {' | '.join(str(cells[n, c] or '') for c in columns)} | {sum(cells[n, c] for c in columns)} |" for n in names])


def kind(method: str) -> str:
    """Methods of one kind together: compositions, Gauss collocation, splittings, step control and extrapolation."""
    if method not in METHODS:
        return "none"
    m = METHODS[method]
    if m.splitting:
        return "splittings"
    if m.stages > 1:
        return "compositions"
    return "Gauss" if m.stage_rows else method if m.midpoint else "general" if m.by_field else "comparators"


def made_of(rows) -> str:
    """How many scenes have what."""
    found = collections.Counter(kind for r in rows for kind in r["kinds"].split("|"))
    return "\n".join(["", "| scenes with | number |", "|---|---|", *(f"| {kind} | {found[kind]} |" for kind in MADE), ""])


def write(rows, code: str, seeds: str, docs=DOCS, what="specs") -> None:
    """Both files; the tables of the page stand between two marks."""
    counts = counted(rows)
    fewer = sum(r["verdict"] == "fine" and (r.get("judged") or ALL) != ALL for r in rows)
    with open(docs / f"fuzz_{what}.csv", "w", newline="") as out:
        table = csv.DictWriter(out, list(counts[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(counts)
    page = (docs / "fuzzing.md").read_text()
    begin, end = BEGIN.format(what), END.format(what)
    text = tables(counts, code, seeds, fewer, what) + (made_of(rows) if what == "scenes" else "")
    (docs / "fuzzing.md").write_text(re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", lambda _: begin + text + end, page, count=1, flags=re.DOTALL))


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path)
    parser.add_argument("--scenes", action="store_true")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args(words)
    with open(args.rows, newline="") as lines:
        rows = {int(r["seed"]): r for r in csv.DictReader(lines)}       # of a seed that was done twice the last one
    rows = [r for k, r in sorted(rows.items()) if args.seed <= k < args.seed + args.count]
    codes = sorted({r["code"] for r in rows})
    write(rows, " and ".join(codes), f"seeds {rows[0]['seed']} to {rows[-1]['seed']}", what="scenes" if args.scenes else "specs")


if __name__ == "__main__":
    main()
