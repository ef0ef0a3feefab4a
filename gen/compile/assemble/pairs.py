"""Bonds one after the other, and back: visits of all pairs of sites that a term f(w_i.w_j) joins, with f'."""
from __future__ import annotations

from dataclasses import replace

import sympy as sp

from ...language.spec import Lattice
from ..lower.code import Argument, Block, Call, Declaration, For, Function, Name, Return, tidy
from ..lower.kernels import COEFFICIENTS, TermKernels
from ..lower.lowering import Lowering
from ..plan.splitting import of_the_product

PRODUCT = sp.Symbol("product", real=True)       # w_i.w_j
VISIT = (COEFFICIENTS, Argument("const smg_real *", "all"), Argument("void *", "context"),
         Argument("void", "visit", "void *context, int64_t i, int64_t j, smg_real slope"))


def pair_kernels(model, low: Lowering) -> dict:
    """{effect: function f'(w_i.w_j)}."""
    return {t.prefix: slope_kernel(low, t) for t in model.effects if t.slots}


def slope_kernel(low: Lowering, t: TermKernels) -> Function:
    slope = sp.diff(of_the_product(t.derived, PRODUCT), PRODUCT)
    kernel = low.kernel([slope], t.derived.leaves)
    given = (*(a for a in t.arguments() if a.name not in ("v0", "v1")), Argument("smg_real", PRODUCT.name))
    return Function("smg_real", f"{t.prefix}_slope", given, (*kernel.values, Return(kernel.results[0])))


def pair_functions(model) -> list:
    """The kernels, and what runtime/method/smg_pair_rotations.h asks of a model."""
    if model.pairs is None:
        return []
    there = tuple(line for t in model.effects if t.slots for line in bonds(model, t))
    return [*model.pairs.values(), visits("smg_each_pair", tidy(there)), visits("smg_each_pair_back", backward(tidy(there)))]


def visits(name: str, body) -> Function:
    """Inlined, so that the call of `visit` is, too."""
    return Function("void", name, VISIT, body, wanted=True, inlined="always")


def bonds(model, t: TermKernels) -> tuple:
    """All bonds of an effect; on a lattice those of one direction after those of another."""
    a, b = t.slots
    product = Call("smg_dot", (model.vector("all", a), model.vector("all", b)))
    visit = Call("visit", (Name("context"), model.site(a), model.site(b), Call(f"{t.prefix}_slope", (*t.common(), product))))
    overs = [replace(t.over, bonds=(bond,)) for bond in t.over.bonds] if isinstance(t.over, Lattice) else [t.over]
    return tuple(line for over in overs for line in model.loops.scatter(over, (visit,)))


def backward(body) -> tuple:
    """The same statements in the opposite order; names stay ahead of what uses them."""
    names = tuple(s for s in body if isinstance(s, Declaration))
    others = [s for s in body if not isinstance(s, Declaration)]
    return (*names, *(reversed_one(s) for s in reversed(others)))


def reversed_one(s):
    if isinstance(s, For):
        return replace(s, body=backward(s.body), step=-s.step)
    return replace(s, body=backward(s.body)) if isinstance(s, Block) else s
