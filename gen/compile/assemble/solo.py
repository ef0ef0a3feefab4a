"""One unit sphere alone: kernels by value for the fastest step."""
from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..derive.derivatives import scalar
from ..derive.parts import expanded, functions_apart, is_short
from ..lower.code import Argument, Assign, Call, Component, Function, Local, Name, Number, Ordered, Return, Struct, Unary, Variable
from ..lower.integers import ONE, ZERO, Computed, Field, whole
from ..lower.kernels import COEFFICIENTS
from ..lower.lowering import SITE, Lowering
from .effort import single_sphere
from .part import Part, buffer
from .response import formulas, indexed

HISTORY = 10        # increments kept; another row costs less than another iteration
STAGES = 8          # the same of compositions: stages
ROWS = 64           # rows of history before they are moved back
MEMBER_ROWS = HISTORY + 2       # the same of members in lanes, whose history moves in registers: memory that is new takes longer than their start
M, SLOPE = Argument("smg_vec", "m"), Argument("smg_slope", "D")
OWN = {**{f"v0{axis}": Component("m", a) for a, axis in enumerate("xyz")}, "q": Local("q")}      # the vector m by value


@dataclass(frozen=True)
class SoloField:
    """In a vector m of symbols: h b(m), h X(m) with X = m x b, and D, its derivative."""
    m: sp.Matrix
    b: sp.Matrix
    X: sp.Matrix
    D: sp.Matrix

    @property
    def entries(self) -> list:
        """Places of D that are not zero."""
        return [(a, b) for a in range(3) for b in range(3) if self.D[a, b] != 0]


def solo_kernels(model, low: Lowering):
    """The functions of a single sphere, or None where the model is another one."""
    if not may_be_solo(model, low):
        return None
    field = solo_field(model, low)
    if not field.entries:
        return None
    return (motion(low, field), radial(low, field), Struct("smg_slope", tuple(f"e{a}{b}" for a, b in field.entries) or ("none",)),
            derivative(low, field), slope_times(field.entries), slope_minors(field.entries), slope_sums(field.entries),
            *((slope_trace(field.entries),) if model.responses else ()))


def lone_motion(model, low: Lowering) -> Function | None:
    """q h X of one unit sphere, for a method that asks for nothing else of it, in steps of the part q of h; None where the model is another one."""
    if not model.method.by_field or not is_lone(model, low):
        return None
    field = solo_field(model, low)
    direct = all(is_monomial(x, field.m) for x in field.X)
    known: dict = {}
    parts = [part_of(e, field.m, known) for e in (field.X if direct else field.b)]
    kernel = low.kernel(parts, {}, {name: e for e, name in known.items()}, OWN)
    moved = vector(kernel) if direct else Call("smg_vec_cross", (Name("m"), vector(kernel)))
    return solo_function("smg_vec", "smg_motion", (M, Argument("smg_real", "q")), (*kernel.values, Return(moved)))


def part_of(e, m, known: dict):
    """q e. Of a sum of monomials in m their coefficients times q are in `known`, by name: compilers compute them once for all stages of a step."""
    q, terms = sp.Symbol("q", real=True), sp.Add.make_args(e)
    if not all(is_monomial(term, m) for term in terms):
        return q * e
    split = [term.as_independent(*m, as_Add=False) for term in terms]
    return sum(known.setdefault(q * c, sp.Symbol(f"u{len(known)}")) * monomial for c, monomial in split)


def is_monomial(e, m) -> bool:
    """A product of powers of m and of what is free of it?"""
    return is_short(e) and e.is_polynomial(*m) and len(sp.Poly(e, *m).terms()) == 1


def may_be_solo(model, low: Lowering) -> bool:
    """One unit sphere, by a midpoint method onto it."""
    return model.method.of_midpoints and model.method.onto_leaf and is_lone(model, low)


def is_lone(model, low: Lowering) -> bool:
    """One unit sphere whose field depends on itself."""
    f = model.families[0]
    return (len(model.families) == 1 and f.count == ONE and f.unit and all(len(t.slots) < 2 for t in model.fields)     # no bond has both ends
            and not model.closed_form(f) and not any(indexed(r) for r in model.responses.values()) and not any(t.derived.parts for t in model.fields)
            and all(low.level(s.name) < SITE for t in model.fields for b in t.derived.hessian.values()
                    for s in b.free_symbols if s.name[0] != "v"))


