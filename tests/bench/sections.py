"""Poincare sections of the forced rigid body, in numbers: writes docs/sections.csv and .md.

    python tests/bench/sections.py              # minutes: measures, then writes both
    python tests/bench/sections.py shift        # one of its tables again
    python tests/bench/sections.py --page       # writes the page from the table that is there
"""
import argparse
import csv
import math
import sys
import time
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from string import Template

import numpy as np

import smidgen
from smidgen.show.demo.paths import spiral
from smidgen.analyse.sections import (CHAOTIC, REGULAR, UNDECIDED, census, fit_curve,
                              flow_stroboscope, indicators, judge_digits, judge_exponent,
                              stroboscope)
from smidgen.check.witness import Witness

HERE = Path(__file__).resolve().parent
DOCS = HERE.parent.parent / "docs"
TABLE, PAGE, PROSE = DOCS / "sections.csv", DOCS / "sections.md", HERE / "sections.md.in"
FORCED = HERE.parent.parent / "specs" / "forced_rigid_body.toml"
IRREVERSIBLE = HERE / "forced_irreversible.toml"

PERIOD = 2 * math.pi
SPHERICAL, CLASSICAL = "spherical-midpoint", "classical-midpoint"
WEAK, STRONG = 0.01, 0.07               # the two strengths of the loading
CURVE_PERIODS = 2000                    # points of a curve
MANY, LONG = 1000, 4000                 # starts and periods, generated code alone
FAR = 40000                             # periods for starts that LONG leaves undecided
FEW, SHORT = 200, 1000                  # starts and periods, beside the flow

WORDS = {REGULAR: "regular", UNDECIDED: "undecided", CHAOTIC: "chaotic"}

# Starts of curves at an angle from the first axis to the third: (name, vector).
CURVES = [(f"{a:g}", np.array([math.cos(a), 0, math.sin(a)]))
          for a in (0.1, 0.3, 0.45, 0.6, 1.1207963, 1.2707963, 1.4707963)]
SADDLE = ("saddle", np.array([math.sin(0.02), math.cos(0.02), 0]))


@dataclass
class Row:
    """One measured number."""
    table: str          # thickness, shift or census
    system: str
    eps: float
    source: str
    steps: int          # per period; 0 for the flow
    start: str
    periods: int
    quantity: str
    value: float


# -- what makes a section -----------------------------------------------------------------------

def generated(spec, method=SPHERICAL, steps=20, **values):
    """orbit(w, periods) of the emitted C."""
    return stroboscope(smidgen.build(spec, method=method, parameters=values), PERIOD, steps)


def exact(spec, tol=1e-13, **values):
    """orbit(w, periods) of the witness's flow."""
    return flow_stroboscope(Witness(spec, parameters=values), PERIOD, tol=tol)


def runge_kutta(spec, steps=20, **values):
    """orbit(w, periods) of the classical Runge-Kutta method of order 4, put back on the sphere
    after every step: a method that is neither symplectic nor reversible, for contrast."""
    witness, h = Witness(spec, parameters=values), PERIOD / steps

    def orbit(w, periods):
        points = [np.array(w, float)]
        for _ in range(periods):
            points.append(period(points[-1]))
        return np.array(points)

    def period(w):
        for n in range(steps):
            w = kutta_step(lambda t, y: witness.vector_field(y[None], t)[0], n * h, w, h)
            w = w / np.linalg.norm(w)
        return w
    return orbit


def kutta_step(field, t, w, h):
    """w + h (k1 + 2 k2 + 2 k3 + k4)/6."""
    k1 = field(t, w)
    k2 = field(t + h / 2, w + h / 2 * k1)
    k3 = field(t + h / 2, w + h / 2 * k2)
    k4 = field(t + h, w + h * k3)
    return w + h * (k1 + 2 * k2 + 2 * k3 + k4) / 6


# -- measurements -------------------------------------------------------------------------------

def thickness_rows(spec, eps, source, steps, orbit, starts, periods=CURVE_PERIODS):
    """Thickness and degree of the curve through each start, and the processor seconds of its points."""
    for name, w in starts:
        begin = time.process_time()
        points = orbit(w, periods)
        seconds = time.process_time() - begin
        curve = fit_curve(points)
        found = {"thickness": curve.thickness, "largest": curve.largest, "degree": curve.degree,
                 "seconds": seconds}
        for quantity, value in found.items():
            yield Row("thickness", spec.name, eps, source, steps, name, periods, quantity, value)


