"""Bonds one after the other, and back, or on lattices class after class: visits of all pairs of sites that a term f(w_i.w_j) joins, with f'."""
from __future__ import annotations

from dataclasses import replace
from itertools import groupby

import sympy as sp

from ...language.spec import Lattice
from ..lower.code import Argument, Block, Call, Declaration, For, Function, If, Let, Name, Return, tidy
from ..lower.integers import ZERO, Index, compare, whole
from ..lower.kernels import COEFFICIENTS, TermKernels
from ..lower.lowering import CLOCK, Lowering
from ..plan.colouring import one_colour
from ..plan.splitting import bond_classes, of_the_product, sublattices
from .extent import largest_ever, without_exponentials
from .part import Part
from .sublattices import fitting

PRODUCT = sp.Symbol("product", real=True)       # w_i.w_j
VISIT = (COEFFICIENTS, Argument("const smg_real *", "all"), Argument("void *", "context"),
         Argument("void", "visit", "void *context, int64_t i, int64_t j, smg_real slope"))
OF_CLASS = (COEFFICIENTS, Argument("int64_t", "which"), *VISIT[1:])


def pair_kernels(model, low: Lowering) -> dict:
    """{effect: function f'(w_i.w_j)}."""
    return {t.prefix: slope_kernel(low, t) for t in model.energies if t.slots}


def slope_of(t: TermKernels):
    return sp.diff(of_the_product(t.derived, PRODUCT), PRODUCT)


def slope_kernel(low: Lowering, t: TermKernels) -> Function:
    kernel = low.kernel([slope_of(t)], t.derived.leaves)
    given = (*(a for a in t.arguments() if a.name not in ("v0", "v1")), Argument("smg_real", PRODUCT.name))
    return Function("smg_real", f"{t.prefix}_slope", given, (*kernel.values, Return(kernel.results[0])))


def slope_bound(model, low: Lowering):
    """A function that bounds |f'| of every bond at all times where |w_i.w_j| is at most `product`; None where it is no polynomial, cells differ, or there is
    no such bound."""
    total = sp.S.Zero
    for t in model.energies:
        slope = slope_of(t) if t.slots else sp.S.Zero
        if not slope.is_polynomial(PRODUCT):
            return None
        held, back = without_exponentials(slope)        # not expanded, as in `expanded`
        values = [low.number_values(x.xreplace(back)) for x in sp.Poly(held, PRODUCT).all_coeffs()[::-1]]
        sizes = [None if low.when(x) > CLOCK else largest_ever(low, abs(x)) for x in values]
        if None in sizes:
            return None
        total += sum(x * PRODUCT ** k for k, x in enumerate(sizes))
    kernel = low.kernel([total], {})
    return Function("smg_real", "smg_slope_bound", (COEFFICIENTS, Argument("smg_real", PRODUCT.name)), (*kernel.values, Return(kernel.results[0])), wanted=True)


def pair_functions(model) -> list:
    """The kernels, and what runtime/method/explicit/smg_pair_rotations.h asks of a model."""
    there = tuple(line for t in model.energies if t.slots for line in bonds(model, t))
    return [*model.pairs.values(), visits("smg_each_pair", tidy(there)), visits("smg_each_pair_back", backward(tidy(there))), *class_functions(model)]


def visits(name: str, body, arguments=VISIT) -> Function:
    """Inlined, so that the call of `visit` is, too."""
    return Function("void", name, arguments, body, wanted=True, inlined="always")


def visit_of(model, t: TermKernels) -> Call:
    """Of one bond."""
    a, b = t.slots
    product = Call("smg_dot", (model.vector("all", a), model.vector("all", b)))
    return Call("visit", (Name("context"), model.site(a), model.site(b), Call(f"{t.prefix}_slope", (*t.common(), product))))


def bonds(model, t: TermKernels) -> tuple:
    """All bonds of an effect; on a lattice those of one direction after those of another."""
    visit = (visit_of(model, t),)
    if isinstance(t.over, Lattice):
        return tuple(line for n in range(len(t.over.bonds)) for line in tidy(model.loops.of_bonds(t.over, (n,), visit)))
    return tuple(model.loops.scatter(t.over, visit))


def backward(body) -> tuple:
    """The same statements in the opposite order; names stay ahead of what uses them."""
    names = tuple(s for s in body if isinstance(s, Declaration))
    others = [s for s in body if not isinstance(s, Declaration)]
    return (*names, *(reversed_one(s) for s in reversed(others)))


def reversed_one(s):
    if isinstance(s, For):
        return replace(s, body=backward(s.body), step=-s.step)
    return replace(s, body=backward(s.body)) if isinstance(s, Block) else s


# Classes of bonds of which no two meet

def class_functions(model) -> list:
    """smg_bond_classes, how many there are, 0 where bonds go one after the other; smg_each_of_class, a visit of all bonds of one."""
    found = bond_classes(model.spec)
    if not found:
        return [count_function(Return(ZERO)), visits("smg_each_of_class", (), OF_CLASS)]
    fits, number = fitting(model, sublattices(model.spec)), Return(whole(len(found)))
    alike = [list(group) for _, group in groupby(enumerate(found), lambda one: (one[1].effect, one[1].number))]
    return [count_function(*((If(fits, (number,)), Return(ZERO)) if fits else (number,))),
            visits("smg_each_of_class", tuple(of_bond(model, group) for group in alike), OF_CLASS)]


def count_function(*body) -> Function:
    return Function("int64_t", "smg_bond_classes", (COEFFICIENTS,), body, wanted=True)


def of_bond(model, group) -> If:
    """The classes of one bond: by the colour of its first site."""
    (start, one), here = group[0], Index("which")
    t = next(t for t in model.energies if t.derived.term.name == one.effect)
    cells = [Index(f"s{d}") for d in range(len(t.over.size))]
    inner = (model.loops.bond(t.over, one.number, cells, (visit_of(model, t),), one.first),)
    rule = sublattices(model.spec).colours if len(group) > 1 else one_colour(t.over)      # where the place alone decides, all cells have it
    lines = model.loops.cells_of_colour(t.over, rule, one.bond[one.first][0], inner)
    if len(group) == 1:
        return If((compare(here, "==", whole(start)),), lines)
    tests = (compare(here, ">=", whole(start)), compare(here, "<", whole(start + len(group))))
    return If(tests, (Let("colour", here - start if start else here), *lines))


class PairsOfSites(Part):
    """Slopes of functions of scalar products, for pair rotations."""
    name = "pairs"

    def made(self, model, low):
        return pair_kernels(model, low) if model.method.splitting == "pairs" else None

    def functions(self, model):
        return pair_functions(model)
