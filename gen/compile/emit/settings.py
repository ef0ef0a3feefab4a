"""What a model says of itself by macros, and the headers that its method is made of."""
from __future__ import annotations

from ..assemble.axes import axes_in_use, is_separate
from ..assemble.buffers import history, stages_kept
from ..assemble.lanes import has_lanes
from ..assemble.model import Model
from ..assemble.pair_rows import pair_row_settings
from ..assemble.rows import row_settings
from ..lower.integers import Whole
from .print_wide import elementary

FEW = 4      # sites of which each gets its own copy of a loop's body: with two a step takes 6 or 7 % fewer instructions, with three 0.5 %
FEW_LANES = 4      # where the number of sites is known at run time alone
MOST_LANES = 8      # of a row or an ensemble: the widest registers there are
ZERO_UNLESS_SAID = {f"SMG_{word}_{d}" for word in ("REACH", "WEIGHT") for d in range(4)}      # by smg_rows.h
MATRICES = {"dense": "smg_matrix_dense.h", "band": "smg_matrix_band.h", "sparse": "smg_matrix_sparse.h"}


def settings(model: Model) -> list:
    """(name, value) of every macro that is not 0."""
    coupled, alone, plan = model.coupled, model.alone, model.plan
    turned = plan.swept and plan.rotation
    found = {
        "SMG_BS": plan.block, "SMG_HISTORY": history(model), "SMG_FAMILIES": len(model.families),
        "SMG_ORIENTATION": 1 if model.spec.orientation > 0 else -1, "SMG_TIMED": model.coefficients.timed, "SMG_RESPONDS": bool(model.responses),
        "SMG_SINGLE_SPHERE": bool(model.solo), "SMG_HAS_MOTION": bool(model.motion), "SMG_HAS_COUPLED": bool(coupled), "SMG_HAS_ALONE": bool(alone),
        "SMG_LEAVES": model.method.of_midpoints and any(f.kind != "sphere" for f in model.families),
        "SMG_ALONE_LINEAR": any(model.closed_form(f) for f in alone),
        "SMG_ALONE_NEWTON": any(not model.closed_form(f) for f in alone),
        "SMG_COUPLED_NAMBU": any(f.kind == "nambu" for f in coupled),
        "SMG_COUPLED_LIFTED": "tangent" in model.features and model.lifts(),
        "SMG_MATRIX_FREE": bool(coupled) and not plan.matrix, "SMG_SWEPT": plan.swept, "SMG_ROTATION": turned,
        "SMG_TRIED_SWEEPS": plan.tried if turned else 0, "SMG_CONSTANT_HESSIAN": turned and model.reach is not None,
        "SMG_BAND": plan.band if plan.solver == "band" else 0, "SMG_CYCLIC": plan.solver == "band" and plan.wrap,
        "SMG_FEW": bool(coupled) and isinstance(model.rows, Whole) and model.rows.value <= FEW,
        "SMG_ORDER": plan.pattern.size if plan.solver == "sparse" else 0,
        "SMG_EXTENDED": model.wide is not None, "SMG_PLAIN_SUMS": "plain-sums" in model.features,
        "SMG_WIDE_TIMED": model.wide is not None and model.wide.coefficients.timed,
        "SMG_COMPOSED": model.method.stages if model.method.stages > 1 else 0, "SMG_STAGES_KEPT": stages_kept(model),
        "SMG_FEW_IN_LANES": model.few is not None, "SMG_LANE_SPHERE": model.lane_sphere is not None, "SMG_HAS_LANES": in_lanes(model), "SMG_MOST_LANES": most_lanes(model),
        "SMG_AXES": axes_in_use(model) if model.axes else 0, "SMG_SEPARATE": model.axes is not None and is_separate(model),
        "SMG_ONE_SITE": model.axes is not None and is_separate(model) and model.total == Whole(1),
        **dict(model.method.defines), "SMG_UNIT_RADIUS": model.wide is not None and model.method.onto_leaf and model.unit_radius()}
    found |= (by_rows := {**row_settings(model), **pair_row_settings(model)})
    read = {**dict.fromkeys(set(by_rows) - {"SMG_TANGENT", *ZERO_UNLESS_SAID}, True),
            "SMG_AXES": model.axes is not None, "SMG_COUPLED_NAMBU": coupled, "SMG_CONSTANT_HESSIAN": turned, "SMG_CYCLIC": plan.solver == "band"}     # by C itself, not by #if alone
    return [(name, int(value)) for name, value in found.items() if value or read.get(name)]


def headers(model: Model) -> list:
    """What the functions of the model are written with."""
    return ["smg_model.h", *(["smg_vec.h"] if model.solo or model.motion else []), *(["smg_wide_math.h"] if takes_wide_functions(model) else []),
            *(["smg_lanes.h"] if has_lanes(model) else []), *(["smg_lane_vec.h"] if model.lane_sphere else []), *(["smg_rows.h"] if model.in_rows else []), *(["smg_few.h"] if model.few is not None else [])]


def in_lanes(model: Model) -> bool:
    """Are lanes used at all: of states, of the sites of a row, of few sites, or of the members of an ensemble?"""
    return has_lanes(model) or model.in_rows is not None or model.few is not None or model.lane_sphere is not None


def most_lanes(model: Model) -> int:
    if model.few is not None:
        sites = model.total.value if isinstance(model.total, Whole) else FEW_LANES
        return min(1 << max(sites - 1, 1).bit_length(), MOST_LANES)
    return model.method.lanes if has_lanes(model) else MOST_LANES if in_lanes(model) else 0


def takes_wide_functions(model: Model) -> bool:
    return model.wide is not None and elementary([*model.wide.functions, *(value for _, value, _ in model.wide.coefficients.values)])


def method_headers(model: Model) -> list:
    """The method, what its step is made of, and its features."""
    composed = model.method.stages > 1
    names = [*([model.method.scheme] if composed else []), model.method.header]
    ensemble = [*([model.method.lane_header] if model.lane_sphere else []), "smg_ensemble.h"] if "ensemble" in model.features else []
    if not model.method.of_midpoints:
        return [*names, "smg_saved.h", *ensemble]
    if model.plan.coupled:
        names.append(MATRICES.get(model.plan.solver, "smg_matrix_free.h"))
    names.append("smg_composition.h" if composed else "smg_single_sphere.h" if model.solo else "smg_step.h")
    return [*names, "smg_saved.h", *(["smg_tangent.h"] if "tangent" in model.features else []), *ensemble]
