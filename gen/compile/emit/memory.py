"""The memory that a model, a state and its arrays take, in bytes, of doubles on a machine of 64 bits."""
from __future__ import annotations

import re
from math import prod

from ..assemble.buffers import buffers, keeps_history
from ..assemble.part import MOST_LANES
from ..lower.integers import Computed, Given, Size, Sum, Whole

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
    if model.plan.layout == "rows":
        return None
    try:
        numbers = sum(value(b.size, model, given) for b in buffers(model))
        return WORD * (numbers + (history_numbers(model, given) if keeps_history(model) else 0))
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
        return FUNCTIONS[e.function](model.plan.block ** 2, *(value(x, model, given) for x in e.args))
    return (sum if isinstance(e, Sum) else prod)(value(x, model, given) for x in (e.terms if isinstance(e, Sum) else e.factors))


# Those of the runtime, by the numbers of a block: of few sites in lanes with the widest registers
FUNCTIONS = {"smg_band_worksize": lambda block, n, k: 2 * k * n * block, "smg_sparse_worksize": lambda block, n: n * block,
             "SMG_FEW_SIZE": lambda block, n: 15 * MOST_LANES * -(-n // MOST_LANES)}
