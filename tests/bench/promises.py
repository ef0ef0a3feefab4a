"""What each promise costs, in per cent of the time of a run, on four systems: promises.csv in docs/cost/lanes_N, of vectors of N lanes.

    python tests/bench/promises.py                   # two minutes on a quiet machine
    python tests/bench/promises.py --quick --out a.csv

Each promise is given up alone and timed in turn with the run that keeps all: iterations to stagnation, the carry of what sums
lose, the certificate that a solution is on its branch (by a copy of the headers without it), the same bits on every machine.
"""
from __future__ import annotations

import argparse
import csv
import shutil
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import smidgen
from machine import cost_tables
from smidgen.build.binary import FLAGS, SHARED, compile_shared, find_compiler, split_notes, write_files
from smidgen.compile.emit.emit import generate_program
from smidgen.resources import folder
from smidgen.run.step.integrator import Integrator
from smidgen.run.settings import settle

COLUMNS = ("system", "method", "h", "promise", "given_up_by", "ns_step", "without_ns_step", "per_cent", "spread_per_cent")
SYSTEMS = {"free_rigid_body": {}, "irreversible_rigid_body": {}, "point_vortices": {}, "heisenberg_chain": {"n": 100}}
METHODS = ("spherical-midpoint", "gauss-8")
TOLERANCE = 1e-10
SECONDS = 0.004         # of one measurement
ROUNDS = 41
NO_BRANCH = (           # file of the runtime, what decides, what stands there instead
    ("newton/smg_newton.h", "  if (smg_contracts(bound)) return 1;\n", "  return 1;\n"),
    ("lattice/smg_sweep.h", "if (solved && row < 1) return 1;", "if (solved) return 1;"),
    ("lattice/smg_sweep.h", "(smg_row_bound(s) < 1 ||", "(1 ||"),
    ("method/midpoint/smg_sphere_template.h", "return smg_less(smg_of((smg_real)0.4375), det) SMG_AND smg_less(det, smg_of(5));", "return (void)det, 1;"))


def variants(spec, method: str, values: dict, work: Path):
    """(promise, what gives it up, model without it, tolerance) of each that the method makes."""
    yield "all", "", smidgen.build(spec, method=method, parameters=values, native=False), None
    yield "iterations to stagnation", f"--tolerance {TOLERANCE:g}", smidgen.build(spec, method=method, parameters=values, native=False), TOLERANCE
    if "plain-sums" in smidgen.methods.METHODS[method].features:
        yield "compensated sums", "--features plain-sums", smidgen.build(spec, method=method, parameters=values, native=False, features=("plain-sums",)), None
    if smidgen.methods.METHODS[method].of_midpoints:
        yield "branch check", "(not possible)", without_certificate(spec, method, values, work), None
    yield "runs on any processor", "--native", smidgen.build(spec, method=method, parameters=values, native=True), None
    yield "the same bits everywhere", "--fast", smidgen.build(spec, method=method, parameters=values, fast=True), None
    yield "the same bits everywhere and iterations to stagnation", f"--fast --tolerance {TOLERANCE:g}", smidgen.build(spec, method=method, parameters=values, fast=True), TOLERANCE


def without_certificate(spec, method: str, values: dict, work: Path) -> Integrator:
    """The same model over headers that take every solution for the right one."""
    model = smidgen.build(spec, method=method, parameters=values, native=False)
    headers, here = work / "runtime", work / f"{model.name}-{method}"
    shutil.copytree(folder("runtime"), headers, dirs_exist_ok=True)
    for name, old, new in NO_BRANCH:
        text = (folder("runtime") / name).read_text()
        if old not in text:
            raise SystemExit(f"promises.py: {name} has changed: '{old.strip()}' is not there")
        for one in (o for o in NO_BRANCH if o[0] == name):
            text = text.replace(one[1], one[2])
        (headers / name).write_text(text)
    here.mkdir()
    files, _ = split_notes(generate_program(model.scene, method, model.solver))
    write_files(files, here)
    include = [f"-I{place}" for place in sorted(headers.iterdir()) if place.is_dir()]
    compile_shared(here, sorted(f for f in files if f.endswith(".c")), find_compiler(), (*FLAGS, *SHARED, *include))
    return Integrator(model.prepared, replace(model.built, binary=here / "model.so"))


