"""Tracers in lanes, a site in each: their field at the midpoints of the sites that carry them (runtime/lattice/smg_alone_lanes.h).

They serve one family of spheres whose sites are all alike: no formula has the number of a tracer.
"""
from __future__ import annotations

from ...language.spec import Each, Sites
from ..derive.derivatives import switched
from ..lower.code import Argument, Call, Function, Name, Variable, Zeros, mentions
from ..lower.integers import ONE
from ..lower.kernels import COEFFICIENTS
from .effort import few_in_lanes
from .few import OUT
from .lanes import in_lanes, renamed
from .part import MOST_LANES, Part
from .sums import gathered

ARGUMENTS = (COEFFICIENTS, Argument("const smg_real *", "all"), Argument("const smg_lanes *", "own"), Argument(OUT, "g"))


def tracers_in_lanes(model):
    """The family, or None."""
    if not (model.plan.auto and model.plan.coupled and model.method.midpoint and model.method.onto_leaf and len(model.alone) == 1) or model.in_rows is not None:
        return None
    family, plain = model.alone[0], not (model.responses or model.moving or model.torques) and "extended" not in model.features
    return family if plain and family.kind == "sphere" and not model.closed_form(family) and all(serves(t, k) for t, k in model.roles(family.name)) else None


def serves(t, k: int) -> bool:
    """Smooth, a sum over sites, alone or with others, and the same for all of them."""
    functions = [f for f in t.functions if f.name in (f"{t.prefix}_gradient", f"{t.prefix}_hessian_{k}{k}")]
    alike = not any(t.slots[k][1] in mentions(*f.body) for f in functions)
    return isinstance(t.over, (Each, Sites)) and t.slots[k][1] in t.over.bound and not switched(t.derived) and not t.derived.parts and alike


# What the runtime asks of a model

def alone_functions(model) -> list:
    family = model.alone_in_lanes
    kernels = [in_lanes(f) for t, k in model.roles(family.name) for f in t.functions if f.name in (f"{t.prefix}_gradient", f"{t.prefix}_hessian_{k}{k}")]
    change = (*ARGUMENTS[:3], Argument("const smg_lanes *", "d"), Argument(OUT, "y"))
    return [*dict.fromkeys(kernels), Function("void", "smg_alone_field", ARGUMENTS, gathered(model, family.name, gradient_calls), target="lanes", wanted=True),
            Function("void", "smg_alone_change", change, gathered(model, family.name, change_calls), target="lanes", wanted=True)]


def gradient_calls(model, t, k: int) -> tuple:
    """g += dH/dw of those sites; what others feel of them is dropped."""
    outputs = [Name("g" if q == k else f"o{q}") for q in range(len(t.slots))]
    return (*others(model, t, k), *(Zeros(f"o{q}", 3) for q in range(len(t.slots)) if q != k), renamed(t.call("gradient", points(t, k), *outputs)))


def change_calls(model, t, k: int) -> tuple:
    """y += d2H/dw2 d."""
    if (k, k) not in t.derived.hessian:
        return ()
    return (*others(model, t, k), renamed(t.call(f"hessian_{k}{k}", points(t, k), Name("d"), Name("y"))))


def points(t, k: int) -> list:
    return [Name("own" if q == k else f"v{q}") for q in range(len(t.slots))]


def others(model, t, k: int) -> tuple:
    """The vector of each other site of a term, in all lanes."""
    return tuple(line for q, slot in enumerate(t.slots) if q != k
                 for line in (Variable("smg_lanes", f"v{q}[3]"), Call("smg_few_spread", (Name("all"), ONE, 3 * model.site(slot), Name(f"v{q}")))))


class TracersInLanes(Part):
    """Sites that are solved separately, several at once."""
    name = "alone_in_lanes"

    def made(self, model, low):
        return tracers_in_lanes(model)

    def functions(self, model):
        return alone_functions(model)

    def headers(self, model):
        return ["smg_few.h"]

    def settings(self, model):
        return {"SMG_ALONE_IN_LANES": 1}

    def most(self, model, step):
        return few_in_lanes() + step

    def lanes(self, model):
        return MOST_LANES
