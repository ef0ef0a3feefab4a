"""The buffers of a state: the arrays that the caller's memory holds."""
from __future__ import annotations

from ..lower.code import Argument, Assign, Call, Function, Name, Return, Variable
from ..lower.integers import ZERO, Computed, Int, times, whole
from .part import buffer, placed
from .sums import held


def buffers(model) -> list:
    """The arrays of the state, in their order in memory."""
    return [*of_steps(model), *around_steps(model)]


def around_steps(model) -> list:
    """Those of maps around the step."""
    return [b for part in model.parts for b in part.around(model)]


def of_steps(model) -> list:
    """Those of the step itself."""
    n = model.total
    found = [buffer("w", 3 * n, "the state: 3 numbers per site"), buffer("compensation", 3 * n, "rounding errors of w"),
             buffer("u", 3 * n, "increment W - w of the current step")]
    instead = [b for part in model.parts for b in part.instead(model)]
    if instead:
        return found[:2] + instead
    if not model.method.of_midpoints:
        return found + [buffer(name, (Computed(size, (n,)) if isinstance(size, str) else size * n) + more, meaning)
                        for name, size, more, meaning in model.method.arrays]
    if any(f.kind != "sphere" for f in model.families):
        found.append(buffer("leaf_value", n, "|w| or C(w): the leaf of each site"))
    found.append(buffer("m", 3 * n, "points where the field is evaluated") if model.plan.coupled else
                 buffer("m", 0, "midpoints of coupled sites: none in this model"))
    if model.plan.coupled:
        found += [buffer("mbar", 3 * n, "midpoints (w + W)/2"), buffer("g", 3 * n, "dH/dw at m"), buffer("r", 3 * n, "residual"),
                  buffer("s", n, "m = s mbar"), *matrix_buffers(model),
                  buffer("curve", 15 * n, "for following a branch of solutions: point, tangent, changes")]
    return [*found, *(b for part in model.parts for b in part.buffers(model))]


def keeps_history(model) -> bool:
    """Are the increments of the steps before kept in rows of their own?"""
    return model.method.of_midpoints and not any(part.own_history(model) for part in model.parts)


def matrix_buffers(model) -> list:
    bs, n, rows = model.plan.block, model.total, model.plan.block * model.rows
    frame = [buffer("G", 3 * bs * n, "dual rows of the Newton matrix"),
             buffer("S", 3 * bs * n, "tangent columns"), buffer("x", bs * n, "right-hand side and solution")]
    matrix, work = matrix_size(model), work_size(model)
    if model.plan.matrix:
        return frame + [buffer("A", matrix, "Newton matrix"), buffer("work", work, "its factorisation")]
    return frame + [buffer("A", matrix, "diagonal blocks of the Newton matrix J"), buffer("sums", rows, "row sums of abs(J - I)"),
                    buffer("mean", rows, "the same for (J + J^T)/2"), buffer("v", 3 * n, "a change of the midpoints"),
                    buffer("hessian_v", 3 * n, "the change d2H/dw2 v of dH/dw"),
                    buffer("product", rows, "half of a product with J"), buffer("work", work, "basis of a Krylov space")]


def matrix_size(model) -> Int:
    """Of blocks: of all pairs, of a band, of a pattern, or of the diagonal alone."""
    plan, n = model.plan, model.rows
    blocks = {"dense": lambda: times(n, n), "band": lambda: (2 * plan.band + 1) * n, "sparse": lambda: whole(plan.pattern.blocks)}
    return plan.block ** 2 * blocks.get(plan.solver, lambda: n)()


def work_size(model) -> Int:
    plan = model.plan
    if plan.solver == "dense":
        return plan.block * model.rows
    if plan.solver == "band":
        return Computed("smg_band_worksize", (model.rows, whole(plan.band)))
    if plan.solver == "sparse":
        return Computed("smg_sparse_worksize", (whole(plan.pattern.size),))
    return Computed("smg_krylov_worksize", (plan.block * model.rows,))


def layout(model) -> Function:
    """The arrays one after the other in mem; how many numbers they take."""
    used = Name("used")
    first, *others = buffers(model)
    arrays = [Variable("size_t", "used", placed(first, ZERO)), *(Assign(used, placed(b, used)) for b in others)]
    before = [statement for part in model.parts for statement in part.laid_out(model)]
    last = Call("smg_place_history", (Name("s"), Name("mem"), used)) if keeps_history(model) else used
    return Function("size_t", "smg_layout", (Argument("smg_state *", "s"), Argument("smg_real *", "mem")),
                    (*held(arrays, "c", "smg_coefficients"), *before, *arrays, Return(last)), inlined="never")
