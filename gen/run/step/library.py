"""The functions of a compiled model, loaded with their types, and how parameters are handed to them."""
from __future__ import annotations

import ctypes
import os
from types import SimpleNamespace

import numpy as np

from ...compile.emit.signatures import FLAT, flat
from ...errors import BuildError
from .evaluated import Evaluated

SPINS = "5000"
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


def loaded_with_threads(path):
    """GNU's OpenMP reads its settings as it is loaded. By default threads wait for each other by spinning for so long that beside other
    programs a step takes hundreds of times its time; so they spin for some 0.1 ms, unless the user says otherwise."""
    if "OMP_WAIT_POLICY" in os.environ or "GOMP_SPINCOUNT" in os.environ:
        return loaded(path)
    os.environ["GOMP_SPINCOUNT"] = SPINS
    try:
        return loaded(path)
    finally:
        del os.environ["GOMP_SPINCOUNT"]


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
