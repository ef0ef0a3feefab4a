"""General integrators written in C: GSL, and CVODE and ARKODE of SUNDIALS, over the generated right-hand side; DOP853 over one by hand.

Each is a small file here that includes the generated model, compiled for this processor with contraction on: nothing that
the language allows is kept from them.
"""
from __future__ import annotations

import ctypes
import os
from pathlib import Path

import numpy as np

from ...build.binary import compiler_version, digest, find_compiler, ran
from ...build.cache import entry
from ...methods import METHODS
from ...resources import include_flags
from ...run.step.integrator import Integrator
from ..measure.case import Case

HERE = Path(__file__).resolve().parent
FLAGS = ("-std=gnu11", "-O3", "-march=native", "-fPIC", "-shared", "-Wl,-z,defs")
LIBRARY = "peer.so"
FIELDS = HERE / "fields"         # written by hand, each for the spec of its name
GSL = ("-lgsl", "-lgslcblas", "-lm")
SUNDIALS = tuple(f"-lsundials_{name}" for name in ("arkode", "cvodes", "sunnonlinsolfixedpoint", "sunnonlinsolnewton", "sunlinsoldense",
                                                   "sunmatrixdense", "nvecserial", "core")) + ("-lm",)
FIRST = 1e-3        # first step, of those that ask for one, in turns of the fastest site
NEEDS = {"gsl.c": "GSL with its headers (Debian: libgsl-dev)",
         "cvode.c": "SUNDIALS 7 or newer with its headers; SUNDIALS_DIR names its folder (the sundials4py wheel contains them)"}
NEEDS["by_hand.c"] = "a hand-written C field for this spec"
NEEDS["arkode.c"] = NEEDS["cvode.c"]


class Missing(Exception):
    """The integrator is not there; says what it needs."""


class Compiled:
    """One of them on one case: `source` and `kind` say which."""

    def __init__(self, case: Case, source: str, kind: int):
        self.case, self.kind = case, kind
        explicit = next(name for name, m in METHODS.items() if m.controlled and case.model(name) is not None)
        m = case.model(explicit)
        self.model = Integrator(m.prepared, m.built)      # one that nobody else starts anew
        self.model.start(case.w.copy(), h=1.0)      # rate.h says why
        self.functions = library(self.model.built, self.model.name, source, self.options())
        self.handles, self.first = {}, FIRST / max(case.rate, 1e-300) * np.sign(case.time)

    def options(self) -> list[str]:
        """More options of the compiler."""
        return []

    def prepare(self, tolerance: float) -> None:
        """Memory for runs to this tolerance. Raises MemoryError."""
        if tolerance not in self.handles:
            found = self.functions.peer_new(self.model._state, self.kind, tolerance, self.first)
            if not found:
                raise MemoryError("the integrator cannot be set up")
            self.handles[tolerance] = found

    def states(self, tolerance: float, times) -> tuple[np.ndarray | None, int]:
        """(states at the times, steps taken); (None, -1) where it fails."""
        self.prepare(tolerance)
        y, times = self.case.w.copy(), np.ascontiguousarray(times, float)
        out = np.empty((len(times), *y.shape))
        steps = self.functions.peer_run(self.handles[tolerance], 0.0, y.ctypes.data, times.ctypes.data, len(times), out.ctypes.data)
        return (out, steps) if steps >= 0 else (None, -1)

    def seconds(self, tolerance: float, repeats: int) -> float:
        """Of one run, the mean of several; counted in C."""
        self.prepare(tolerance)
        start, y, out = (np.array(self.case.w) for _ in range(3))
        return self.functions.peer_seconds(self.handles[tolerance], self.model._state, start.ctypes.data, self.case.time, repeats,
                                         y.ctypes.data, out.ctypes.data)

    def __del__(self):
        for handle in getattr(self, "handles", {}).values():
            self.functions.peer_free(handle)


def library(built, name: str, source: str, more):
    """The compiled integrator over this model. Raises Missing."""
    compiler = find_compiler()
    here = [*(HERE / n for n in (source, "rate.h", "sundials.h")), *sorted(FIELDS.glob("*.h"))]
    given, libraries = LINKED[source]()
    given = [*given, *more]
    key = digest(built.folder.name, source, [p.read_bytes() for p in here], compiler_version(compiler), FLAGS, given)
    command = [*compiler, *FLAGS, f'-DMODEL_SOURCE="{name}.c"', f'-DABI_SOURCE="{name}_abi.c"', f"-DMODEL={name}_abi", f"-I{built.folder}", f"-I{HERE}",
               *include_flags(), *given, str(HERE / source), "-o", LIBRARY, *libraries]
    return typed(ctypes.CDLL(str(entry(f"peer-{key[:32]}", lambda work: linked(command, work, source)) / LIBRARY)))


def where() -> list[str]:
    """Options of the compiler that find SUNDIALS."""
    folder = os.environ.get("SUNDIALS_DIR", "")
    return [f"-I{folder}/include", *(f"-L{folder}/{lib}" for lib in ("lib64", "lib"))] if folder else []


LINKED = {"gsl.c": lambda: ([], GSL), "by_hand.c": lambda: ([], ("-lm",)), "cvode.c": lambda: (where(), SUNDIALS), "arkode.c": lambda: (where(), SUNDIALS)}


def linked(command, work, source: str) -> None:
    """peer.so in `work`."""
    said = ran(command, work)
    if said.returncode:
        raise Missing(NEEDS[source])


def typed(found):
    """With the types of its functions."""
    pointer, real, integer = ctypes.c_void_p, ctypes.c_double, ctypes.c_int64
    for name, result, arguments in (("new", pointer, [pointer, ctypes.c_int, real, real]), ("free", None, [pointer]),
                                    ("run", integer, [pointer, real, pointer, pointer, integer, pointer]), ("rate", None, [pointer, real, pointer, pointer]),
                                    ("seconds", real, [pointer, pointer, pointer, real, ctypes.c_int, pointer, pointer])):
        function = getattr(found, f"peer_{name}")
        function.restype, function.argtypes = result, arguments
    return found
