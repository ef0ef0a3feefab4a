"""Kernels as functions: value, gradient and Hessian of one representative term.

Every kernel takes the coefficients, the bound indices, the edge weights and the vectors of its
slots; gradients and Hessians add into their outputs, so that sums need no other code.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

import sympy as sp

from ...language.spec import Graph, Lattice, Term
from ..derive.derivatives import Derived, derive, derive_field
from .code import Add, Argument, Call, Component, Function, Name, Return
from .integers import Index
from .lowering import Kernel, Lowering

DIRECTION = sp.symbols("dx dy dz", real=True)
COEFFICIENTS = Argument("const smg_coefficients *", "c")


@dataclass(frozen=True)
class TermKernels:
    """One term of the model: its derivatives and the functions of it.

    prefix: common beginning of the function names; operations: of value and gradient.
    """
    derived: Derived
    prefix: str
    functions: tuple = ()
    operations: tuple = ()

    @property
    def over(self):
        return self.derived.term.over

    @property
    def slots(self):
        return self.derived.slots

    @property
    def called(self) -> str:
        """Its effects, for messages."""
        return " and ".join(f"`{name}`" for name in self.derived.joined or (self.derived.term.name,))

    def weights(self):
        return [f"weight_{c}" for c, _ in self.over.columns] if isinstance(self.over, (Graph, Lattice)) else []

    def call(self, what: str, vectors, *outputs) -> Call:
        """`prefix_what(c, i, j, weights, vectors, outputs)`."""
        return Call(f"{self.prefix}_{what}", (*self.common(), *vectors, *outputs))

    def common(self) -> tuple:
        return (Name("c"), *map(Index, self.over.bound), *map(Name, self.weights()))

    def arguments(self) -> tuple:
        """Those that all functions of the term begin with."""
        return (COEFFICIENTS, *(Argument("int64_t", i) for i in self.over.bound), *(Argument("smg_real", w) for w in self.weights()),
                *(Argument("const smg_real *", f"v{k}") for k in range(len(self.slots))))

    def outputs(self) -> tuple:
        return tuple(Argument("smg_real *", f"g{k}") for k in range(len(self.slots)))


def term_kernels(low: Lowering, term: Term, role: str, with_derivatives: bool = True) -> TermKernels:
    """Value, gradient and Hessian functions of one effect (role 'effect') or observable ('observe')."""
    return kernels_of(low, derive(term, with_derivatives), role, with_derivatives)


def kernels_of(low: Lowering, d: Derived, role: str, with_derivatives: bool = True) -> TermKernels:
    """The same of what is derived already."""
    value = value_kernels(low, d, role)
    if not with_derivatives:
        return value
    rest = motion_kernels(low, d, role)
    return replace(rest, functions=(*value.functions, *rest.functions), operations=(value.operations[0], rest.operations[1]))


def value_kernels(low: Lowering, d: Derived, role: str) -> TermKernels:
    """The value alone."""
    bare = TermKernels(d, f"{role}_{d.term.name}")
    value = low.kernel([d.value], d.leaves, d.parts)
    return replace(bare, functions=(value_function(bare, value),), operations=(value.operations,))


def motion_kernels(low: Lowering, d: Derived, role: str) -> TermKernels:
    """Gradient and Hessian."""
    bare = TermKernels(d, f"{role}_{d.term.name}")
    gradient = low.kernel([x for row in d.gradient for x in row], d.leaves, d.parts)
    blocks = {pair: f for pair in d.hessian if (f := hessian_function(low, bare, pair)).body}       # without those that a fixed strength of 0 empties
    return replace(bare, derived=replace(d, hessian={pair: d.hessian[pair] for pair in blocks}), functions=(gradient_function(bare, gradient), *blocks.values()),
                   operations=(0, gradient.operations))


def field_kernels(low: Lowering, torque: Term, slots: tuple, field, role: str = "torque") -> TermKernels:
    """The field of a torque in the place of a gradient, and its derivatives; it has no value."""
    bare = TermKernels(derive_field(torque, slots, field), f"{role}_{torque.name}")
    d = bare.derived
    gradient = low.kernel([x for row in d.gradient for x in row], d.leaves, d.parts)
    return replace(bare, functions=(gradient_function(bare, gradient), *(hessian_function(low, bare, pair) for pair in d.hessian)),
                   operations=(0, gradient.operations))


def value_function(term: TermKernels, kernel: Kernel) -> Function:
    return Function("smg_real", f"{term.prefix}_value", term.arguments(), (*kernel.values, Return(kernel.results[0])))


def gradient_function(term: TermKernels, kernel: Kernel, name: str = "", **how) -> Function:
    """g_k += de/d(slot k)."""
    targets = [Component(f"g{k}", a) for k in range(len(term.slots)) for a in range(3)]
    return Function("void", name or f"{term.prefix}_gradient", (*term.arguments(), *term.outputs()),
                    (*kernel.values, *additions(targets, kernel.results)), **how)


def hessian_function(low: Lowering, term: TermKernels, pair) -> Function:
    """y += B d for the block B = d2e/d(slot k)d(slot l)."""
    k, l = pair
    product = [sum(term.derived.hessian[pair][a, b] * DIRECTION[b] for b in range(3)) for a in range(3)]
    kernel = low.kernel(product, term.derived.leaves, term.derived.parts)
    arguments = (*term.arguments(), Argument("const smg_real *", "d"), Argument("smg_real *", "y"))
    return Function("void", f"{term.prefix}_hessian_{k}{l}", arguments,
                    (*kernel.values, *additions([Component("y", a) for a in range(3)], kernel.results)))


def additions(targets, results) -> tuple:
    """`target += result`, without the zeros."""
    return tuple(Add(target, result) for target, result in zip(targets, results) if not result.is_number(0))
