"""The filter tests/runtime/gauss.c (models written by hand around smg_gauss.h), and numbers that keep their digits on the way."""
import subprocess
from dataclasses import dataclass

import numpy as np
from mpmath import mp, mpf, sqrt
from smidgen.resources import include_flags

from .filters import HERE, WARNINGS

mp.dps = 40
FREE, BODY, VORTICES, TIMED, UNREAL = 0, 1, 2, 3, 5
KAPPA = (1, mpf(-1) / 2, mpf(3) / 4, 2)
COMMANDS = {
    "double": ("gcc", "-std=c11", "-O2"), "quad": ("gcc", "-std=c11", "-O2", "-DSMG_QUAD"),
    "long double": ("gcc", "-std=c11", "-O2", "-DSMG_LONG_DOUBLE"),
    "clang": ("clang", "-std=c11", "-O2"), "g++": ("g++", "-x", "c++", "-std=c++17", "-O1"),
    "clang++": ("clang++", "-x", "c++", "-std=c++17", "-O1"), "g++ quad": ("g++", "-x", "c++", "-std=c++17", "-DSMG_QUAD"),
    "to 1e-6": ("gcc", "-std=c11", "-O2", "-DSMG_TOLERANCE=1e-6"), "to 1e-11": ("gcc", "-std=c11", "-O2", "-DSMG_TOLERANCE=1e-11"),
    "sanitized": ("gcc", "-std=c11", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")}


def compile_gauss(to, stages, field, build):
    words = [*COMMANDS[build], *WARNINGS, f"-DSMG_STAGES={stages}", f"-DSMG_FIELD={field}", *include_flags()]
    program = to / f"gauss-{stages}-{field}-{build.replace(' ', '-')}"
    if not program.exists():
        subprocess.run([*words, str(HERE / "runtime" / "gauss.c"), "-o", str(program), "-lquadmath", "-lm"], check=True)
    return program


@dataclass
class Run:
    """What the filter says: vectors as lists of mpf, w and what w has lost to rounding."""
    status: int
    iterations: int
    site: int
    count: int
    w: list
    carry: list

    @property
    def state(self):
        return [[a + b for a, b in zip(*both)] for both in zip(self.w, self.carry)]


def parts(x):
    """x as three doubles."""
    found = []
    for _ in range(3):
        found.append(float(x))
        x = x - mpf(found[-1])
    return found


def run(program, w, h, steps=1, t0=0.0, back=False):
    """`steps` steps of h from the vectors w."""
    sent = np.array([parts(mpf(x)) for v in w for x in v])
    words = [str(program), repr(float(h)), repr(float(t0)), str(steps), *(["back"] if back else [])]
    done = subprocess.run(words, input=sent.tobytes(), stdout=subprocess.PIPE, check=True)
    numbers = [mpf(a) + mpf(b) + mpf(c) for a, b, c in np.frombuffer(done.stdout).reshape(-1, 3)]
    vectors = [numbers[k:k + 3] for k in range(4, len(numbers), 3)]
    half = len(vectors) // 2
    return Run(*(int(x) for x in numbers[:4]), vectors[:half], vectors[half:])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(a):
    return sqrt(dot(a, a))


def on_sphere(v, radius=1):
    return [mpf(radius) * mpf(x) / norm([mpf(x) for x in v]) for x in v]


def apart(a, b):
    """The largest distance of two states, site by site."""
    return max(norm([x - y for x, y in zip(*both)]) for both in zip(a, b))


STARTS = {
    FREE: [on_sphere((0.3, 0.7, -0.6))],
    BODY: [on_sphere((0.3, 0.7, -0.6))],
    VORTICES: [on_sphere(v, 2) for v in ((1, 0.2, 0.3), (-0.5, 1, 0.1), (-0.4, -1, 0.5), (0.1, 0.3, -1))],
    TIMED: [on_sphere((0.1, -0.4, -1), 0.5), [mpf(1) / 3, mpf(1), mpf(-1) / 2], [mpf(0.25), mpf(-0.5), mpf(0.75)]],
    UNREAL: [on_sphere((0.3, 0.7, -0.6))]}
