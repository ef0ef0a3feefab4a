"""Spherical harmonics by their coefficients: `orthonormal_harmonics(a, w[i])` is written out as a polynomial of the vector.

    sum over l = 0 .. L and m = -l .. l of a[l^2 + l + m] Y_lm(w),     L from the length (L + 1)^2 of a

For each order m the polynomials in z are summed over l first, so that their coefficients depend on a alone.
"""
from __future__ import annotations

from math import comb, isqrt

from ..language import codes, limits
from ..language.expr import Elem, Num, Op
from ..language.harmonics import derived, norm
from .scope import Typed
from .syntax import Name

def op(name: str, *args: Typed) -> Typed:
    return Typed(Op(name, tuple(a.expr for a in args)), "s", 1 + sum(a.nodes for a in args), 1 + max(a.depth for a in args))


def total(terms: list) -> Typed:
    """Their sum, as a tree that is as flat as it can be."""
    while len(terms) > 1:
        terms = [op("+", *terms[k:k + 2]) if k + 1 < len(terms) else terms[k] for k in range(0, len(terms), 2)]
    return terms[0]


def number(x) -> Typed:
    return Typed(Num(x), "s", value=float(x))


def scaled(factor, a: Typed) -> Typed:
    return a if factor == 1 else op("neg", a) if factor == -1 else op("*", number(factor), a)


def turned(x: Typed, y: Typed, m: int) -> tuple:
    """Real and imaginary part of (x + i y)^m, m >= 1."""
    def power(a, n):
        return [op("^", a, number(n)) if n > 1 else a] if n else []
    parts = ([], [])
    for k in range(m + 1):
        factors = power(x, m - k) + power(y, k)
        parts[k % 2].append(scaled((-1) ** (k // 2) * comb(m, k), op("*", *factors) if len(factors) == 2 else factors[0]))
    return total(parts[0]), total(parts[1])


def polynomial(coefficients: list, z: Typed) -> Typed:
    """By Horner's rule, from the lowest power on."""
    found = coefficients[-1]
    for c in coefficients[-2::-1]:
        found = op("+", c, op("*", z, found))
    return found


def of_order(function: str, entry, degree: int, m: int, z: Typed) -> Typed:
    """sum over l of a_lm N_lm Q_l|m|(z)."""
    terms = {power: [] for power in range(degree - abs(m) + 1)}
    for l in range(abs(m), degree + 1):
        for power, c in derived(l, abs(m)).items():
            terms[power].append(scaled(c * norm(function, l, abs(m)), entry(l * l + l + m)))
    return polynomial([total(of) for of in terms.values()], z)


def written_out(function: str, entry, degree: int, w: Typed) -> Typed:
    x, y, z = (Typed(Op(axis, (w.expr,)), "s", w.nodes + 1, w.depth + 1) for axis in "xyz")
    terms = [of_order(function, entry, degree, 0, z)]
    for m in range(1, degree + 1):
        terms += [op("*", part, of_order(function, entry, degree, sign * m, z)) for sign, part in zip((1, -1), turned(x, y, m))]
    return total(terms)


def harmonics(resolver, node) -> Typed:
    """`NAME(a, w)` of an array and a vector."""
    if len(node.args) != 2:
        resolver.fail(codes.ARITY, node.head, f"`{node.name}` takes 2 arguments, not {len(node.args)}",
                      f"its arguments are the array of coefficients and a vector: `{node.name}(a, w[i])`")
    degree = degree_of(resolver, node)
    w = resolver.resolve(node.args[1])
    if w.kind != "v":
        resolver.fail(codes.KIND, node.args[1].span, f"`{node.name}` takes an array and a vector", f"such as `{node.name}({node.args[0].name}, w[i])`")
    name = node.args[0].name
    return written_out(node.name, lambda k: resolver.placed(Typed(Elem(name, Num(k)), "s", 2, 2), node.args[0]), degree, w)


def degree_of(resolver, node) -> int:
    """L of an array of (L + 1)^2 entries."""
    first, declared = node.args[0], resolver.scope.declared
    p = declared.parameters.get(first.name) if isinstance(first, Name) else None
    if p is None or p.kind != "array" or p.name in declared.vectors | declared.lists:
        if isinstance(first, Name) and p is None:
            resolver.resolve(first)
        resolver.fail(codes.KIND, first.span, f"`{node.name}` takes the name of an array of numbers as first argument", "such as `psi` of `psi = { file = \"psi.csv\", size = 16 }`")
    if not isinstance(p.size, Num):
        resolver.fail(codes.INTEGER, first.span, f"the size of `{p.name}` is a formula, but the degree of the harmonics must be a constant", "write its `size` as a number: 16 for degrees 0 to 3")
    degree = isqrt(p.size.value) - 1
    if (degree + 1) ** 2 != p.size.value or degree > limits.HARMONICS:
        resolver.fail(codes.COUNT, first.span, f"`{p.name}` has {p.size.value} entries; harmonics to degree L have (L + 1)^2",
                      f"1, 4, 9, .., at most {(limits.HARMONICS + 1) ** 2} for degree {limits.HARMONICS}; entry l^2 + l + m belongs to l and m")
    return degree
