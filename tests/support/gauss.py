"""The filter tests/runtime/gauss.c: models written by hand around smg_gauss.h."""
import subprocess
from dataclasses import dataclass

from mpmath import mpf
from smidgen.resources import include_flags

from .filters import HERE, WARNINGS
from .strict import CALLS
from .triples import FOUR, ask, on_sphere, vectors

FREE, BODY, VORTICES, TIMED, UNREAL = 0, 1, 2, 3, 5
KAPPA = (1, mpf(-1) / 2, mpf(3) / 4, 2)
COMMANDS = {
    "double": ("gcc", "-std=c11", "-O1"), "quad": ("gcc", "-std=c11", "-O0", "-DSMG_QUAD"),
    "long double": ("gcc", "-std=c11", "-O1", "-DSMG_LONG_DOUBLE"),
    "clang": ("clang", "-std=c11", "-O2"), "g++": ("g++", "-x", "c++", "-std=c++17", "-O1"),
    "clang++": ("clang++", "-x", "c++", "-std=c++17", "-O1"), "g++ quad": ("g++", "-x", "c++", "-std=c++17", "-DSMG_QUAD"),
    "to 1e-6": ("gcc", "-std=c11", "-O0", "-DSMG_TOLERANCE=1e-6"), "to 1e-11": ("gcc", "-std=c11", "-O0", "-DSMG_TOLERANCE=1e-11"),
    "sanitized": ("gcc", "-std=c11", "-O0", CALLS, "-fsanitize=address,undefined", "-fno-sanitize-recover=all")}


def compile_gauss(to, stages, field, build):
    """The filter, and the word that says which field; those that do not depend on time share one program."""
    timed = int(field == TIMED)
    words = [*COMMANDS[build], *WARNINGS, f"-DSMG_STAGES={stages}", f"-DTIMED={timed}", *include_flags(), f"-I{HERE / 'runtime'}"]
    program = to / f"gauss-{stages}-{timed}-{build.replace(' ', '-')}"
    if not program.exists():
        subprocess.run([*words, str(HERE / "runtime" / "gauss.c"), "-o", str(program), "-lquadmath", "-lm"], check=True)
    return program, field


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


def run(program, w, h, steps=1, t0=0.0, back=False):
    """`steps` steps of h from the vectors w."""
    numbers = ask([*program, repr(float(h)), repr(float(t0)), steps, *(["back"] if back else [])], w)
    found = vectors(numbers[4:])
    half = len(found) // 2
    return Run(*(int(x) for x in numbers[:4]), found[:half], found[half:])


STARTS = {
    FREE: [on_sphere((0.3, 0.7, -0.6))],
    BODY: [on_sphere((0.3, 0.7, -0.6))],
    VORTICES: [on_sphere(v, 2) for v in FOUR],
    TIMED: [on_sphere((0.1, -0.4, -1), 0.5), [mpf(1) / 3, mpf(1), mpf(-1) / 2], [mpf(0.25), mpf(-0.5), mpf(0.75)]],
    UNREAL: [on_sphere((0.3, 0.7, -0.6))]}
