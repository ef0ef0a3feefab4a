"""Constants of formulas that are no simple numbers, such as cos(0.3) or exp(1/2): symbols to the algebra, which have values.

The name of such a symbol ends in its value. What is proved holds for any values; only its text and the numbers made of it need these.
"""
from __future__ import annotations

import math

import sympy as sp

from .formulas import NotDecided

_VALUES = {
    "inverse": lambda a: 1 / a, "sqrt": math.sqrt, "exp": math.exp, "log": math.log, "sin": math.sin, "cos": math.cos, "sinh": math.sinh,
    "cosh": math.cosh, "atan": math.atan, "asin": math.asin, "acos": math.acos, "atan2": math.atan2, "power": math.pow,
    "condition": lambda a: float(a < 0), "equality": lambda a: float(a == 0), "floor": math.floor,
}


def symbol(algebra, g: int) -> sp.Symbol:
    """Of a generator that depends on numbers alone. Raises NotDecided where it has no value."""
    try:
        return sp.Symbol(f"c{g}={_value(algebra, g)!r}", real=True)
    except (KeyError, ValueError, ZeroDivisionError):
        raise NotDecided("a constant has no value") from None


def real(x) -> float:
    """The number that an expression in such symbols is."""
    x = sp.sympify(x)
    return float(x.xreplace({s: sp.Float(float(s.name.partition("=")[2])) for s in x.free_symbols}))


def _value(algebra, g: int) -> float:
    one = algebra.table[g]
    if one.kind == "leaf":
        return {("pi",): math.pi}[one.key]
    return float(_VALUES[one.kind](*(_sum(algebra, p) for p in one.arguments)))


def _sum(algebra, p: dict) -> float:
    return math.fsum(float(c) * math.prod(_value(algebra, g) ** e for g, e in m) for m, c in p.items())
