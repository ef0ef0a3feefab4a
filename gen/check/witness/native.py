"""The C part of the witness: compiled on demand, cached by content, linked with GSL."""
from __future__ import annotations

import ctypes
import functools
from pathlib import Path

from ...build.cache import entry
from ...build.binary import digest, find_compiler, ran
from ...errors import BuildError, MissingTool

FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-shared")
LIBRARIES = ("-lgsl", "-lgslcblas", "-lm")
NAME = "witness.so"
HERE = Path(__file__).resolve().parent

POINTER, REAL, INTEGER = ctypes.c_void_p, ctypes.c_double, ctypes.c_int64


class ProgramStruct(ctypes.Structure):
    """struct program of witness.h."""
    _fields_ = [(name, INTEGER) for name in ("length", "slots", "columns", "instances")] + [
        (name, POINTER) for name in ("code", "site", "data", "table", "feels")]


class PushStruct(ctypes.Structure):
    """struct pushes of witness.h."""
    _fields_ = [("value", ProgramStruct), ("moved", POINTER), ("component", INTEGER)]


class SystemStruct(ctypes.Structure):
    """struct system of witness.h."""
    _fields_ = [("sites", INTEGER), ("effects", INTEGER), ("torques", INTEGER), ("effect", POINTER), ("torque", POINTER),
                ("kappa", POINTER), ("casimir", POINTER), ("leaf", POINTER),
                ("alpha", POINTER), ("share", POINTER), ("lag", POINTER), ("orientation", REAL)]


TYPES = {
    "witness_field": [POINTER, REAL, POINTER, POINTER],
    "witness_turning": [POINTER, REAL, POINTER, POINTER],
    "witness_vector_field": [POINTER, REAL, POINTER, POINTER],
    "witness_jacobian": [POINTER, REAL, POINTER, POINTER, POINTER],
    "witness_sum": [POINTER, INTEGER, REAL, POINTER, POINTER],
    "witness_steps": [POINTER, ctypes.c_int, POINTER, REAL, REAL, INTEGER, INTEGER, POINTER,
                      POINTER],
    "witness_residuals": [POINTER, ctypes.c_int, REAL, REAL, INTEGER, POINTER, POINTER],
    "witness_equation": [POINTER, ctypes.c_int, REAL, REAL, POINTER, POINTER, POINTER, POINTER],
    "witness_flow": [POINTER, ctypes.c_int, REAL, REAL, POINTER, POINTER, INTEGER, POINTER],
}


@functools.lru_cache(maxsize=None)
def load():
    """The library with its argument types. Raises MissingTool without gcc or GSL."""
    library = ctypes.CDLL(str(_built()))
    for name, arguments in TYPES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = ctypes.c_int, arguments
    return library


def _built() -> Path:
    compiler = find_compiler()
    sources = sorted(p for p in HERE.iterdir() if p.suffix in (".c", ".h"))
    key = digest(compiler, FLAGS, LIBRARIES, [(p.name, p.read_bytes()) for p in sources])
    command = [*compiler, *FLAGS, *(str(p) for p in sources if p.suffix == ".c"), "-o", NAME, *LIBRARIES]
    return entry(f"witness-{key[:32]}", lambda work: _compile(command, work)) / NAME


def _compile(command, work):
    said = ran(command, work)
    if said.returncode or not (work / NAME).is_file():
        raise _problem(said.stderr)


def _problem(said: str):
    if "gsl" in said and ("No such file" in said or "not found" in said or "cannot find" in said):
        return MissingTool("the witness needs GSL: apt-get install libgsl-dev")
    first = next((line for line in said.splitlines() if "error" in line), said[:200])
    return BuildError(f"the witness cannot be compiled: {first}", log=said)
