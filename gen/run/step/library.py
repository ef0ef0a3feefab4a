"""The functions of a compiled model, loaded with their types, and how parameters are handed to them."""
from __future__ import annotations

import ctypes
import os
from types import SimpleNamespace

import numpy as np

from ... import ranks
from ...compile.emit.signatures import FLAT, flat
from ...errors import BuildError
from .evaluated import Evaluated

SPINS = "5000"
PLACED = ("OMP_PROC_BIND", "OMP_PLACES", "GOMP_CPU_AFFINITY")
TYPES = {"void": None, "int": ctypes.c_int, "int64_t": ctypes.c_int64, "double": ctypes.c_double}
ASKED = {parts: found[0].word for parts, found in FLAT.items() if parts}       # parts of a model -> a function that says that it has them


def packed(numbers: Evaluated):
    """(scalars, arrays) as the C takes them: run-time parameters in the order of the spec."""
    free = [p for p in numbers.spec.parameters if not p.fixed]
    scalars = [float(numbers.values[p.name]) for p in free if p.kind != "array"]
    arrays = [np.ascontiguousarray(numbers.values[p.name], float) for p in free if p.kind == "array"]
    return np.array(scalars or [0.0]), arrays


def passed(scalars, arrays):
    """The same, and where the arrays are."""
    return scalars, arrays, (ctypes.c_void_p * max(1, len(arrays)))(*(a.ctypes.data for a in arrays))


def loaded(path):
    try:
        return ctypes.CDLL(str(path))
    except OSError as problem:
        raise BuildError(f"cannot load {path}: {problem}") from None


def loaded_with_threads(path, threads: int):
    """GNU's OpenMP reads its settings as it is loaded. By default threads wait for each other by spinning for so long that beside other
    programs a step takes hundreds of times its time; so they spin for some 0.1 ms, unless the user says otherwise. Those that join the one that
    calls are bound where `binds` says so; that one stays free, since all that the process begins later inherits its processors."""
    given = {} if "OMP_WAIT_POLICY" in os.environ or "GOMP_SPINCOUNT" in os.environ else {"GOMP_SPINCOUNT": SPINS}
    free = os.sched_getaffinity(0) if binds(threads) else None
    os.environ.update(given | ({} if free is None else {"OMP_PROC_BIND": "close", "OMP_PLACES": "threads"}))
    try:
        return loaded(path)
    finally:
        for name in (*given, *(() if free is None else ("OMP_PROC_BIND", "OMP_PLACES"))):
            del os.environ[name]
        if free is not None:
            os.sched_setaffinity(0, free)


def binds(threads: int | None) -> bool:
    """Are threads bound to processors? By default where a process has one for each of its threads and none to spare, so that no two programs
    are bound to the same few of many; not beside other ranks, and not where the user says how threads are placed (OMP_PROC_BIND=false: not at all)."""
    if threads is None or threads < 2 or ranks.count() > 1 or any(name in os.environ for name in PLACED):
        return False
    return hasattr(os, "sched_getaffinity") and len(os.sched_getaffinity(0)) == threads


def functions(library, name: str) -> SimpleNamespace:
    """The C functions of <name>_abi.c with their types, by the words of `signatures`; those of a feature where the library has them."""
    having = {part for parts, word in ASKED.items() if hasattr(library, f"{name}_abi_{word}") for part in parts}
    found = SimpleNamespace()
    for one in flat(having):
        function = getattr(library, f"{name}_abi_{one.word}", None)
        if function is None:
            raise BuildError(f"the library of {name} does not export the function {name}_abi_{one.word}: remove options that hide or rename functions "
                             "from CC")
        function.restype, function.argtypes = type_of(one.result), [type_of(kind) for _, kind in one.arguments]
        setattr(found, one.word, function)
    return found


def type_of(c: str):
    """The type of ctypes for a C type."""
    return ctypes.c_void_p if c.endswith("*") else TYPES[c]
