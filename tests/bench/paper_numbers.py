"""The numbers that generated code must show: writes docs/numbers.csv and docs/numbers.md.

    python tests/bench/paper_numbers.py              # minutes: measures, then writes both
    python tests/bench/paper_numbers.py --page       # writes the page from the table that is there
"""
import argparse
import csv
import sys
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from string import Template

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from support import constants      # noqa: E402
from support.bodies import STEPS, TENSORS, band, drift, largest_error, ratios_over_starts, start_length      # noqa: E402
from support.measure import casimirs, defect, energy, hundred_steps, scatter, start_points      # noqa: E402
from support.systems import (CLASSICAL, FREE_BODIES, SHORT, SPECS, SPHERICAL, VESELOV, begin,   # noqa: E402
                             model)
from support.texts import FIELD, read       # noqa: E402

DOCS = HERE.parent.parent / "docs"
TABLE, PAGE, PROSE = DOCS / "numbers.csv", DOCS / "numbers.md", HERE / "numbers.md.in"
METHODS = (SPHERICAL, CLASSICAL, VESELOV)
TIMES = (1000, 2000, 5000, 20000)
ANGLES = np.linspace(0.02, np.pi / 2 - 0.02, 60)
COUNTS = (100_000, 1_000_000, 10_000_000)
RANDOM_STARTS = 100
SCATTERED = {"free_rigid_body": 16, "nambu_a39": 1, "two_bodies": 1}

TRACER_PARTS = {"vortices": range(3), "tracers": range(3, 23)}
WHY = {"nambu_a31": "C = w_x², and w_x is constant: C(m̄) = C(w), m = m̄, one map",
       "spin_in_field": "linear field: CM is W = R w, R the Cayley matrix of h B, a rotation; "
                        "not the map of SM, but symplectic as well"}


@dataclass
class Row:
    """One measured number."""
    table: str          # error, starts, energy, constants, agreement, defect or round-off
    system: str
    method: str
    at: str             # step, time or number of steps
    quantity: str
    value: float


# -- measurements -------------------------------------------------------------------------------

def error_rows():
    """Largest error of the free body on [0, 10]."""
    for tensor, moments in TENSORS.items():
        for method in METHODS:
            for k, h in enumerate(STEPS, 1):
                yield Row("error", tensor, SHORT[method], f"2^-{k}", "error", largest_error(moments, method, h))


def start_rows():
    """How far the ratio CM/SM depends on the start (cos a, 0, sin a)."""
    for tensor, moments in TENSORS.items():
        found = ratios_over_starts(moments, ANGLES)
        yield Row("starts", tensor, "CM/SM", "2^-5", "smallest", min(found))
        yield Row("starts", tensor, "CM/SM", "2^-5", "largest", max(found))


def energy_rows():
    """Energy error of the irreversible body, and the length of its start as printed."""
    for t, value in zip(TIMES, drift(TIMES)):
        yield Row("energy", "irreversible_rigid_body", "CM", str(t), "error", value)
    for t in TIMES:
        for side, value in zip(("smallest", "largest"), band(t)):
            yield Row("energy", "irreversible_rigid_body", "SM", str(t), side, value)
    yield Row("energy", "irreversible_rigid_body", "", "0", "length", start_length()[0])


def constant_rows():
    """Errors of methods of order 2 over ten Hamiltonians, and from how many random starts that of RATTLE is the larger one."""
    for name in constants.HAMILTONIANS:
        for method, value in {**constants.errors(name), "RATTLE, c = 1": constants.with_c_1(name)}.items():
            yield Row("constants", name, method, "2^-5", "error", value)
        for quantity, value in zip(("larger", "starts"), constants.larger_for_rattle(name, RANDOM_STARTS)):
            yield Row("constants", name, "RATTLE/SM", "2^-5", quantity, value)


def methods_of(name):
    """The methods of a system; Moser-Veselov belongs to the free body."""
    return METHODS if name in FREE_BODIES else METHODS[:2]


def agreement_rows():
    """Hundred steps beside the witness."""
    for name in SPECS:
        for method in methods_of(name):
            for quantity, value in zip(("apart", "allowed", "growth"), hundred_steps(begin(name), method)):
                yield Row("agreement", name, SHORT[method], "100", quantity, value)


def defect_rows():
    """Poisson defect of one step: parts of the system with tracers apart."""
    cases = [(name, begin(name)) for name in SPECS if name != "vortex_tracers"]
    cases.append(("spin_in_field", begin(read(FIELD))))
    for name, case in cases:
        for method in methods_of(name):
            yield Row("defect", name, SHORT[method], f"{case.h:.4g}", "defect", defect(case, method))
    case = begin("vortex_tracers")
    for part, sites in TRACER_PARTS.items():
        for method in METHODS[:2]:
            yield Row("defect", f"vortex_tracers, {part}", SHORT[method], f"{case.h:.4g}", "defect",
                      defect(case, method, np.array(sites)))


def round_off_rows():
    """Random walk of conserved numbers, root mean square over orbits and sites."""
    for name, orbits in SCATTERED.items():
        case = begin(name)
        starts = start_points(orbits) if orbits > 1 else [case.w]
        quantities = (energy, casimirs) if orbits > 1 else (casimirs,)
        for quantity in quantities:
            found = scatter(model(case), starts, 0.1 if orbits > 1 else case.h, COUNTS, quantity)
            for count, value in zip(COUNTS, found):
                yield Row("round-off", name, "SM", f"{count:.0e}", quantity.__name__, value)