def curves_of_forced_body():
    """The thickness table of the forced body."""
    spec = smidgen.load(str(FORCED))
    for source, steps, orbit in (
            (SPHERICAL, 20, generated(spec, eps=WEAK)),
            (CLASSICAL, 20, generated(spec, CLASSICAL, eps=WEAK)),
            ("flow, tol 1e-13", 0, exact(spec, eps=WEAK)),
            ("flow, tol 1e-11", 0, exact(spec, 1e-11, eps=WEAK)),
            ("Runge-Kutta 4", 20, runge_kutta(spec, eps=WEAK))):
        yield from thickness_rows(spec, WEAK, source, steps, orbit, CURVES)
    for source, steps, orbit in ((SPHERICAL, 20, generated(spec, eps=STRONG)),
                                 ("flow, tol 1e-13", 0, exact(spec, eps=STRONG))):
        yield from thickness_rows(spec, STRONG, source, steps, orbit, [*CURVES[:2], SADDLE])


def curves_of_irreversible_body():
    """The thickness table where no reversing symmetry helps the classical midpoint."""
    spec = smidgen.load(str(IRREVERSIBLE))
    for source, steps, orbit in ((SPHERICAL, 20, generated(spec)),
                                 (CLASSICAL, 20, generated(spec, CLASSICAL)),
                                 ("flow, tol 1e-13", 0, exact(spec))):
        yield from thickness_rows(spec, WEAK, source, steps, orbit, CURVES[1:3])


def shifts():
    """rms distance of the spherical midpoint's points from the flow's curve, for falling h."""
    spec = smidgen.load(str(FORCED))
    for name, w in CURVES:
        curve = fit_curve(exact(spec, eps=WEAK)(w, SHORT))
        for steps in (20, 40, 80):
            away = curve.distances(generated(spec, steps=steps, eps=WEAK)(w, SHORT))
            yield Row("shift", spec.name, WEAK, SPHERICAL, steps, name, SHORT, "distance",
                      float(np.sqrt(np.mean(away**2))))


def censuses():
    """Chaotic fractions: generated code on many starts, then beside the flow on fewer."""
    spec = smidgen.load(str(FORCED))
    for eps in (WEAK, STRONG):
        orbit = generated(spec, eps=eps)
        yield from census_rows(spec, eps, SPHERICAL, 20, orbit, MANY, LONG)[0]
        rows, flow = census_rows(spec, eps, "flow, tol 1e-11", 0, exact(spec, 1e-11, eps=eps),
                                 FEW, SHORT)
        yield from rows
        for method, steps in ((SPHERICAL, 20), (SPHERICAL, 40), (CLASSICAL, 20)):
            orbit = generated(spec, method, steps, eps=eps)
            yield from census_rows(spec, eps, method, steps, orbit, FEW, SHORT, flow)[0]


def census_rows(spec, eps, source, steps, orbit, starts, periods, beside=None):
    """(rows, Census) of one source."""
    begin = time.process_time()
    found = census(orbit, spiral(starts), periods)
    values = {"seconds": time.process_time() - begin, "fraction": found.fraction,
              "low": found.interval[0], "high": found.interval[1],
              "chaotic": found.count(CHAOTIC), "undecided": found.count(UNDECIDED),
              "clear": found.clear, "contradictions": found.contradictions}
    if beside is not None:
        values["same"] = int(np.sum(found.verdicts == beside.verdicts))
        values["opposite"] = int(np.sum(abs(found.verdicts - beside.verdicts) == 2))
    return [Row("census", spec.name, eps, source, steps, str(starts), periods, q, v)
            for q, v in values.items()], found


def followed():
    """Starts at eps = 0.07 that LONG periods left undecided, both indicators over FAR periods."""
    spec = smidgen.load(str(FORCED))
    orbit, starts = generated(spec, eps=STRONG), spiral(MANY)
    for k in np.flatnonzero(census(orbit, starts, LONG).verdicts == UNDECIDED):
        for periods in (LONG, FAR):
            points = orbit(starts[k], periods)
            for quantity, value in zip(("exponent", "digits"), indicators(orbit, points)):
                yield Row("followed", spec.name, STRONG, SPHERICAL, 20, str(k), periods,
                          quantity, value)


# -- the table and the page ---------------------------------------------------------------------

PARTS = {"thickness": (curves_of_forced_body, curves_of_irreversible_body), "shift": (shifts,),
         "census": (censuses,), "followed": (followed,)}


def measure(parts):
    """The rows of these tables, with a line on stderr as each comes."""
    for row in (row for part in parts for runs in PARTS[part] for row in runs()):
        print(*astuple(row), file=sys.stderr, flush=True)
        yield row


