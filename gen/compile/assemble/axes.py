"""Slopes along one axis, for rotations about it: dH/dx of all sites, or of one site where no term joins two."""
from __future__ import annotations

from ...language.spec import Once, Sites
from ..lower.code import Argument, Component, Element, Function, Name, Return, Zeros
from ..lower.integers import ZERO, Whole
from ..lower.kernels import COEFFICIENTS, TermKernels, additions
from ..lower.lowering import Lowering
from .families import SITE, by_family
from .part import Part, where_true
from .solo import shorter
from .sums import W, gathered, sums

AXES = "xyz"
SLOPES = Argument("smg_real *", "g")


def axis_kernels(model, low: Lowering) -> tuple:
    """For each axis {effect: function that adds its slopes}, without the effects that have none."""
    return tuple({t.prefix: f for t in model.energies if t.slots and (f := slopes_kernel(model, low, t, a)) is not None} for a in range(3))


def slopes_kernel(model, low: Lowering, t: TermKernels, axis: int) -> Function | None:
    """g_k[0] += de/d(slot k) along the axis; what tracers do to others is dropped."""
    felt = [k for k in range(len(t.slots)) if k not in model.unfelt(t)]
    kernel = low.kernel([shortened(low, t, t.derived.gradient[k][axis]) for k in felt], t.derived.leaves, t.derived.parts)
    if all(result.is_number(0) for result in kernel.results):
        return None
    outputs = tuple(Argument("smg_real *", f"g{k}") for k in felt)
    added = additions([Component(f"g{k}", 0) for k in felt], kernel.results)
    return Function("void", f"{t.prefix}_slopes_{AXES[axis]}", (*t.arguments(), *outputs), (*kernel.values, *added))


def shortened(low: Lowering, t: TermKernels, e):
    """As a polynomial in the components, its coefficients collected, where that takes fewer operations."""
    low.leaves.update(t.derived.leaves)
    return shorter(low.number_values(e), [x for v in t.derived.vectors for x in v])


def is_separate(model) -> bool:
    """Does no term join two sites?"""
    return all(len(t.slots) < 2 and isinstance(t.over, (Sites, Once)) for t in model.energies)


def axes_in_use(model) -> int:
    """1, 2, 4: there are x, y, z in H."""
    return sum(1 << a for a, found in enumerate(model.axes) if found)


def axis_functions(model) -> list:
    """The kernels, and what runtime/method/explicit/smg_axis_splitting.h asks of a model."""
    of_sites = slope_of_site if is_separate(model) else slopes_of_all
    return [*(f for found in model.axes for f in found.values()), *(of_sites(model, a) for a in range(3))]


def slopes_of_all(model, axis: int) -> Function:
    terms = [t for t in model.energies if t.prefix in model.axes[axis]]
    return Function("void", f"smg_slopes_{AXES[axis]}", (COEFFICIENTS, W, SLOPES),
                    sums(model, terms, lambda t: slopes_body(model, t, axis)), wanted=True)


def slopes_body(model, t, axis: int) -> tuple:
    outputs = [model.vector("g", s, True, 1) for k, s in enumerate(t.slots) if k not in model.unfelt(t)]
    return (t.call(f"slopes_{AXES[axis]}", [model.vector("w", s) for s in t.slots], *outputs),)


def slope_of_site(model, axis: int) -> Function:
    def calls(model, t, k):
        return (t.call(f"slopes_{AXES[axis]}", [Name("v")], Name("g")),) if t.prefix in model.axes[axis] else ()

    def body(f):
        found = gathered(model, f.name, calls)
        return (Zeros("g", 1), *found, Return(Element("g", 0))) if found else (Return(ZERO),)
    arguments = (*SITE, Argument("const smg_real *", "v"))
    return by_family("smg_real", f"smg_slope_{AXES[axis]}", arguments, body, model.families, index="site", wanted=True)


class Axes(Part):
    """Slopes along each axis, for the axis splitting."""
    name = "axes"

    def made(self, model, low):
        return axis_kernels(model, low) if model.method.splitting == "axes" else None

    def functions(self, model):
        return axis_functions(model)

    def settings(self, model):
        separate = is_separate(model)
        return {"SMG_AXES": axes_in_use(model), **where_true(SMG_SEPARATE=separate, SMG_ONE_SITE=separate and model.total == Whole(1))}
