"""A sympy expression as a formula of a spec, node by node; what has no counterpart there is refused."""
from __future__ import annotations

import sympy

from ..errors import UsageError
from ..language import limits
from ..read.names import FUNCTIONS, UNRESERVED
from .vectors import Vector

CALLED = {sympy.Abs: "abs", sympy.floor: "floor", sympy.Mod: "mod", sympy.exp: "exp", sympy.log: "log", sympy.sin: "sin", sympy.cos: "cos",
          sympy.tan: "tan", sympy.asin: "asin", sympy.acos: "acos", sympy.atan: "atan", sympy.atan2: "atan2", sympy.sinh: "sinh",
          sympy.cosh: "cosh", sympy.tanh: "tanh"}
COMPARED = {sympy.Gt: ">", sympy.Ge: ">=", sympy.Lt: "<", sympy.Le: "<=", sympy.Eq: "==", sympy.Ne: "!="}
JOINED = {sympy.And: "and", sympy.Or: "or"}
PAIRED = {sympy.Min: "min", sympy.Max: "max"}
SUM, PRODUCT, POWER, ATOM = range(4)        # how tightly a text binds


def formula(value) -> str:
    """The text of a formula: one that is a text already, a number, a Vector, or an expression of sympy. Raises UsageError."""
    if isinstance(value, str):
        return value
    return text(value.value if isinstance(value, Vector) else expression(value))


def expression(value):
    """A number or expression of sympy; texts are never evaluated. Raises UsageError."""
    try:
        return sympy.sympify(value, strict=True)
    except sympy.SympifyError:
        raise UsageError(f"a {type(value).__name__} is not a formula: {str(value)[:80]}") from None


def text(e, least: int = SUM) -> str:
    """`e`, in parentheses where it binds less than `least`."""
    said, binds = written(e)
    return said if binds >= least else f"({said})"


def written(e) -> tuple[str, int]:
    """(text, how tightly it binds) of one node."""
    for kind, write in NODES:
        if isinstance(e, kind):
            return write(e)
    raise UsageError(f"`{type(e).__name__}` of sympy has no counterpart in the formulas of a spec: {str(e)[:80]}")


def symbol(e):
    return e.name, ATOM


def integer(e):
    return digits(e.p), ATOM if e.p >= 0 else SUM


def ratio(e):
    return f"{digits(e.p)}/{digits(e.q)}", PRODUCT if e.p > 0 else SUM


def digits(n: int) -> str:
    """An integer; beyond those that specs have, the nearest double. Raises UsageError where there is none."""
    if abs(n) <= limits.INTEGER:
        return str(n)
    try:
        return repr(float(n))
    except OverflowError:
        raise UsageError(f"an integer of {len(str(abs(n)))} digits exceeds the largest number allowed") from None


def real(e):
    """The shortest text of the nearest double."""
    value = float(e)
    if value != value or abs(value) == float("inf"):
        raise UsageError(f"{e} is not a finite number")
    return repr(value), ATOM if value >= 0 else SUM


def add(e):
    first, *others = e.as_ordered_terms()
    return text(first) + "".join(signed(other) for other in others), SUM


def signed(term) -> str:
    """A term behind others, with its sign before it."""
    return f" - {text(-term, PRODUCT)}" if term.could_extract_minus_sign() else f" + {text(term, PRODUCT)}"


def multiply(e):
    if e.could_extract_minus_sign():
        return f"-{text(-e, PRODUCT)}", SUM
    above, below = sympy.fraction(e, exact=True)
    factors = "*".join(text(f, POWER) for f in above.as_ordered_factors())
    return factors + "".join(f"/{text(f, POWER)}" for f in below.as_ordered_factors() if f != 1), PRODUCT


def power(e):
    if e.exp == sympy.Rational(1, 2):
        return f"sqrt({text(e.base)})", ATOM
    if e.exp.is_number and e.exp.is_negative:
        return f"1/{text(sympy.Pow(e.base, -e.exp), POWER)}", PRODUCT
    return f"{text(e.base, ATOM)}^{text(e.exp, ATOM)}", POWER


def call(name: str, arguments):
    return f"{name}({', '.join(map(text, arguments))})", ATOM


def applied(e):
    """A function that sympy does not know: one of the language."""
    name = e.func.__name__
    if name not in FUNCTIONS | UNRESERVED:
        raise UsageError(f"specs have no function `{name}`; there are: {', '.join(sorted(FUNCTIONS | UNRESERVED))}")
    return call(name, e.args)


def several(e):
    """min and max of specs take two arguments."""
    name, (first, *others) = PAIRED[e.func], e.args
    said = text(first)
    for other in others:
        said = f"{name}({said}, {text(other)})"
    return said, ATOM


def pieces(e):
    """if(c, a, if(..)); what holds last must hold everywhere."""
    *first, (last, always) = e.args
    if always is not sympy.true:
        raise UsageError("a Piecewise must end with a piece (value, True)")
    said = text(last)
    for value, condition in reversed(first):
        said = f"if({text(condition)}, {text(value)}, {said})"
    return said, ATOM


def compared(e):
    return f"({text(e.lhs)} {COMPARED[e.func]} {text(e.rhs)})", ATOM


def joined(e):
    return f"({f' {JOINED[e.func]} '.join(text(a) for a in e.args)})", ATOM


def opposite(e):
    return f"(not {text(e.args[0])})", ATOM


NODES = (
    (sympy.Symbol, symbol), (sympy.Integer, integer), (sympy.Rational, ratio), (sympy.Float, real), (type(sympy.pi), lambda e: ("pi", ATOM)),
    (type(sympy.E), lambda e: ("exp(1)", ATOM)), (sympy.Add, add), (sympy.Mul, multiply), (sympy.Pow, power), (sympy.sign, lambda e: sign(e.args[0])),
    *((kind, lambda e, name=name: call(name, e.args)) for kind, name in CALLED.items()), (tuple(PAIRED), several), (sympy.Piecewise, pieces),
    (tuple(COMPARED), compared), (tuple(JOINED), joined), (sympy.Not, opposite), (sympy.core.function.AppliedUndef, applied))


def sign(a):
    return f"if({text(a)} > 0, 1, if({text(a)} < 0, -1, 0))", ATOM
