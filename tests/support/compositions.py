"""Generated models in double, long double and quadruple precision, with other coefficients where asked for: tests/runtime/composed.c."""
import subprocess
import sys
from dataclasses import dataclass

import smidgen
from mpmath import mpf
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags

from .filters import HERE
from .strict import CALLS
from .triples import FOUR, ask, on_sphere, vectors

sys.path.insert(0, str(HERE / "coefficients"))
import compositions as coefficients  # noqa: E402

BUILDS = {"double": (), "long double": ("-DSMG_LONG_DOUBLE",), "quad": ("-DSMG_QUAD",)}
HOST = ("spherical-midpoint-6", "smg_ss11.h", 11)     # whose coefficients give way to others, of no more stages


@dataclass
class Run:
    status: int
    count: int
    iterations: int
    w: list


def compile_model(to, spec, method, build="quad", half=None):
    """The filter of a model; half: coefficients before the middle one, in place of those of HOST."""
    to.mkdir(parents=True, exist_ok=True)
    program = to / "composed"
    files = generate(spec, method=method, solver="newton")     # compositions have no other for few sites
    for name, text in files.items():
        if half is not None:
            text = text.replace(f"#define SMG_COMPOSED {HOST[2]}", f"#define SMG_COMPOSED {2 * len(half) + 1}")
        (to / name).write_text(text)
    if half is not None:
        (to / HOST[1]).write_text(coefficients.header_of("trial", 2, "of a test", [mpf(x) for x in half], "ss11"))
    words = ["gcc", "-std=c11", "-O0", CALLS, "-ffp-contract=off", *BUILDS[build], "-I.", *include_flags(), f"-I{HERE / 'runtime'}", f"-DMODEL={spec.name}",
             f'-DHEADER="{spec.name}.h"', f"{spec.name}.c", str(HERE / "runtime" / "composed.c"), "-o", str(program), "-lquadmath", "-lm"]
    subprocess.run(words, cwd=to, check=True)
    return program


def run(program, w, h, steps, t0=0.0) -> Run:
    numbers = ask([program, repr(float(h)), repr(float(t0)), steps], w)
    return Run(*(int(x) for x in numbers[:3]), vectors(numbers[3:]))


BODY = """
[model]
name = "{name}"
[space]
w = {{ sphere = 1 }}
[effects.body]
over = "site(i)"
energy = "{energy}"
[starts.a]
vectors = [[0.6, 0.0, 0.8]]
[runs.r]
start = "a"
h = 0.1
steps = 10
"""
FREE = "w[i].x^2/2 + w[i].y^2/4 + w[i].z^2/8"


def body(name, energy):
    return smidgen.load_text(BODY.format(name=name, energy=energy))


SPECS = {
    "free body": body("free_body", FREE),
    "irreversible body": body("irreversible", FREE + " + (w[i].x^3/6 + w[i].y^3/12 + w[i].z^3/24)*2"),
    "driven body": body("driven", FREE + " + w[i].x^3/3 + (0.4 + 0.3*w[i].y)*w[i].z*sin(1.3*t) + 0.2*w[i].x*cos(t)"),
    "vortices": smidgen.load_text("""
[model]
name = "vortices"
[space]
v = { sphere = 4, kappa = "g[i]" }
[parameters]
g = { default = [6.0, -4.0, 5.0, 8.0], size = 4 }
[effects.pairs]
over = "pair(i, j) of v"
energy = "-g[i]*g[j]*log(2 - 2*dot(v[i], v[j]))/(4*pi)"
[starts.a]
random = 4
[runs.r]
start = "a"
h = 0.1
steps = 10
""")}
STARTS = {**{name: [on_sphere((0.3, 0.7, -0.6))] for name in ("free body", "irreversible body", "driven body")},
          "vortices": [on_sphere(v) for v in FOUR]}