def step_of(model, w, h: float, tolerance, steps: int) -> float:
    """Nanoseconds of a step."""
    model.start(w.copy(), h=h, tolerance=tolerance)
    model.advance(50)
    began = time.thread_time()
    model.advance(steps)
    return 1e9 * (time.thread_time() - began) / steps


def measured(name: str, method: str, rounds: int, work: Path) -> list[dict]:
    """Rows of one system and method."""
    spec, values = smidgen.load(name), SYSTEMS[name]
    settings = settle(spec, parameters=values)
    found = list(variants(spec, method, values, work))
    all_of_them = found[0][2].start(settings.start, h=settings.h)
    w, h = np.array(all_of_them.w), settings.h if method == METHODS[0] else 4 * settings.h
    steps = max(10, int(1e9 * SECONDS / step_of(all_of_them, w, h, None, 200)))
    times = np.array([[step_of(model, w, h, tolerance, steps) for _, _, model, tolerance in found] for _ in range(rounds)])
    rows = []
    for k, (promise, way, _, _) in list(enumerate(found))[1:]:
        extra = 100 * (times[:, 0] / times[:, k] - 1)
        low, middle, high = np.percentile(extra, (25, 50, 75))
        rows.append(dict(zip(COLUMNS, (name, method, h, promise, way, *np.median(times[:, [0, k]], axis=0), middle, (high - low) / 2))))
    return rows


def certificate(name: str) -> dict:
    """How long `verify` takes, in steps of the run."""
    spec, values = smidgen.load(name), SYSTEMS[name]
    settings, began = settle(spec, parameters=values), time.perf_counter()
    smidgen.verify(spec, parameters=values, tier="quick")
    spent = time.perf_counter() - began
    model = smidgen.build(spec, parameters=values).start(settings.start, h=settings.h)
    step = step_of(model, np.array(model.w), settings.h, None, 2000)
    return dict(zip(COLUMNS, (name, METHODS[0], settings.h, "certificate", "not asking for it (verify --quick)", step, step, 100 * spent / (1e-9 * step * 1e9), "")))


def words(rows) -> str:
    """The section of a page."""
    systems = list(dict.fromkeys(r["system"] for r in rows))
    parts = ["The tables show by how many per cent each guarantee increases the time of a step, relative to the same run without it, with portable "
             "flags. Half the interquartile range is in brackets; a cost below this number is not significant. Apart from the guarantee, both runs "
             "are the same. Every output records the guarantees that were given up (`tolerance`, `fast`, `flags`).\n"]
    for method in METHODS:
        own = [r for r in rows if r["method"] == method and r["promise"] != "certificate"]
        parts += [f"Time of a step with all guarantees, {method}, in ns: " + ", ".join(f"{s} {next(float(r['ns_step']) for r in own if r['system'] == s):.4g}" for s in systems) + "\n",
                  "| guarantee | given up with | " + " | ".join(systems) + " |", "|---|---|" + "---|" * len(systems)]
        for promise in dict.fromkeys(r["promise"] for r in own):
            cells = {r["system"]: f"{float(r['per_cent']):.0f} ({float(r['spread_per_cent']):.0f})" for r in own if r["promise"] == promise}
            way = next(r["given_up_by"] for r in own if r["promise"] == promise)
            parts.append(f"| {promise} | `{way}` | " + " | ".join(cells.get(s, "-") for s in systems) + " |")
        parts.append("")
    cells = ", ".join(f"{r['system']} {float(r['per_cent']):.2g} %" for r in rows if r["promise"] == "certificate")
    return "\n".join([*parts, f"The certificate (`smidgen verify --quick`) is computed once. Compared with the time of a run of 1e9 steps, it takes: {cells}."])


def main() -> None:
    """Measure, write, tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=cost_tables() / "promises.csv")
    parser.add_argument("--quick", action="store_true", help="one system, few rounds")
    args = parser.parse_args()
    names, rounds = (list(SYSTEMS)[1:2], 5) if args.quick else (list(SYSTEMS), ROUNDS)
    rows = []
    with tempfile.TemporaryDirectory() as work:
        for name in names:
            print(f"-- {name}", file=sys.stderr, flush=True)
            for method in METHODS:
                rows += measured(name, method, rounds, Path(work))
            rows.append(certificate(name))
    args.out.parent.mkdir(parents=True, exist_ok=True)
    with open(args.out, "w", newline="") as out:
        table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)
    print(words([{k: str(v) for k, v in row.items()} for row in rows]))


if __name__ == "__main__":
    main()
