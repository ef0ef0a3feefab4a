"""The functions of a compiled model, loaded with their types, and how parameters are handed to them."""
from __future__ import annotations

import ctypes
import os
from types import SimpleNamespace

import numpy as np

from ...errors import BuildError
from .evaluated import Evaluated

SPINS = "5000"


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


def functions(library, name):
    """The C functions of <name>_abi.c with their types."""
    pointer, real, integer = ctypes.c_void_p, ctypes.c_double, ctypes.c_int64
    types = {
        "new": (pointer, [pointer, pointer, pointer, real, real, pointer]),
        "set_tolerance": (ctypes.c_int, [pointer, real]), "take": (ctypes.c_int, [pointer, pointer]),
        "go": (ctypes.c_int, [pointer, pointer, integer, pointer]),
        "time": (real, [pointer]), "sites": (integer, [pointer]),
        "count": (integer, [pointer]),
        "outputs": (ctypes.c_int, [pointer, integer, integer, integer, pointer, pointer]),
        "savesize": (integer, [pointer]), "save": (None, [pointer, pointer]),
        "restore": (ctypes.c_int, [pointer, pointer]),
        "state": (None, [pointer, pointer]), "values": (None, [pointer, pointer]),
        "casimirs": (None, [pointer, pointer]), "report": (None, [pointer] * 6),
        "field": (None, [pointer, real, pointer, pointer]),
        "energy": (None, [pointer, real, pointer, pointer]), "free": (None, [pointer]),
    }
    if hasattr(library, f"{name}_abi_tangent"):
        types["tangent"] = (ctypes.c_int, [pointer, pointer, integer, integer, pointer])
    if hasattr(library, f"{name}_abi_ensemble_new"):
        types |= {"ensemble_new": (pointer, [pointer, pointer, ctypes.c_int, integer, pointer, real, real, real]),
                  "ensemble_steps": (integer, [pointer, integer, integer, integer]), "ensemble_lanes": (ctypes.c_int, []), "ensemble_reports": (None, [pointer] * 5),
                  "ensemble_states": (None, [pointer] * 3), "ensemble_energies": (None, [pointer] * 3), "ensemble_free": (None, [pointer])}
    found = SimpleNamespace()
    for word, (result, arguments) in types.items():
        function = getattr(library, f"{name}_abi_{word}", None)
        if function is None:
            raise BuildError(f"the library of {name} shows no function {name}_abi_{word}: use the compiler without options "
                             "that hide or rename functions (CC)")
        function.restype, function.argtypes = result, arguments
        setattr(found, word, function)
    return found
