"""Builds and runs bad_steps.c over the models of bad_models.py.

    python -m fuzz.bad_steps [--steps 1000000] [--seed 1] [--sanitize] [--only body,top] [--first CASE]
"""
import argparse
import dataclasses
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import smidgen
from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from smidgen.compile.select import select
from support.strict import CALLS

from .bad_models import MODELS

HERE = Path(__file__).parent
FLAGS = ("-std=c11", "-ffp-contract=off", "-Wall", "-Wextra", "-Wno-unused-function")
SANITIZE = ("-O1", "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
KINDS = {"sphere": "ON_SPHERE", "r3": "ON_R3", "nambu": "ON_NAMBU"}
METHODS = {"spherical-midpoint": "SPHERICAL", "classical-midpoint": "CLASSICAL", "moser-veselov": "VESELOV"}

GLUE = """#include "{name}.h"

#define NAME "{name}"
#define METHOD {method}
#define ORIENTATION {orientation}
#define CLOSED {closed}
#define CASIMIR {{{casimir}}}
#define ARRAY_ROOM {room}
typedef {name}_params P;
typedef {name}_model model;
typedef {name}_state S;
#define model_make {name}_model_init
#define model_defaults {name}_defaults
#define model_sites {name}_sites
#define model_memsize {name}_memsize
#define model_init {name}_init
#define model_step {name}_step
#define model_field {name}_field
#define model_savesize {name}_savesize
#define model_save {name}_save

static void draw_parameters(dice *d, P *p, double *room) {{
  {name}_defaults(p);
  (void)d, (void)room;
  {draws}
}}

static void print_parameters(const P *p) {{
  (void)p;
  {prints}
}}

/* Kind and squared radius of every site; 0 when the model counts other sites. */
static int sites_of(const P *p, int64_t sites, equation *e) {{
  int64_t site = 0;
  (void)p, e->strongest = 0;
  {sites}
  e->sites = site;
  return site == sites;
}}
"""


@dataclass
class Result:
    """What one run said: the numbers of its summary, its violations, and its exit status."""
    name: str
    violations: list
    numbers: dict
    status: int
    said: str


def load(model, where):
    """The Spec of a model; the files that it names are written beside it."""
    for name, text in model.files.items():
        (where / name).write_text(text)
    (where / "model.toml").write_text(model.spec)
    return smidgen.load(where / "model.toml")


def draws(spec):
    """C lines that replace the parameters, and the room for arrays."""
    lines, room = [], 0
    for p in (p for p in spec.parameters if not p.fixed):
        if p.kind == "array":
            size = len(p.default)
            lines.append(f"for (int k = 0; k < {size}; k++) room[{room} + k] = draw_real(d, p->{p.name}[k]);")
            lines.append(f"p->{p.name} = room + {room};")
            room += size
        else:
            lines.append(f"p->{p.name} = draw_{'integer' if p.kind == 'int' else 'real'}(d, p->{p.name});")
    return "\n  ".join(lines), max(room, 1)


def prints(spec):
    """C lines that print the parameters."""
    lines = []
    for p in (p for p in spec.parameters if not p.fixed):
        if p.kind == "array":
            lines.append(f'for (int k = 0; k < {len(p.default)}; k++) printf(" {p.name}[%d]=%a", k, p->{p.name}[k]);')
        else:
            lines.append(f'printf(" {p.name}=%{"lld" if p.kind == "int" else "a"}", '
                         f'{"(long long)" * (p.kind == "int")}p->{p.name});')
    return "\n  ".join(lines)


def site_lines(model):
    line = ("for (int64_t i = 0; i < {0}; i++, site++) e->kind[site] = {1}, "
            "e->level[site] = (real)({3}) * (real)({3}), e->strongest = fmaxl(e->strongest, fabsl(e->h / (real)({2})));")
    return "\n  ".join(line.format(count, KINDS[kind], kappa, radius)
                       for count, kind, kappa, radius in model.families)


def glue(model, spec):
    """The text of glue.h."""
    text, room = draws(spec)
    return GLUE.format(
        name=spec.name, method=METHODS[model.method], orientation=model.orientation, closed=int(model.closed), draws=text, room=room, prints=prints(spec),
        casimir=", ".join(map(str, model.casimir)), sites=site_lines(model))


REFERENCE = """#include "exact.h"

void reference_field(const void *p, long double t, const long double *w, long double *b);
void reference_field(const void *p, long double t, const long double *w, long double *b) {
  exact_model model;
  if (exact_model_init(&model, (const exact_params *)p) == SMG_OK) exact_field(&model, t, w, b);
}
"""


def build(name, where, sanitize=False, change=None, level="-O2", models=MODELS, program="bad_steps"):
    """The program of a model in `where`, optimised to `level`. `change`: a function of the generated C, to try faults."""
    model = models[name]
    spec = select(load(model, where))
    files = generate(spec, method=model.method, solver=model.solver)
    exact = generate(dataclasses.replace(spec, name="exact"), method=model.method, solver=model.solver)
    if change:
        files[f"{name}.c"] = change(files[f"{name}.c"])
    write_files(files | {k: exact[k] for k in ("exact.c", "exact.h")}, where)
    (where / "glue.h").write_text(glue(model, spec))
    (where / "reference.c").write_text(REFERENCE)
    return compiled(name, where, SANITIZE if sanitize else (level, CALLS) if level == "-O0" else (level,), program)


def compiled(name, where, flags, program="bad_steps"):
    words = ["gcc", *FLAGS, *flags, "-I.", f"-I{HERE}", *include_flags()]
    for source in ("exact.c", "reference.c"):
        subprocess.run([*words, "-DSMG_LONG_DOUBLE", "-c", source], cwd=where, check=True)
    subprocess.run([*words, str(HERE / f"{program}.c"), f"{name}.c", "exact.o", "reference.o", "-o", str(where / program),
                    "-lm"], cwd=where, check=True)
    return where / program


def run(name, program, seed, first, cases, branches=4):
    """Cases first .. first + cases - 1 of a model, as a Result."""
    done = subprocess.run([program, *map(str, (seed, first, cases, branches))], capture_output=True, text=True)
    lines = done.stdout.splitlines()
    found = re.findall(r"(\w+) (-?[\d.]+|-?nan|inf)(?= |$)", lines[-1]) if lines and lines[-1].startswith("SUMMARY") else []
    numbers = {key: float(value) for key, value in found}
    if lines:
        numbers["statuses"] = lines[-1].partition("status ")[2]
    return Result(name, [x for x in lines if x.startswith("VIOLATION")], numbers, done.returncode, done.stdout + done.stderr)


def shares(steps, names):
    """How many cases each model gets: about two steps a case."""
    total = sum(MODELS[name].share for name in names)
    return {name: max(1, round(steps * MODELS[name].share / total / 2)) for name in names}


def report(result, shown=8):
    n = result.numbers
    print(f"{result.name:20} steps {n.get('steps', 0):9.0f}  violations {len(result.violations):6}  residual "
          f"{n.get('residual', 0):9.2f}  norm {n.get('norm', 0):9.2f}  ill {n.get('ill', 0):5.0f}  followed "
          f"{n.get('followed', 0):7.0f}  undecided {n.get('undecided', 0):4.0f}  slowest {n.get('slowest', 0):.4f} s  statuses {n.get('statuses', '')}", flush=True)
    for line in result.violations[:shown]:
        print("   ", line)
    if result.status not in (0, 1) or not n:
        print("    exit", result.status, result.said[-1500:])


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--cases", type=int)
    parser.add_argument("--branches", type=int, default=4, help="one of so many branches is followed")
    parser.add_argument("--sanitize", action="store_true")
    parser.add_argument("--only", default=",".join(MODELS))
    args = parser.parse_args(words)
    names, bad = args.only.split(","), 0
    for name, cases in shares(args.steps, names).items():
        with tempfile.TemporaryDirectory() as where:
            result = run(name, build(name, Path(where), args.sanitize), args.seed, args.first,
                         args.cases or cases, args.branches)
        report(result)
        if args.cases == 1:
            print(result.said)
        bad += result.status != 0
    return bad != 0


if __name__ == "__main__":
    sys.exit(main())
