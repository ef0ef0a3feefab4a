"""The tables of the study: rows, and the files that keep them."""
import csv
from dataclasses import asdict, astuple, dataclass, fields
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Growth:
    """Root mean square and mean of a change over `orbits` orbits (or spins) after `steps` steps."""
    table: str
    quantity: str
    variant: str
    orbits: int
    steps: int
    rms: float
    mean: float
    machine: str

    @property
    def key(self):
        return self.table, self.quantity, self.variant, self.steps


@dataclass(frozen=True)
class Cost:
    """Nanoseconds a step (in lanes: a step and trajectory), over repeats in turns."""
    table: str
    variant: str
    repeats: int
    least: float
    median: float
    greatest: float
    machine: str

    @property
    def key(self):
        return self.table, self.variant


def read_rows(path: Path, kind) -> list:
    """The rows of a file, none if it does not exist."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return [kind(**{f.name: f.type(line[f.name]) for f in fields(kind)}) for line in csv.DictReader(file)]


def keep_row(path: Path, row):
    """The row into its file, in the place of the one with the same key."""
    rows = [r for r in read_rows(path, type(row)) if r.key != row.key] + [row]
    with path.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(asdict(row))
        out.writerows(map(astuple, sorted(rows, key=lambda r: r.key)))


def exponent(rows) -> float:
    """The slope of log rms over log steps, by least squares."""
    return float(np.polyfit(np.log([r.steps for r in rows]), np.log([r.rms for r in rows]), 1)[0])


def small(rows, constant=1e-18) -> bool:
    """rms <= constant sqrt(steps) in every row."""
    return all(r.rms <= constant * r.steps**0.5 for r in rows)
