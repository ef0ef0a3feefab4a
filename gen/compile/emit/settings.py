"""What a model says of itself by macros, and the headers that its method is made of."""
from __future__ import annotations

from functools import cache

from ...resources import runtime_header
from ..assemble.model import Model
from ..lower.integers import Whole
from .includes import macros_of
from .print_wide import elementary

FEW = 4      # sites of which each gets its own copy of a loop's body: with two a step takes 6 or 7 % fewer instructions, with three 0.5 %
MATRICES = {"dense": "smg_matrix_dense.h", "band": "smg_matrix_band.h", "sparse": "smg_matrix_sparse.h"}


def settings(model: Model) -> list:
    """(name, value) of every macro that is not what smg_defaults.h has, or else 0."""
    coupled, alone, plan = model.coupled, model.alone, model.plan
    turned = plan.swept and plan.rotation
    found = {
        "SMG_BS": plan.block, "SMG_HISTORY": model.history, "SMG_FAMILIES": len(model.families),
        "SMG_ORIENTATION": 1 if model.spec.orientation > 0 else -1, "SMG_TIMED": model.coefficients.timed,
        "SMG_HAS_COUPLED": bool(coupled), "SMG_HAS_ALONE": bool(alone),
        "SMG_LEAVES": model.method.of_midpoints and any(f.kind != "sphere" for f in model.families),
        "SMG_ALONE_LINEAR": any(model.closed_form(f) for f in alone),
        "SMG_ALONE_NEWTON": any(not model.closed_form(f) for f in alone),
        "SMG_COUPLED_NAMBU": any(f.kind == "nambu" for f in coupled),
        "SMG_MATRIX_FREE": bool(coupled) and not plan.matrix, "SMG_SWEPT": plan.swept, "SMG_ROTATION": turned,
        "SMG_TRIED_SWEEPS": plan.tried if turned else 0, "SMG_CONSTANT_HESSIAN": turned and model.reach is not None,
        "SMG_BAND": plan.band if plan.solver == "band" else 0, "SMG_CYCLIC": plan.solver == "band" and plan.wrap,
        "SMG_FEW": bool(coupled) and isinstance(model.rows, Whole) and model.rows.value <= FEW,
        "SMG_ORDER": plan.pattern.size if plan.solver == "sparse" else 0,
        "SMG_HAS_LANES": most_lanes(model) > 0, "SMG_MOST_LANES": most_lanes(model), **dict(model.method.defines)}
    said = {name: value for part in model.parts for name, value in part.settings(model).items()}
    usual = defaults()
    return [(name, int(value)) for name, value in (*found.items(), *said.items()) if int(value) != usual.get(name, 0)]


@cache
def defaults() -> dict:
    """Macro -> its value where a model does not say it."""
    return macros_of(runtime_header("smg_defaults.h").read_text())


def headers(model: Model) -> list:
    """What the functions of the model are written with."""
    parts = [name for part in model.parts for name in part.headers(model)]
    return ["smg_model.h", *(["smg_wide_math.h"] if takes_wide_functions(model) else []), *dict.fromkeys(parts)]


def most_lanes(model: Model) -> int:
    """Of any part; 0 where none goes in lanes."""
    return next((lanes for part in model.parts if (lanes := part.lanes(model))), 0)


def takes_wide_functions(model: Model) -> bool:
    return model.wide is not None and elementary([*model.wide.functions, *(value for _, value, _ in model.wide.coefficients.values)])


def units(model: Model) -> int:
    """In how many units a library may be compiled: two where `smg_step.h` has the step of coupled sites apart."""
    return 2 if model.plan.coupled and not model.features and "smg_step.h" in method_headers(model) else 1


def method_headers(model: Model) -> list:
    """The method, what its step is made of, and its features."""
    composed = model.method.stages > 1
    names = [*([model.method.scheme] if composed else []), model.method.header]
    behind = [name for part in model.parts for name in part.behind(model)]
    if not model.method.of_midpoints:
        return [*names, *behind]
    if model.plan.coupled:
        names.append(MATRICES.get(model.plan.solver, "smg_matrix_free.h"))
    steps = [step for part in model.parts if (step := part.step(model))]
    names.append(steps[-1] if steps else "smg_step.h")
    return [*names, *behind]
