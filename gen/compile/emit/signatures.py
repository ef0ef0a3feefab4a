"""The functions of a model, each signature once: public header and ABI are printed from it, the types for ctypes are read from it."""
from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

# Types of C; {M} is the model's name.
PARAMS = "const {M}_params *"
NEW_PARAMS = "{M}_params *"
MODEL = "const {M}_model *"
NEW_MODEL = "{M}_model *"
STATE = "{M}_state *"
CONST_STATE = "const {M}_state *"
ENSEMBLE = "{M}_ensemble *"
POINTER = "void *"
CONST_POINTER = "const void *"
REALS = "smg_real *"
CONST_REALS = "const smg_real *"
REAL = "smg_real"
DOUBLE = "double"
DOUBLES = "double *"
CONST_DOUBLES = "const double *"
ARRAYS = "const double *const *"
INT = "int"
INTS = "int *"
LONG = "int64_t"
LONGS = "int64_t *"
SIZE = "size_t"
STATUS = "smg_status"
VOID = "void"
FLAGS = "const unsigned char *"


@dataclass(frozen=True)
class Signature:
    """A function without the prefix that it has in the header, `<model>_`, or in the ABI, `<model>_abi_`.

    arguments: (name, type) of each.
    """
    result: str
    word: str
    arguments: tuple[tuple[str, str], ...]

    def declared(self, model: str, prefix: str = "_") -> str:
        """Its head in C, for a model of that name."""
        listed = ", ".join(joined(kind, name) for name, kind in self.arguments)
        return f"{joined(self.result, '{M}' + prefix + self.word)}({listed or VOID})".format(M=model)


def joined(kind: str, name: str) -> str:
    """`int64_t count`, `void *s`."""
    return f"{kind}{name}" if kind.endswith("*") else f"{kind} {name}"


def of(result: str, word: str, **arguments: str) -> Signature:
    return Signature(result, word, tuple(arguments.items()))


PUBLIC = (
    of(VOID, "defaults", p=NEW_PARAMS),
    of(STATUS, "model_init", model=NEW_MODEL, p=PARAMS),
    of(STATUS, "set_parameters", model=NEW_MODEL, p=PARAMS),
    of(LONG, "sites", model=MODEL),
    of(SIZE, "memsize", model=MODEL),
    of(STATUS, "init", s=STATE, model=MODEL, mem=POINTER, w=CONST_REALS, t0=DOUBLE, h=DOUBLE),
    of(STATUS, "set_tolerance", s=STATE, tolerance=DOUBLE),
    of(STATUS, "step", s=STATE),
    of(STATUS, "steps", s=STATE, count=LONG),
    of(DOUBLE, "time", s=CONST_STATE),
    of(STATUS, "set_state", s=STATE, w=CONST_REALS),
    of(VOID, "set_seed", s=STATE, seed="uint64_t", member="uint32_t"),
    of(SIZE, "savesize", model=MODEL),
    of(VOID, "save", s=CONST_STATE, out=REALS),
    of(STATUS, "restore", s=STATE, **{"in": CONST_REALS}),
    of(VOID, "field", model=MODEL, t=REAL, w=CONST_REALS, b=REALS),
    of(REAL, "energy", model=MODEL, t=REAL, w=CONST_REALS),
    of(VOID, "momentum", model=MODEL, w=CONST_REALS, out=REALS),
    of(VOID, "casimirs", model=MODEL, w=CONST_REALS, out=REALS),
    of(VOID, "part", model=MODEL, **{"from": LONGS}, to=LONGS),
    of(VOID, "save_part", s=CONST_STATE, **{"from": LONG}, to=LONG, out=REALS),
    of(SIZE, "tangent_memsize", model=MODEL),
    of(STATUS, "tangent", s=STATE, v=REALS, columns=LONG, mem=POINTER),
    of(SIZE, "ensemble_memsize", model=MODEL, own=INT, members=LONG),
    of(LONG, "ensemble_init", e=ENSEMBLE, model=MODEL, own=INT, members=LONG, mem=POINTER, w=CONST_REALS, t0=DOUBLE, h=DOUBLE),
    of(LONG, "ensemble_steps", e=ENSEMBLE, first=LONG, members=LONG, count=LONG),
    of(INT, "ensemble_lanes"),
)