def measure():
    """All rows, with a line on stderr as each comes."""
    for part in (error_rows, start_rows, energy_rows, constant_rows, agreement_rows, defect_rows, round_off_rows):
        for row in part():
            print(*astuple(row), file=sys.stderr, flush=True)
            yield row


# -- the table and the page ---------------------------------------------------------------------

def write_table(rows):
    """docs/numbers.csv, eight significant digits."""
    with TABLE.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow([f.name for f in fields(Row)])
        out.writerows([*astuple(row)[:-1], f"{row.value:.8g}"] for row in rows)


def read_table() -> list[Row]:
    """The rows of docs/numbers.csv."""
    with TABLE.open(newline="") as file:
        return [Row(**{**line, "value": float(line["value"])}) for line in csv.DictReader(file)]


def markdown(head, lines) -> str:
    """A table in Markdown."""
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in [head, ["---"] * len(head), *lines])


class Table:
    """Values of rows by (system, method, at, quantity)."""

    def __init__(self, rows, name):
        self.rows = [r for r in rows if r.table == name]
        self.values = {(r.system, r.method, r.at, r.quantity): r.value for r in self.rows}

    def systems(self):
        return list(dict.fromkeys(r.system for r in self.rows))

    def at(self, system):
        return list(dict.fromkeys(r.at for r in self.rows if r.system == system))

    def __call__(self, *key):
        return self.values.get(key)


def error_table(rows):
    t = Table(rows, "error")
    head = ["h", *(f"{m}, I = {tensor}" for tensor in TENSORS for m in ("SM", "CM", "DMV"))]
    lines = [[at, *(f"{t(tensor, m, at, 'error'):.5e}" for tensor in TENSORS for m in ("SM", "CM", "DMV"))]
             for at in t.at(next(iter(TENSORS)))]
    ratios = [[f"I = {tensor}", *(f"{t(tensor, m, '2^-9', 'error') / t(tensor, 'SM', '2^-9', 'error'):.2f}"
                                  for m in ("DMV", "CM"))] for tensor in TENSORS]
    return markdown(head, lines), markdown(["at h = 2^-9", "DMV / SM", "CM / SM"], ratios)


def start_text(rows):
    t = Table(rows, "starts")
    return "; ".join(f"from {t(tensor, 'CM/SM', '2^-5', 'smallest'):.2g} to "
                     f"{t(tensor, 'CM/SM', '2^-5', 'largest'):.3g} for I = {tensor}" for tensor in TENSORS)


def energy_table(rows):
    t, name = Table(rows, "energy"), "irreversible_rigid_body"
    return markdown(["t", "CM, H(t) − H(0)", "SM, smallest and largest on [0, t]"],
                    [[at, f"{t(name, 'CM', at, 'error'):+.4e}",
                      f"{t(name, 'SM', at, 'smallest'):+.4e}, {t(name, 'SM', at, 'largest'):+.4e}"]
                     for at in map(str, TIMES)])


def constant_table(rows):
    t = Table(rows, "constants")
    methods, lines = ("SM", "RATTLE", "RATTLE, c = 1", "isospectral", "exponential"), []
    for name in t.systems():
        found = [t(name, m, "2^-5", "error") for m in methods]
        larger, starts = (t(name, "RATTLE/SM", "2^-5", q) for q in ("larger", "starts"))
        lines.append([name, *(f"{error:.3e}" for error in found), f"{found[1] / found[0]:.2f}", f"{larger:.0f} of {starts:.0f}"])
    return markdown(["H", "SM", "RATTLE, c = 1/4", *methods[2:], "RATTLE / SM", "RATTLE larger"], lines)


def agreement_table(rows):
    t = Table(rows, "agreement")
    return markdown(["system", "method", "difference", "bound", "growth of the tangent map"],
                    [[name, m, *(f"{t(name, m, '100', q):.1e}" for q in ("apart", "allowed")),
                      f"{t(name, m, '100', 'growth'):.3g}"]
                     for name in t.systems() for m in SHORT.values() if t(name, m, "100", "apart") is not None])


def defect_table(rows):
    t, lines = Table(rows, "defect"), []
    for name in t.systems():
        at = t.at(name)[0]
        found = {m: t(name, m, at, "defect") for m in SHORT.values()}
        notes = [WHY.get(name, ""), f"DMV {found['DMV']:.0e}" if found["DMV"] is not None else ""]
        lines.append([name, at, f"{found['SM']:.1e}", f"{found['CM']:.1e}", "; ".join(n for n in notes if n)])
    return markdown(["system", "h", "SM", "CM", ""], lines)


def round_off_table(rows):
    t = Table(rows, "round-off")
    return markdown(["system", "quantity", *(f"{c:.0e} steps" for c in COUNTS)],
                    [[name, q, *(f"{t(name, 'SM', f'{c:.0e}', q):.1e}" for c in COUNTS)]
                     for name in t.systems() for q in ("energy", "casimirs")
                     if t(name, "SM", f"{COUNTS[0]:.0e}", q) is not None])


def page(rows) -> str:
    """The text of docs/numbers.md."""
    errors, ratios = error_table(rows)
    return Template(PROSE.read_text()).substitute(
        errors=errors, ratios=ratios, starts=start_text(rows), energies=energy_table(rows), constants=constant_table(rows), agreement=agreement_table(rows),
        defects=defect_table(rows), round_off=round_off_table(rows),
        length=f"{Table(rows, 'energy')('irreversible_rigid_body', '', '0', 'length'):.8f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--page", action="store_true", help="only write the page from the table")
    if not parser.parse_args().page:
        write_table(list(measure()))
    PAGE.write_text(page(read_table()))


if __name__ == "__main__":
    main()
