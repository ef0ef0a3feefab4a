"""Kernels as C functions: value, gradient and Hessian of one representative term.

Every kernel takes the coefficients, the bound indices, the edge weights and the vectors of its
slots; gradients and Hessians add into their outputs, so that sums need no other code.
"""
from __future__ import annotations

import re
from dataclasses import dataclass

import sympy as sp

from ...language.spec import Graph, Term
from ..derive.derivatives import Derived, derive
from .loops import indent
from .lowering import Lowering

DIRECTION = sp.symbols("dx dy dz", real=True)
PART = re.compile(r"const \w+ (x\d+) = ")
NAME = re.compile(r"x\d+")


@dataclass(frozen=True)
class TermKernels:
    """One term of the model: its derivatives and the C text of its functions.

    prefix: common beginning of the function names; text: name -> C text; operations: of value and gradient.
    """
    derived: Derived
    prefix: str
    text: dict
    operations: tuple

    @property
    def over(self):
        return self.derived.term.over

    @property
    def slots(self):
        return self.derived.slots

    def weights(self):
        return [f"weight_{c}" for c, _ in self.over.columns] if isinstance(self.over, Graph) else []

    def call(self, what: str, vectors, *outputs) -> str:
        """`prefix_what(c, i, j, weights, vectors, outputs)`."""
        return f"{self.prefix}_{what}({', '.join([*self.common(), *vectors, *outputs])})"

    def common(self):
        return ["c", *self.over.bound, *self.weights()]


def function(head: str, arguments, body, unused):
    """A static inline function; arguments that the body never reads are said to be unused."""
    body = read(body)
    text = "\n".join(body)
    spare = [f"(void){name};" for name in unused if not mentions(text, name)]
    return "\n".join([f"static inline {head}({', '.join(arguments)}) {{", *indent(spare + body), "}"])


def read(body) -> list:
    """The lines without the common parts x0, x1, .. that nothing reads: what they stood in has cancelled out."""
    kept, names = [], set()
    for line in reversed(list(body)):
        given = PART.match(line)
        if not given or given.group(1) in names:
            kept.append(line)
            names |= set(NAME.findall(line))
    return kept[::-1]


def mentions(text: str, name: str) -> bool:
    return re.search(rf"(?<![A-Za-z0-9_]){re.escape(name)}(?![A-Za-z0-9_])", text) is not None


def term_kernels(low: Lowering, term: Term, role: str, with_derivatives: bool = True) -> TermKernels:
    """Value, gradient and Hessian functions of one effect (role 'effect') or observable ('observe')."""
    d = derive(term, with_derivatives)
    kernels = TermKernels(d, f"{role}_{term.name}", {}, ())
    value = low.kernel([d.value], d.leaves, d.parts)
    text = {f"{kernels.prefix}_value": value_function(low, kernels, value)}
    operations = [value.operations]
    if with_derivatives:
        gradient = low.kernel([x for row in d.gradient for x in row], d.leaves, d.parts)
        text[f"{kernels.prefix}_gradient"] = gradient_function(low, kernels, gradient)
        text |= {f"{kernels.prefix}_hessian_{k}{l}": hessian_function(low, kernels, (k, l)) for k, l in d.hessian}
        operations.append(gradient.operations)
    return TermKernels(d, kernels.prefix, text, tuple(operations))


def arguments(low: Lowering, kernels: TermKernels):
    names = kernels.common() + [f"v{k}" for k in range(len(kernels.slots))]
    declared = (["const smg_coefficients *c"] + [f"int64_t {i}" for i in kernels.over.bound]
                + [f"smg_real {w}" for w in kernels.weights()]
                + [f"const smg_real *v{k}" for k in range(len(kernels.slots))])
    return declared, names


def value_function(low, kernels, kernel):
    declared, names = arguments(low, kernels)
    body = [*kernel.lines, f"return {kernel.results[0]};"]
    return function(f"smg_real {kernels.prefix}_value", declared, body, names)


def gradient_function(low, kernels, kernel):
    declared, names = arguments(low, kernels)
    outputs = [f"g{k}" for k in range(len(kernels.slots))]
    targets = [f"{g}[{a}]" for g in outputs for a in range(3)]
    body = list(kernel.lines) + additions(targets, kernel.results)
    return function(f"void {kernels.prefix}_gradient", declared + [f"smg_real *{g}" for g in outputs],
                    body, names + outputs)


def hessian_function(low, kernels, pair):
    """y += B d for the block B = d2e/d(slot k)d(slot l)."""
    k, l = pair
    product = [sum(kernels.derived.hessian[pair][a, b] * DIRECTION[b] for b in range(3)) for a in range(3)]
    kernel = low.kernel(product, kernels.derived.leaves, kernels.derived.parts)
    declared, names = arguments(low, kernels)
    body = list(kernel.lines) + additions([f"y[{a}]" for a in range(3)], kernel.results)
    return function(f"void {kernels.prefix}_hessian_{k}{l}", declared + ["const smg_real *d", "smg_real *y"],
                    body, names + ["d", "y"])


def additions(targets, results):
    """`target += result`, without the zeros, and with minus signs where they belong."""
    lines = []
    for target, result in zip(targets, results):
        if result in ("0.0", "0"):
            continue
        if result.startswith("-") and " " not in result:
            lines.append(f"{target} -= {result[1:]};")
        else:
            lines.append(f"{target} += {result};")
    return lines
