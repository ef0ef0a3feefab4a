"""The last evaluation of a step in extended precision (feature "extended"): its kernels and coefficients."""
from __future__ import annotations

from dataclasses import dataclass

from ...errors import UsageError
from ..derive.derivatives import scalar
from ..lower.code import Argument, Assign, Call, Function, Let, Member, Name, Number, Ordered, Return, Unary, Zeros
from ..lower.integers import ZERO
from ..lower.kernels import COEFFICIENTS, gradient_function
from ..lower.lowering import CLOCK, PREPARE, STRIDE, Coefficients, Lowering
from .effort import widened
from .families import by_family, normal_kernel, returned
from .families import normal_body as normal_of
from .part import Part, buffer, where_true
from .sums import held, sums

WIDE = Argument("const smg_wide_coefficients *", "wide")
SITE = (COEFFICIENTS, WIDE, Argument("int64_t", "k"))
STATE = Argument("smg_state *", "s")


@dataclass(frozen=True)
class Wide:
    """functions: kernels of terms and sites; coefficients: hoisted values to all digits."""
    functions: tuple
    coefficients: Coefficients


def wide_kernels(model) -> Wide:
    """Kernels in pairs of numbers, with coefficients of their own."""
    low = Lowering(model.spec, holder="wide")
    terms = [wide_gradient(low, t) for t in model.energies if t.slots]
    return Wide((*terms, *wide_sites(model, low)), low.finished())


def wide_functions(model) -> list:
    """What runtime/core/smg_extended.h asks of a model."""
    effects = [t for t in model.energies if t.slots]
    found = [*model.wide.functions, over_all("smg_wide_gradient", sums(model, effects, lambda t: wide_body(model, t)))]
    if not model.solo:
        found.append(over_all("smg_wide_hessian_vector", sums(model, effects, lambda t: hessian_vector_body(model, t))))
    return [*coefficient_functions(model.wide.coefficients), *found]


def over_all(name: str, body) -> Function:
    head = (*held(body, "c", "smg_coefficients"), *held(body, "wide", "smg_wide_coefficients"))
    return Function("void", name, (STATE,), (*head, *body), wanted=True)


def coefficient_functions(coefficients: Coefficients) -> list:
    """Coefficients to all digits; what the caller gave is exact."""
    start = (Assign(Member("wide", "h"), exactly(Member("c", "h"))), Assign(Member("wide", "t"), exactly(ZERO)))
    found = [Function("void", "smg_wide_prepare", (Argument("smg_wide_coefficients *", "wide"), COEFFICIENTS),
                      (*start, *stored(coefficients, PREPARE), *stored(coefficients, STRIDE)), target="wide", wanted=True)]
    if coefficients.timed:
        body = (Assign(Member("wide", "t"), midpoint_time()), *stored(coefficients, CLOCK))
        head = (*held(body, "c", "smg_coefficients"), Let("wide", Unary("&", Member("s", "wide")), "smg_wide_coefficients *"))
        found.append(Function("void", "smg_wide_set_time", (STATE,), (*head, *body), target="wide", wanted=True))
    return found


def exactly(x) -> Call:
    return Call("smg_wide_of", (x,))


def midpoint_time() -> Call:
    """t0 + (count + 1/2) h."""
    steps = Ordered("+", Unary("(smg_real)", Member("s", "count")), Unary("(smg_real)", Number(0.5)))
    elapsed = Call("smg_wide_scale", (steps, exactly(Unary("(smg_real)", Member("s", "h")))))
    return Call("smg_wide_add", (exactly(Unary("(smg_real)", Member("s", "t0"))), elapsed))


def stored(coefficients: Coefficients, level: int) -> tuple:
    return tuple(Assign(Member("wide", name), value) for name, value in coefficients.at(level))


def wide_gradient(low: Lowering, t) -> Function:
    """g_k += d(term)/d(slot k), all in pairs."""
    kernel = low.kernel([x for row in t.derived.gradient for x in row], t.derived.leaves, t.derived.parts)
    plain = gradient_function(t, kernel)
    return Function("void", f"wide_{plain.name}", (COEFFICIENTS, WIDE, *plain.arguments[1:]), plain.body, target="wide")