def written(row: Row) -> list:
    """The row as the table has it: four significant digits."""
    return [*astuple(row)[:-1], f"{row.value:.4g}"]


def write_table(rows):
    """docs/sections.csv."""
    with TABLE.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow([f.name for f in fields(Row)])
        out.writerows(map(written, rows))


def read_table() -> list[Row]:
    """The rows of docs/sections.csv."""
    with TABLE.open(newline="") as file:
        return [Row(**{f.name: f.type(line[f.name]) for f in fields(Row)})
                for line in csv.DictReader(file)]


def page(rows) -> str:
    """The text of docs/sections.md."""
    return Template(PROSE.read_text()).substitute(
        weak=f"{WEAK:g}", strong=f"{STRONG:g}", periods=CURVE_PERIODS, few=FEW, short=SHORT,
        many=MANY, long=LONG, thickness=thickness_table(rows, "forced_rigid_body", WEAK),
        strong_thickness=thickness_table(rows, "forced_rigid_body", STRONG),
        irreversible=thickness_table(rows, "forced_irreversible", WEAK),
        shift=shift_table(rows), census=census_table(rows), followed=followed_table(rows))


def chosen(rows, **asked):
    """The rows whose fields have these values."""
    return [r for r in rows if all(getattr(r, k) == v for k, v in asked.items())]


def in_order(values):
    """The different ones among `values`, first come first."""
    return list(dict.fromkeys(values))


def table(head, body) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def thickness_table(rows, system, eps) -> str:
    """rms thickness: a line for each source, a column for each start."""
    rows = chosen(rows, table="thickness", system=system, eps=eps)
    starts = in_order(r.start for r in rows)
    body = []
    for source in in_order(r.source for r in rows):
        mine = chosen(rows, source=source)
        cells = [f"{r.value:.1e}" for r in chosen(mine, quantity="thickness")]
        seconds = sum(r.value for r in chosen(mine, quantity="seconds")) / len(cells)
        body.append([source, *cells, f"{seconds:.2g}"])
    return table(["source", *starts, "seconds per curve"], body)


def shift_table(rows) -> str:
    """Distance from the flow's curve: a line for each step, a column for each start."""
    rows = chosen(rows, table="shift")
    starts = in_order(r.start for r in rows)
    body = [[f"2\u03c0/{n}", *(f"{r.value:.2e}" for r in chosen(rows, steps=n))]
            for n in in_order(r.steps for r in rows)]
    return table(["h", *starts], body)


def census_table(rows) -> str:
    """Chaotic fractions: a line for each source, strength and size."""
    rows = chosen(rows, table="census")
    runs = in_order((r.eps, r.source, r.steps, r.start, r.periods) for r in rows)
    return table(["\u03b5", "source", "h", "starts", "periods", "chaotic", "undecided",
                  "fraction, 95%", "both decide", "contradict", "same as flow", "seconds"],
                 [census_line(rows, *run) for run in runs])


def followed_table(rows) -> str:
    """Both indicators of the undecided starts, over more and more periods."""
    rows = chosen(rows, table="followed")
    runs = in_order((r.start, r.periods) for r in rows)
    body = []
    for start, periods in runs:
        value, digits = (r.value for r in chosen(rows, start=start, periods=periods))
        body.append([start, str(periods), f"{value:.2g}",
                     WORDS[judge_exponent(value, periods)], f"{digits:.1f}",
                     WORDS[judge_digits(digits, periods)]])
    return table(["start", "T", "\u03bb_T", "verdict", "digits", "verdict"], body)


def census_line(rows, eps, source, steps, start, periods):
    """The cells of one run."""
    found = {r.quantity: r.value for r in chosen(
        rows, eps=eps, source=source, steps=steps, start=start, periods=periods)}
    same = f"{found['same']:.0f}, opposite {found['opposite']:.0f}" if "same" in found else ""
    return [f"{eps:g}", source, f"2\u03c0/{steps}" if steps else "", start, str(periods),
            f"{found['chaotic']:.0f}", f"{found['undecided']:.0f}",
            f"{found['fraction']:.3f} [{found['low']:.3f}, {found['high']:.3f}]",
            f"{found['clear']:.0f}", f"{found['contradictions']:.0f}", same,
            f"{found['seconds']:.0f}"]


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; all by default")
    options.add_argument("--page", action="store_true", help="only write the page again")
    given = options.parse_args()
    if not given.page:
        parts = given.parts or list(PARTS)
        kept = [r for r in read_table() if r.table not in parts] if TABLE.exists() else []
        write_table(kept + list(measure(parts)))
    PAGE.write_text(page(read_table()))


if __name__ == "__main__":
    main()
