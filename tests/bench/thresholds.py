"""What the thresholds of the solvers do: each at half and at twice its value. Writes docs/thresholds.csv and docs/thresholds.md.

    python tests/bench/thresholds.py                 # a quarter of an hour
    python tests/bench/thresholds.py SMG_LATE        # only these
    python tests/bench/thresholds.py --page          # the page from the table
"""
import argparse
import csv
import re
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from string import Template

import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select

HERE = Path(__file__).resolve().parent
RUNTIME, DOCS = HERE.parents[1] / "runtime", HERE.parents[1] / "docs"
HEADERS = ("core/smg_site.h", "core/smg_tolerances.h", "newton/smg_follow.h", "newton/smg_krylov.h", "newton/smg_matrix_free.h", "lattice/smg_row_state.h",
           "lattice/smg_row_follow.h", "lattice/smg_row_settle.h")
FROM_ONE = ("SMG_ALONG", "SMG_LONGER", "SMG_PATH_SMALLER", "SMG_RELAXED", "SMG_RELAXED_RATIO", "SMG_FADING")     # a cosine and ratios, of which the distance from 1 is halved and doubled
SIZES = ("SMG_KRYLOV_BASIS", "SMG_KRYLOV_SHORT", "SMG_ROW_HISTORY", "SMG_ROW_SPARE", "SMG_PATH_POINTS", "SMG_PATH_ARRAYS")     # of arrays: no factor can change them
DEFINE = re.compile(r"^#define (SMG_[A-Z_]+) +(\([^*/]*\)|\S+)( +/\*|$)", re.M)
TRIALS = 24
CUBE = (("nx", 3), ("ny", 3), ("nz", 3))
BODY = '[model]\nname = "tops"\n[space]\nw = { sphere = 2 }\n[effects.e]\nover = "site(i) of w"\nenergy = "(w[i].x^2 + w[i].y^2/2 + w[i].z^2/4)/2"\n'


@dataclass(frozen=True)
class Model:
    """A model that is tried: of a shipped spec, or of a text."""
    spec: str
    method: str = "spherical-midpoint"
    solver: str = "auto"
    values: tuple = ()
    h: tuple = (0.1, 0.5, 1.0, 2.0, 4.0)
    steps: int = 1500

    @property
    def name(self) -> str:
        return " ".join(x for x in ("two bodies apart" if "\n" in self.spec else self.spec, *(self.method,) * (self.method != Model.method),
                                    *(self.solver,) * (self.solver != Model.solver)))


MODELS = (Model("heisenberg_chain", values=(("n", 8),)), Model("heisenberg_chain", solver="newton", values=(("n", 8),)),
          Model("point_vortices", h=(0.1, 0.5, 1.0, 4.0)), Model("product"), Model(BODY), Model("irreversible_rigid_body"),
          Model("free_rigid_body", "classical-midpoint"), Model("irreversible_rigid_body", "classical-midpoint"), Model("free_rigid_body", "moser-veselov"),
          Model("nambu_a31"), Model("nambu_a36"), Model("cubic_lattice", values=CUBE, h=(0.2, 0.5, 1.0), steps=100), Model("cubic_lattice", solver="plain", values=CUBE, h=(0.2, 0.5), steps=100),
          Model("vortex_tracers", values=(("m", 3),), h=(0.1, 1.0, 4.0, 10.0)))


@dataclass(frozen=True)
class Effect:
    """What another value of a threshold did in all models: first steps that are found where they were not, lost, or end elsewhere;
    refusals for another reason; iterations, relative; the largest growth of a drift, and where."""
    threshold: str
    factor: float
    changed: int
    gained: int
    lost: int
    elsewhere: int
    other_status: int
    work: float
    drift: float
    where: str


def thresholds() -> list[tuple[str, str]]:
    """(name, value) of every numeric threshold."""
    found = [m.group(1, 2) for h in HEADERS for m in DEFINE.finditer((RUNTIME / h).read_text())]
    return list({n: v for n, v in found if n not in SIZES and "SMG_EPS" not in v and "DBL_MAX" not in v}.items())


def compiled(model: Model, names, folder: Path) -> Path:
    """The model with thresholds that factors multiply."""
    folder.mkdir()
    if "\n" in model.spec:
        (folder / "given.toml").write_text(model.spec)
    spec = smidgen.load(folder / "given.toml" if "\n" in model.spec else model.spec)
    files = generate(select(spec, None, dict(model.values)), model.method, model.solver, amalgamate=True)
    text = files[f"{spec.name}.c"]
    for i, (name, value) in enumerate(names):
        other = f"(1 + (({value}) - 1) * factor_of[{i}])" if name in FROM_ONE else f"(({value}) * factor_of[{i}])"
        text = re.sub(rf"^#define {name} .*$", lambda _: f"#define {name} ((__typeof__({value})){other})", text, flags=re.M)
    (folder / f"{spec.name}.h").write_text(files[f"{spec.name}.h"])
    (folder / "model.c").write_text(text)
    subprocess.run(["cc", "-std=gnu11", "-O1", "-ffp-contract=off", "-w", "-I", folder, f'-DSOURCE="{folder}/model.c"', f"-DNAME={spec.name}",
                    HERE / "thresholds.c", "-lm", "-o", folder / "run"], check=True)
    return folder / "run"