def solo_field(model, low: Lowering) -> SoloField:
    m = sp.Matrix(sp.symbols("v0x v0y v0z", real=True))
    kappa, leaves = scalar(model.families[0].family.kappa)
    low.leaves.update(leaves)
    b = sp.Matrix([sum(t.derived.gradient[0][a] for t in model.fields if t.slots) for a in range(3)])
    b = in_its_field(low, b, m, model.responses.get(model.families[0].name))
    b = (b * low.step_size() / kappa).applyfunc(low.number_values).applyfunc(lambda e: shorter(e, m))
    X = m.cross(b).applyfunc(lambda e: shorter(e, m))
    return SoloField(m, b, X, X.jacobian(m).applyfunc(lambda e: shorter(e, m)))


def in_its_field(low: Lowering, g, m, response):
    """The vector R of a motion m x R: g, or with a response F + m x Q."""
    if response is None:
        return g
    f, q, *rest = (formula for formula, leaves in map(scalar, formulas(response)) if low.leaves.update(leaves) is None)
    return f * g + sp.Matrix(rest[:3]) + m.cross(q * g + sp.Matrix(rest[3:]))


def solo_function(kind: str, name: str, arguments, body) -> Function:
    return Function(kind, name, (COEFFICIENTS, *arguments), tuple(body), target="value", wanted=True)


def vector(kernel) -> Call:
    return Call("smg_vec_of", kernel.results)


def motion(low: Lowering, field: SoloField) -> Function:
    """h X(m). As m x b it stays tangent whatever the coefficients are rounded to; three single
    products, a free body's, need less work and what rounding leaves, d mx my mz, averages out."""
    if all(is_short(x) and len(sp.Add.make_args(expanded(x))) == 1 for x in field.X):
        return products(low, field)
    kernel = low.kernel(list(field.b), {}, own=OWN)
    return solo_function("smg_vec", "smg_motion", (M,), (*kernel.values, Return(Call("smg_vec_cross", (Name("m"), vector(kernel))))))


def products(low: Lowering, field: SoloField) -> Function:
    """h X(m) as its formulas are."""
    kernel = low.kernel(list(field.X), {}, own=OWN)
    return solo_function("smg_vec", "smg_motion", (M,), (*kernel.values, Return(vector(kernel))))


def radial(low: Lowering, field: SoloField) -> Function:
    """e = DX m; for a field homogeneous of degree p this is p X."""
    e, arguments = field.D * field.m, (M, Argument("smg_vec", "g"))
    for degree in range(1, 9):
        if all(expanded(e[a] - degree * field.X[a]) == 0 for a in range(3)):
            return solo_function("smg_vec", "smg_radial", arguments, (Return(Call("smg_vec_scale", (Number(degree), Name("g")))),))
    kernel = low.kernel([shorter(x, field.m) for x in e], {}, own=OWN)
    return solo_function("smg_vec", "smg_radial", arguments, (*kernel.values, Return(vector(kernel))))


def derivative(low: Lowering, field: SoloField) -> Function:
    """q DX, in a struct of its non-zero entries."""
    q = sp.Symbol("q", real=True)
    kernel = low.kernel([q * field.D[a, b] for a, b in field.entries], {}, own=OWN)
    stored = [Assign(entry(a, b), result) for (a, b), result in zip(field.entries, kernel.results)]
    body = (*kernel.values, Variable("smg_slope", "D"), *stored, Return(Name("D")))
    return solo_function("smg_slope", "smg_derivative", (M, Argument("smg_real", "q")), body)


def entry(a: int, b: int) -> Field:
    return Field("D", f"e{a}{b}")


def added(terms):
    """The sum of products a b in this order: [(sign, a, b), ..]."""
    found = ZERO
    for k, (sign, a, b) in enumerate(terms):
        if k == 0:
            found = Ordered("*", Unary("-", a) if sign == "-" else a, b)
        else:
            found = Ordered(sign, found, Ordered("*", a, b))
    return found


def slope_times(entries) -> Function:
    """D v."""
    rows = [[("+", entry(a, b), Component("v", b)) for a, b in entries if a == row] for row in range(3)]
    return Function("smg_vec", "smg_slope_times", (SLOPE, Argument("smg_vec", "v")), (Return(Call("smg_vec_of", tuple(map(added, rows)))),),
                    target="value", wanted=True)