def wide_body(model, t) -> tuple:
    """The call for one term. What tracers do to others is dropped, as everywhere."""
    unfelt = model.unfelt(t)
    if len(unfelt) == len(t.slots):
        return ()
    given = [model.vector(Member("s", "wide_m"), s, size=6) for s in t.slots]
    taken = [Name(f"spare{k}") if k in unfelt else model.vector(Member("s", "wide_g"), s, True, 6) for k, s in enumerate(t.slots)]
    c, *others = t.common()
    return (*(Zeros(f"spare{k}", 6) for k in unfelt), Call(f"wide_{t.prefix}_gradient", (c, Name("wide"), *others, *given, *taken)))


def hessian_vector_body(model, t) -> list:
    """y_k += (d2e/dk dl) d_l, in double."""
    vectors = [model.vector(Member("s", "wide_m"), s, size=6) for s in t.slots]
    return [t.call(f"hessian_{k}{l}", vectors, model.vector(Member("s", "wide_d"), t.slots[l]), model.vector(Member("s", "wide_y"), t.slots[k], True))
            for k, l in t.derived.hessian if k not in model.unfelt(t)]


def wide_sites(model, low: Lowering) -> list:
    """h/kappa, the normal grad C, and the radius of every site."""
    vector = (Argument("const smg_wide *", "v"), Argument("smg_wide *", "n"))
    functions = [("smg_wide", "smg_wide_h_over_kappa", SITE, lambda f: number(low, f.family.kappa, lambda kappa: low.step_size() / kappa)),
                 ("void", "smg_wide_normal", (*SITE, *vector), lambda f: normal_body(low, f))]
    if any(f.kind == "sphere" for f in model.families) and not model.unit_radius() and model.method.onto_leaf:
        functions.append(("smg_wide", "smg_wide_radius", SITE, lambda f: number(low, f.family.radius, lambda r: r) if f.radius else (Return(exactly(ZERO)),)))
    return [by_family(*function, model.families, target="wide", wanted=True) for function in functions]


def number(low: Lowering, formula, value) -> tuple:
    e, leaves = scalar(formula)
    return returned(low.kernel([value(e)], leaves))


def normal_body(low: Lowering, f) -> tuple:
    return normal_of(normal_kernel(low, f.family) if f.kind == "nambu" else None)


class Extended(Part):
    """The last evaluation of a step in extended precision."""
    name = "wide"
    types = ("wide_coefficients",)
    templates = {"structs": "wide_struct.h.j2"}

    def made(self, model, low):
        return wide_kernels(model) if "extended" in model.features else None

    def fits(self, model):
        if model.responses:
            raise UsageError("feature extended requires sites that only precess in their field")

    def functions(self, model):
        return wide_functions(model)

    def included(self, model):
        return ["smg_wide.h"]

    def slots(self, model):
        return {"wide_names": model.wide.coefficients.names}

    def first_members(self, model):
        return [f"{model.spec.name}_wide_coefficients wide"]

    def settings(self, model):
        return {"SMG_EXTENDED": 1, **where_true(SMG_WIDE_TIMED=model.wide.coefficients.timed, SMG_UNIT_RADIUS=model.method.onto_leaf and model.unit_radius())}

    def most(self, model, step):
        return step + widened()

    def buffers(self, model):
        """Pairs of numbers: three high parts and three low ones for each site."""
        n = model.total
        return [buffer("low", 3 * n, "low parts of u"), buffer("wide_m", 6 * n, "midpoints m, high and low parts"),
                buffer("wide_g", 6 * n, "dH/dw there"), buffer("wide_v", 6 * n, "h X there"), buffer("wide_d", 3 * n, "residual of u"),
                buffer("wide_e", 3 * n, "error of v"),
                buffer("wide_s", 0 if model.solo else n, "m = s mbar"), buffer("wide_y", 0 if model.solo else 3 * n, "change of dH/dw")]