# parts that ask for them -> functions over `void *`, for callers without the types of the header
FLAT = {
    ("tangent",): (
        of(INT, "tangent", s=POINTER, v=REALS, columns=LONG, count=LONG, done=LONGS),
    ),
    ("ensemble",): (
        of(POINTER, "ensemble_new", scalars=CONST_DOUBLES, arrays=ARRAYS, own=INT, members=LONG, w=CONST_REALS, t0=DOUBLE, h=DOUBLE, tolerance=DOUBLE),
        of(LONG, "ensemble_steps", e=POINTER, first=LONG, members=LONG, count=LONG),
        of(INT, "ensemble_lanes"),
        of(VOID, "ensemble_reports", e=POINTER, count=LONGS, status=INTS, site=LONGS, reached=DOUBLES),
        of(VOID, "ensemble_states", e=POINTER, began=FLAGS, w=REALS),
        of(VOID, "ensemble_energies", e=POINTER, began=FLAGS, energy=REALS),
        of(VOID, "ensemble_free", e=POINTER),
    ),
    ("distributed",): (
        of(VOID, "part_of", scalars=CONST_DOUBLES, arrays=ARRAYS, part=LONGS),
        of(POINTER, "part_w", s=POINTER),
        of(VOID, "part_save", s=POINTER, **{"from": LONG}, to=LONG, out=REALS),
    ),
    ("thermal",): (
        of(VOID, "set_seed", s=POINTER, seed=LONG, member=LONG),
        of(LONG, "halved", s=POINTER),
    ),
    ("thermal", "ensemble"): (
        of(VOID, "ensemble_set_seed", e=POINTER, seed=LONG),
    ),
    (): (        # always
        of(POINTER, "new", scalars=CONST_DOUBLES, arrays=ARRAYS, w=CONST_REALS, t0=DOUBLE, h=DOUBLE, status=INTS),
        of(INT, "set_parameters", s=POINTER, scalars=CONST_DOUBLES, arrays=ARRAYS),
        of(INT, "set_tolerance", s=POINTER, tolerance=DOUBLE),
        of(INT, "take", s=POINTER, w=REALS),
        of(INT, "go", s=POINTER, w=REALS, count=LONG, done=LONGS),
        of(INT, "steps", s=POINTER, count=LONG, done=LONGS),
        of(DOUBLE, "time", s=POINTER),
        of(LONG, "sites", s=POINTER),
        of(VOID, "state", s=POINTER, w=REALS),
        of(LONG, "savesize", s=POINTER),
        of(VOID, "save", s=POINTER, out=REALS),
        of(INT, "restore", s=POINTER, **{"in": CONST_REALS}),
        of(VOID, "values", s=POINTER, asked=FLAGS, out=REALS),
        of(VOID, "casimirs", s=POINTER, out=REALS),
        of(INT, "outputs", s=POINTER, first=LONG, every=LONG, rows=LONG, out=CONST_POINTER, done=LONGS),
        of(LONG, "count", s=POINTER),
        of(VOID, "report", s=POINTER, iterations=INTS, residual=DOUBLES, site=LONGS, partner=LONGS, reached=DOUBLES),
        of(VOID, "field", s=POINTER, t=DOUBLE, w=CONST_REALS, b=REALS),
        of(VOID, "energy", s=POINTER, t=DOUBLE, w=CONST_REALS, e=REALS),
        of(VOID, "free", s=POINTER),
    ),
}


def flat(having) -> list[Signature]:
    """The functions of the ABI of a model with these parts."""
    return [one for parts, found in FLAT.items() if set(parts) <= set(having) for one in found]


def heads(model: str) -> dict:
    """For the templates: C has the heads of public functions by their words, F those of the ABI."""
    return {"C": SimpleNamespace(**{one.word: one.declared(model) for one in PUBLIC}),
            "F": SimpleNamespace(**{one.word: one.declared(model, "_abi_") for found in FLAT.values() for one in found})}