def slope_minors(entries) -> Function:
    """e2(D): the sum of the principal 2x2 minors."""
    terms = []
    for a, b in ((0, 1), (0, 2), (1, 2)):
        if (a, a) in entries and (b, b) in entries:
            terms.append(("+", entry(a, a), entry(b, b)))
        if (a, b) in entries and (b, a) in entries:
            terms.append(("-", entry(a, b), entry(b, a)))
    return Function("smg_real", "smg_slope_minors", (SLOPE,), (Return(added(terms)),), target="value", wanted=True)


def slope_trace(entries) -> Function:
    """tr D."""
    found = ZERO
    for a, b in entries:
        if a == b:
            found = entry(a, b) if found is ZERO else Ordered("+", found, entry(a, b))
    return Function("smg_real", "smg_slope_trace", (SLOPE,), (Return(found),), target="value", wanted=True)


def slope_sums(entries) -> Function:
    """The row sums of abs(D)."""
    sums = [ZERO, ZERO, ZERO]
    for a, b in entries:
        size = Call("smg_abs", (entry(a, b),))
        sums[a] = size if sums[a] is ZERO else Ordered("+", sums[a], size)
    return Function("smg_vec", "smg_slope_sums", (SLOPE,), (Return(Call("smg_vec_of", tuple(sums))),), target="value", wanted=True)


def shorter(e, m):
    """A polynomial in m with its coefficients collected, where that takes fewer operations."""
    if not is_short(e):
        return e
    whole, back = functions_apart(e)        # Poly would multiply out what stands in them
    if any(f.free_symbols & set(m) for f in back.values()):
        return e
    return collected(whole, m).xreplace(back)


def collected(e, m):
    """The same without functions."""
    long = expanded(e)
    if not long.is_polynomial(*m) or len(sp.Add.make_args(long)) > 40:
        return e
    terms = sp.Poly(long, *m).terms()
    monomials = [sp.prod(x ** k for x, k in zip(m, powers)) for powers, _ in terms]
    bare = sum(sp.Symbol(f"known{k}") * monomial for k, monomial in enumerate(monomials))
    if sp.count_ops(bare) < work(e, m):
        return sum(c * monomial for (_, c), monomial in zip(terms, monomials))
    return e


def work(e, m) -> int:
    """Operations that remain when all that is free of m is known."""
    rest = e.replace(lambda x: isinstance(x, sp.Expr) and not x.is_Atom and not (x.free_symbols & set(m)), lambda x: sp.Dummy())
    return int(sp.count_ops(rest))


def rows_kept(model) -> int:
    """Rows of its history; those of a step of a composition fit below those before it."""
    if not model.lane_sphere:
        return ROWS
    return MEMBER_ROWS if model.method.stages == 1 else 2 * STAGES + model.method.stages


class SingleSphere(Part):
    """One unit sphere, whose step is in registers."""
    name, layout = "solo", "single"

    def made(self, model, low):
        return solo_kernels(model, low)

    def functions(self, model):
        return [*model.solo]

    def headers(self, model):
        return ["smg_vec.h"]

    def settings(self, model):
        return {"SMG_SINGLE_SPHERE": 1}

    def buffers(self, model):
        rows = buffer("rows", 4 * rows_kept(model), "history: increment and 1/|w + W| of each step, newest first")
        prepared = buffer("prepared", Computed("smg_prepared_size", (whole(model.method.stages),)), "coefficients of each stage size, after 1 and the h that they belong to")
        return [rows] if model.method.stages == 1 else [rows, prepared]

    def members(self, model):
        return [("int row", "newest row of the history"), ("int64_t begun", "the count at which the history began"),
                ("smg_real older[4]", "part of the prediction that depends only on the older rows")]

    def history(self, model):
        return HISTORY if model.method.stages == 1 else STAGES

    def own_history(self, model):
        return True

    def step(self, model):
        return "smg_single_sphere.h"

    def most(self, model, step):
        return single_sphere()


class LoneMotion(Part):
    """The field of one unit sphere in one formula, for methods that ask for nothing else."""
    name = "motion"

    def made(self, model, low):
        return lone_motion(model, low)

    def functions(self, model):
        return [model.motion]

    def headers(self, model):
        return ["smg_vec.h"]

    def settings(self, model):
        return {"SMG_HAS_MOTION": 1}