def tried(program: Path, model: Model, factors) -> list[tuple]:
    """(h, steps, status, done, iterations, first and last component, changes of Casimirs, momentum, energy) of every trial."""
    out = subprocess.run([program, str(TRIALS), str(model.steps), *map(str, model.h)], input=" ".join(map(str, factors)), capture_output=True, text=True, check=True, timeout=300)
    return [tuple(float(x) for x in line.split()) for line in out.stdout.splitlines()]


def compared(before, after) -> Counter:
    """How two lists of trials differ; the drift is that of runs, where it was below 1e5 ulps: a law that the method keeps."""
    seen = Counter()
    for a, b in zip(before, after):
        seen["before"] += a[4]
        seen["after"] += b[4]
        seen["changed"] += a[2:] != b[2:]
        if a[1] > 1:
            for x, y in zip(a[7:], b[7:]):
                if a[2] == b[2] == 0 and x < 1e5:
                    seen["drift"] = max(seen["drift"], (y + 20) / (x + 20))
        elif a[2] != b[2]:
            seen["gained" if b[2] == 0 else "lost" if a[2] == 0 else "other"] += 1
        elif a[2] == 0 and max(abs(a[5] - b[5]), abs(a[6] - b[6])) > 1e-9:
            seen["elsewhere"] += 1
    return seen


def effect(name: str, factor: float, number: int, count: int, programs, reference) -> Effect:
    """One threshold at `factor` times its value."""
    factors = [factor if k == number else 1 for k in range(count)]
    whole, where = Counter(), ""
    for model, program in programs.items():
        try:
            seen = compared(reference[model], tried(program, model, factors))
        except subprocess.SubprocessError as stopped:
            seen, where = Counter(lost=1), f"{model.name}: {type(stopped).__name__}"
        drift = max(whole["drift"], seen["drift"])
        if drift > max(2, whole["drift"]) or not where and seen["lost"] + seen["gained"] + seen["elsewhere"]:
            where = model.name
        whole += seen
        whole["drift"] = drift
    return Effect(name, factor, whole["changed"], whole["gained"], whole["lost"], whole["elsewhere"], whole["other"],
                  round(whole["after"] / max(1, whole["before"]), 4), round(whole["drift"], 2), where)


def measured(only, path: Path):
    """Every threshold at half and twice its value; rows are kept as they come."""
    names = thresholds()
    rows = {(r.threshold, r.factor): r for r in read(path) if r.threshold in dict(names)} if only and path.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        programs = {m: compiled(m, names, Path(folder, str(k))) for k, m in enumerate(MODELS)}
        reference = {m: tried(p, m, [1] * len(names)) for m, p in programs.items()}
        for k, (name, _) in enumerate(names):
            for factor in (0.5, 2.0) if not only or name in only else ():
                rows[name, factor] = effect(name, factor, k, len(names), programs, reference)
                print(*astuple(rows[name, factor]), file=sys.stderr, flush=True)
                keep(path, rows.values())


def keep(path: Path, rows):
    with path.open("w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerows([[x.name for x in fields(Effect)], *map(astuple, rows)])


def read(path: Path) -> list[Effect]:
    with path.open(newline="") as f:
        return [Effect(*(t(x) for t, x in zip((str, float, int, int, int, int, int, float, float, str), row))) for row in list(csv.reader(f))[1:]]


def said(r: Effect) -> str:
    """One row in words."""
    if not r.changed:
        return "nothing changes"
    counts = [f"{n} {word}" for n, word in ((r.lost, "lost"), (r.gained, "gained"), (r.elsewhere, "elsewhere"), (r.other_status, "other refusals")) if n]
    work = [] if abs(r.work - 1) < 0.002 else [f"iterations x {r.work:.3f}"]
    drift = [f"drift x {r.drift:.3g}"] if r.drift > 3 else []
    where = f" ({r.where})" if r.where and (r.lost or r.gained or r.elsewhere or drift) else ""
    return "; ".join([*counts, *work, *drift]) + where if counts or work or drift else "round-off alone"


def page(path: Path) -> str:
    rows, values = {(r.threshold, r.factor): r for r in read(path)}, dict(thresholds())
    lines = [f"| `{n}` | {values[n].replace('(smg_real)', '')} | {said(rows[n, 0.5])} | {said(rows[n, 2.0])} |" for n in values if (n, 2.0) in rows]
    models = ", ".join(m.name for m in MODELS)
    return Template((HERE / "thresholds.md.in").read_text()).substitute(rows="\n".join(lines), models=models, trials=TRIALS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("only", nargs="*", help="names of thresholds; all by default")
    parser.add_argument("--page", action="store_true", help="only write the page")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the table and the page go")
    given = parser.parse_args()
    path = given.docs / "thresholds.csv"
    if not given.page:
        measured(given.only, path)
    (given.docs / "thresholds.md").write_text(page(path))


if __name__ == "__main__":
    main()
