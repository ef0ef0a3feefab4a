"""The buffers of a state: the arrays that the caller's memory holds."""
from __future__ import annotations

from dataclasses import dataclass

from ..lower.code import Argument, Assign, Call, Function, If, Member, Name, Return, Unary, Variable
from ..lower.integers import ZERO, Computed, Index, Int, times, whole
from .sums import held

HISTORY = 7     # increments kept for the predictor; its degree adapts up to one less
FEW = 12        # of few sites in lanes: four vortices at h = 0.1 need 6.0 evaluations a step with 7, 4.8 with 10, 4.2 with 12
SOLO = 10       # the same of a single sphere, where another row costs less than another iteration
SOLO_STAGES = 8     # of its compositions: stages
ROWS = 64       # rows of history of a single sphere before they are moved back


@dataclass(frozen=True)
class Buffer:
    """An array of the state: how many numbers, and what they mean."""
    name: str
    size: Int
    meaning: str


def buffer(name: str, size, meaning: str) -> Buffer:
    return Buffer(name, whole(size), meaning)


def history(model) -> int:
    """Steps that are remembered."""
    if model.solo:
        return SOLO if model.method.stages == 1 else SOLO_STAGES
    if model.few is not None:
        return FEW
    return HISTORY if model.method.midpoint else model.method.history


def buffers(model) -> list:
    """The arrays of the state, in their order in memory."""
    n = model.total
    found = [buffer("w", 3 * n, "the state: 3 numbers per site"), buffer("compensation", 3 * n, "what w has lost to rounding"),
             buffer("u", 3 * n, "increment W - w of the step under way")]
    if model.in_rows and model.method.stage_rows:
        return found[:2] + [buffer("stages", Computed("smg_stages_size", (Index("c"),)), "components by slots: w, z, points, stages and slopes")]
    if not model.method.of_midpoints:
        return found + [buffer(name, (Computed(size, (n,)) if isinstance(size, str) else size * n) + more, meaning)
                        for name, size, more, meaning in model.method.arrays]
    if model.solo:
        found.append(buffer("rows", 4 * ROWS, "history: increment and 1/|w + W| of each step, newest first"))
    if any(f.kind != "sphere" for f in model.families):
        found.append(buffer("leaf_value", n, "|w| or C(w): the leaf each site is on"))
    found.append(buffer("m", 3 * n, "the points where the field is taken") if model.plan.coupled else
                 buffer("m", 0, "midpoints of coupled sites: none here"))
    if model.plan.coupled:
        found += [buffer("mbar", 3 * n, "midpoints (w + W)/2"), buffer("g", 3 * n, "dH/dw at m"), buffer("r", 3 * n, "residual"),
                  buffer("s", n, "m = s mbar"), *matrix_buffers(model),
                  buffer("curve", 15 * n, "a branch of solutions followed: its point, tangent, changes")]
    if model.few is not None:
        found.append(buffer("few", Computed("SMG_FEW_SIZE", (n,)), "the same in lanes, by components"))
    return [*found, *stage_buffers(model), *(wide_buffers(model) if model.wide else [])]


def stage_buffers(model) -> list:
    """Of a composition."""
    stages, n = model.method.stages, model.total
    if stages == 1:
        return []
    found = [buffer("misses", 5, "what every level of the predictor missed in a step, and in how many stages")]
    if model.solo:
        return [*found, buffer("prepared", Computed("smg_prepared_size", (whole(stages),)), "coefficients for every size of stage, after 1 and the h that they are for")]
    found.append(buffer("before", 6 * n, "w and compensation before the step"))
    return [*found, *([buffer("increments", 3 * stages * n, "increments of all stages of the step just taken")] if stages_kept(model) else [])]


def stages_kept(model) -> bool:
    """Does the tangent map need the increments of all stages? A single sphere has them in its history."""
    return model.method.stages > 1 and "tangent" in model.features and not model.solo


def matrix_buffers(model) -> list:
    bs, n, rows = model.plan.block, model.total, model.plan.block * model.rows
    frame = [buffer("G", 3 * bs * n, "dual rows of the Newton matrix"),
             buffer("S", 3 * bs * n, "tangent columns"), buffer("x", bs * n, "right-hand side and solution")]
    matrix, work = matrix_size(model), work_size(model)
    if model.plan.matrix:
        return frame + [buffer("A", matrix, "Newton matrix"), buffer("work", work, "its factorisation")]
    return frame + [buffer("A", matrix, "diagonal blocks of the Newton matrix J"), buffer("sums", rows, "row sums of abs(J - I)"),
                    buffer("mean", rows, "the same of (J + J^T)/2"), buffer("v", 3 * n, "a change of the midpoints"),
                    buffer("hessian_v", 3 * n, "the change of dH/dw that it makes, d2H/dw2 v"),
                    buffer("product", rows, "half of a product with J"), buffer("work", work, "basis of a Krylov space")]


def matrix_size(model) -> Int:
    """Of blocks: of all pairs, of a band, of a pattern, or of the diagonal alone."""
    plan, n = model.plan, model.rows
    blocks = {"dense": lambda: times(n, n), "band": lambda: (2 * plan.band + 1) * n, "sparse": lambda: whole(plan.pattern.blocks)}
    return plan.block ** 2 * blocks.get(plan.solver, lambda: n)()


def work_size(model) -> Int:
    plan = model.plan
    if plan.solver == "dense":
        return matrix_size(model)
    if plan.solver == "band":
        return Computed("smg_band_worksize", (model.rows, whole(plan.band)))
    if plan.solver == "sparse":
        return Computed("smg_sparse_worksize", (whole(plan.pattern.size),))
    return Computed("smg_krylov_worksize", (plan.block * model.rows,))


def wide_buffers(model) -> list:
    """Pairs of numbers: three high parts and three low ones for each site."""
    n = model.total
    return [buffer("low", 3 * n, "low parts of u"), buffer("wide_m", 6 * n, "midpoints m, high and low parts"),
            buffer("wide_g", 6 * n, "dH/dw there"), buffer("wide_v", 6 * n, "h X there"), buffer("wide_d", 3 * n, "what u lacks of it"),
            buffer("wide_e", 3 * n, "what v lacks of the solution"),
            buffer("wide_s", 0 if model.solo else n, "m = s mbar"), buffer("wide_y", 0 if model.solo else 3 * n, "change of dH/dw")]


def layout(model) -> Function:
    """The arrays one after the other in mem; how many numbers they take."""
    used = Name("used")
    placed = [Assign(used, Call("smg_place_array", (Unary("&", Member("s", b.name)), Name("mem"), used, Unary("(size_t)", b.size))))
              for b in buffers(model)]
    by_rows = (If((Member("s", "rows"),), (Return(Call("smg_row_layout", (Name("s"), Name("mem")))),)),) if model.in_rows and not model.method.stage_rows else ()
    last = used if model.solo or not model.method.of_midpoints else Call("smg_place_history", (Name("s"), Name("mem"), used))
    return Function("size_t", "smg_layout", (Argument("smg_state *", "s"), Argument("smg_real *", "mem")),
                    (*held(placed, "c", "smg_coefficients"), *by_rows, Variable("size_t", "used", ZERO), *placed, Return(last)), inlined="never")
