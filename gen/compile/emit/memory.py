"""The memory that a model, a state and its arrays take, in bytes, of doubles on a machine of 64 bits."""
from __future__ import annotations

import re
from math import prod

from ...resources import runtime_numbers
from ..assemble.buffers import buffers, keeps_history
from ..lower.integers import Computed, Given, Index, Size, Sum, Whole

SIZES = {"int": 4, "int32_t": 4, "uint32_t": 4, "smg_status": 4, "smg_wide": 16}     # of what is not 8, as pointers, numbers and int64_t are
REPORT = ("smg_status status", "int iterations", "smg_real residual", "int64_t site, partner", "smg_real reached")
WORD = 8


def struct_bytes(declarations) -> int:
    """Of a struct with these members, each aligned as it is large, of nested ones as a word."""
    at = 0
    for one in declarations:
        if isinstance(one, int):
            at = aligned(at, WORD) + one
            continue
        words, names = re.fullmatch(r"((?:const |unsigned )*\w+) (.+)", one).groups()
        for name in names.split(","):
            size = WORD if "*" in name else SIZES.get(words.split()[-1], WORD)
            at = aligned(at, min(size, WORD)) + size * int((re.findall(r"\[(\d+)\]", name) or [1])[0])
    return aligned(at, WORD)


def aligned(at: int, size: int) -> int:
    return -(-at // size) * size


def model_bytes(slots: dict) -> int:
    """Of <model>_model, by what fills its template."""
    params = struct_bytes([p["declaration"] for p in slots["params"]] or ["int unused"])
    return struct_bytes([params, *[WORD] * (len(slots["integer_names"]) + len(slots["model_names"])), "uint64_t version", "smg_status status"])


def state_bytes(slots: dict) -> int:
    """Of <model>_state."""
    coefficients = struct_bytes(["const smg_model *model", "smg_real t, h", *(f"smg_real {name}" for name in slots["state_names"]), *(d for d, _ in slots["held"])])
    unit = SIZES["smg_wide"] if slots["first"] else WORD
    wide = SIZES["smg_wide"] * (2 + len(slots["wide_names"])) if slots["first"] else 0
    history = ["int newton_steps", f"smg_real *past[{slots['H']}]"] * bool(slots["keeps_history"])
    found = struct_bytes([aligned(coefficients, unit) + wide, "uint64_t version", "double t0, h", "int64_t count", "int history", "int degree", *history,
                         *(d for d, _ in slots["members"]), *(f"smg_real *{a.name}" for a in slots["arrays"]), "smg_real tolerance, scale", struct_bytes(REPORT)])
    return aligned(found, unit)


# The arrays

def array_bytes(model, given: dict) -> int | None:
    """What <model>_memsize says, at most, where the integer parameters are those given; None where only it knows."""
    try:
        numbers = sum(value(b.size, model, given) for b in buffers(model))
        others = (part.numbers(model, lambda e: value(e, model, given)) for part in model.parts)
        return WORD * max(numbers + (history_numbers(model, given) if keeps_history(model) else 0), *others, 0)
    except KeyError:
        return None


def history_numbers(model, given: dict) -> int:
    """smg_place_history; compositions have as many to spare."""
    return (2 if model.method.stages > 1 else 1) * model.history * 3 * value(model.total, model, given)


def value(e, model, given: dict) -> int:
    """A size; KeyError where it is not known."""
    if isinstance(e, Whole):
        return e.value
    if isinstance(e, Size):
        return value(dict(model.coefficients.sizes)[e.name], model, given)
    if isinstance(e, Given):
        return given[e.name]
    if isinstance(e, Computed):
        return function(e.function, model, given)(*(value(x, model, given) for x in e.args if x != Index("c")))
    return (sum if isinstance(e, Sum) else prod)(value(x, model, given) for x in (e.terms if isinstance(e, Sum) else e.factors))


def function(name: str, model, given: dict):
    """One of the runtime that says how large an array is: of a solver, or of a part."""
    block = model.plan.block ** 2
    found = {"smg_band_worksize": lambda n, k: 2 * k * n * block, "smg_sparse_worksize": lambda n: n * block, "smg_krylov_worksize": krylov}
    for part in model.parts:
        found |= part.sizes(model, lambda e: value(e, model, given))
    return found[name]


def krylov(n: int) -> int:
    """smg_krylov_worksize."""
    whole, dense, long, short = (runtime_numbers()[f"SMG_KRYLOV_{word}"][0] for word in ("WHOLE", "DENSE", "BASIS", "SHORT"))
    vectors = min(n, long if n <= whole else short) + 3
    return (n + 1 if vectors <= n <= dense else vectors) * n + 1
