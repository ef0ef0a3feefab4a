"""A cost table: rows, the reference they are measured against, the file, and the words."""
from __future__ import annotations

import csv
import io
import math
import os
import platform
from dataclasses import dataclass, fields
from pathlib import Path

from ..errors import UsageError
from ..methods import METHODS
from ..public import public
from ..read.names import plural
from ..tables import text_of
from .frontier import TARGETS, first, frontier, keeps_energy, symplectic
from .peers import PEERS
from .measure.sweep import COLUMNS, Row

HEAD = "# "


class CostTable:
    """What was measured, kept as a CSV. A subclass has `facts`, a dict, `header`, the names of the columns, and `lines()`, the cells of each row."""

    def save(self, path: str | os.PathLike) -> Path:
        """The CSV: facts as comments, then a line for each row."""
        path = Path(path)
        path.write_text(self.text(), encoding="utf-8")
        return path

    def text(self) -> str:
        """The CSV as text."""
        out = io.StringIO()
        out.writelines(f"{HEAD}{key} = {value}\n" for key, value in self.facts.items())
        csv.writer(out, lineterminator="\n").writerows((self.header, *self.lines()))
        return out.getvalue()


@dataclass(frozen=True)
class Cost(CostTable):
    """A table of what accuracy costs.

    :ivar rows: one `sweep.Row` for each method and step.
    :ivar long: tuples (method, h, t, energy error) along long runs.
    :ivar facts: spec, run, duration, sites, machine, date, compiler, vector width; the methods and the error of the reference solution;
        the methods that do not apply, with reasons.
    """
    rows: list
    long: list
    facts: dict

    header = ("kind", *COLUMNS, "t")

    def lines(self):
        """The table as lines of text, which `load_cost` reads."""
        for row in self.rows:
            yield "peer" if row.method in PEERS else "sweep", *(repr(row.h) if name == "h" else shown(getattr(row, name)) for name in COLUMNS), ""
        for method, h, t, error in self.long:
            yield "long", *(shown({"method": method, "h": h, "energy": error}.get(name, math.nan)) for name in COLUMNS), shown(t)

    def __str__(self) -> str:
        return words(self)

    def __repr__(self) -> str:
        f, methods = self.facts, {row.method for row in self.rows}
        return (f"<Cost {f.get('spec', '')} {f.get('run', '')}: {len(self.rows)} rows of {len(methods)} methods, time {f.get('time', '?')}; "
                "print() shows the table>")


def shown(value) -> str:
    """A cell: measured numbers to five digits, nothing for nan."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.5g}"
    return str(value)


@public
def load_cost(path: str | os.PathLike) -> Cost:
    """Read a table that `Cost.save` wrote.

    :raises UsageError: if it is not such a file.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as problem:
        raise UsageError(f"{path} cannot be read: {problem}") from None
    facts = dict(line[len(HEAD):].split(" = ", 1) for line in text.splitlines() if line.startswith(HEAD) and " = " in line)
    table = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    if not table or not {"kind", *COLUMNS} <= set(table[0]):
        raise UsageError(f"{path} is not a cost table; write one with `smidgen cost SPEC --out {path}`")
    rows = [row_of(line) for line in table if line["kind"] in ("sweep", "peer")]
    long = [(line["method"], number(line["h"]), number(line["t"]), number(line["energy"])) for line in table if line["kind"] == "long"]
    return Cost(rows, long, facts)


def row_of(line: dict) -> Row:
    """A row of the file."""
    kinds = {f.name: f.type for f in fields(Row)}
    return Row(**{name: line[name] if kinds[name] == "str" else int(line[name]) if kinds[name] == "int" else number(line[name])
                  for name in COLUMNS})


def number(text: str) -> float:
    """A cell as a number, nan for none."""
    try:
        return float(text) if text else math.nan
    except ValueError:
        raise UsageError(f"'{text}' is not a number in a cost table") from None


def machine() -> str:
    """The processor, as the system names it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine() or "unknown"


def words(cost: Cost) -> str:
    """The table, and what a reader should take away."""
    f = cost.facts
    head = f"{f['spec']} {f['run']}".strip() + f": time {f['time']}, {plural(int(f['sites']), 'site')}; {measured_on(f)}"
    if cost_is_chaotic(cost):
        return "\n".join([head, f"no errors of the final state: {f['reference']}", text_of(invariants(cost)).rstrip()])
    return "\n".join([head, f"errors against {f['reference']}", text_of(times(cost)).rstrip(), *sentences(cost)])


def measured_on(facts: dict) -> str:
    """Machine, width of the vectors and date; older tables name the machine alone."""
    lanes = f"vectors of {facts['lanes']} lanes" if "lanes" in facts else ""
    return ", ".join(part for part in (facts["machine"], lanes, facts.get("date", "")) if part)


def cost_is_chaotic(cost: Cost) -> bool:
    """Are there no end errors?"""
    return all(row.end_error != row.end_error for row in cost.rows)


def table_of(*headers):
    """An empty table."""
    from rich.table import Table
    table = Table(box=None, pad_edge=False)
    for k, header in enumerate(headers):
        table.add_column(header, justify="left" if k == 0 else "right")
    return table


def times(cost: Cost):
    """Time of each method for each end error."""
    table = table_of("time to a final error of", *(f"{t:.0e}" for t in TARGETS), "symplectic")
    found = frontier(cost.rows)
    for name, own in sorted(found.items(), key=lambda item: -METHODS[item[0]].order if item[0] in METHODS else 0):
        table.add_row(label(name), *(duration(x) for x in own), "" if name in PEERS else "yes" if symplectic(name) else "no")
    return table


def invariants(cost: Cost):
    """Of each method the row with the largest step that got to the end, and its energy error: where ends tell nothing."""
    table = table_of("method", "h", "ns a step", "energy error", "drift of the energy")
    for row in cost.rows:
        if not row.status:
            table.add_row(label(row.method), f"{row.h:.4g}", f"{row.ns_step:.4g}", f"{row.energy:.2e}", f"{row.drift:.1e} ± {row.drift_error:.1e}")
    return table


def sentences(cost: Cost) -> list[str]:
    """Who is first, for each kind of promise."""
    exact = keeps_energy(cost.rows, float(cost.facts["energy"]))
    iterated = [r for r in cost.rows if r.tolerance != r.tolerance]
    kinds = (("symplectic", symplectic, cost.rows), ("energy to round-off", lambda name: name in exact, iterated),
             ("any", lambda name: name in METHODS, cost.rows), ("of the general integrators", lambda name: name in PEERS, cost.rows))
    said = []
    for kind, only, rows in kinds:
        best = [(t, *first(rows, "end_error", t, only)) for t in TARGETS]
        parts = [f"{t:.0e} {label(name)} {duration(x)}" for t, name, x in best if name]
        said.append(f"fastest, {kind}: " + ("; ".join(parts) if parts else "none reaches it"))
    there = any(row.method in PEERS for row in cost.rows)
    return (said if there else said[:-1]) + [f"not measured: {word.removeprefix('missing ')} requires {needs}" for word, needs in cost.facts.items()
                                              if word.startswith("missing ")]


def label(name: str) -> str:
    """A method as legends have it."""
    return METHODS[name].label if name in METHODS else PEERS[name].label if name in PEERS else name


def duration(seconds: float) -> str:
    """With its unit."""
    if seconds != seconds:
        return "-"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"
