"""Derivation, orbit by orbit: differentiate the one representative term, never the sum.

A term e(a, b, ..) of an effect depends on the vectors of a few slots (the sites that its index
family binds). Its gradient de/da and Hessian blocks d2e/da db are all that any method needs:
the sum over the index family is a loop in the generated C.
"""
from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...errors import UsageError
from ...language.expr import Elem, Expr, Idx, Num, Op, Par, Spin, Time, Weight, slots_of
from ...language.spec import Term
from .parts import SCALAR, Parts, TooLarge, Whole
from .pieces import chosen


class absolute(sp.Function):
    """abs(x), with the derivative sign(x) and no delta at 0."""
    is_real = True

    @classmethod
    def eval(cls, x):
        return abs(x) if x.is_Number else None

    def fdiff(self, argindex=1):
        return signum(self.args[0])


class signum(sp.Function):
    """The sign of x; locally constant."""
    is_real = True

    @classmethod
    def eval(cls, x):
        return sp.sign(x) if x.is_Number else None

    def fdiff(self, argindex=1):
        return sp.S.Zero


class floor_(sp.Function):
    """The floor of x; locally constant."""
    is_real = True

    @classmethod
    def eval(cls, x):
        return sp.floor(x) if x.is_Number else None

    def fdiff(self, argindex=1):
        return sp.S.Zero


class power(sp.Function):
    """x^p for an exponent that is no number, or where sympy would go through complex numbers; its
    derivative p x^(p-1) has no 0/0 at x = 0."""
    is_real = True

    def fdiff(self, argindex=1):
        x, p = self.args
        if argindex == 1:
            return p * power(x, p - 1)
        return sp.log(x) * power(x, p)


class lesser(sp.Function):
    """min(a, b), differentiated branch by branch."""
    is_real = True

    @classmethod
    def eval(cls, a, b):
        return min(a, b) if a.is_Number and b.is_Number else None

    def _eval_derivative(self, s):
        a, b = self.args
        return chosen(a <= b, sp.diff(a, s), sp.diff(b, s))


class greater(sp.Function):
    """max(a, b), likewise."""
    is_real = True

    @classmethod
    def eval(cls, a, b):
        return max(a, b) if a.is_Number and b.is_Number else None

    def _eval_derivative(self, s):
        a, b = self.args
        return chosen(a >= b, sp.diff(a, s), sp.diff(b, s))


@dataclass(frozen=True)
class Derived:
    """A term with its derivatives.

    slots: the distinct sites (family, slot) it depends on, in order of appearance;
    vectors[k]: the three symbols of slot k; gradient[k]: de/d(slot k), three expressions;
    hessian[k, l]: 3x3 matrix d2e/d(slot k)d(slot l), only the non-zero blocks;
    leaves: symbol name -> the expression node (parameter, entry, index, ..) it stands for;
    parts: symbol -> expression of each part of a large formula, in order of definition.
    """
    term: Term
    slots: tuple
    vectors: tuple
    value: sp.Expr
    gradient: tuple
    hessian: dict
    leaves: dict
    parts: dict


def switched(d: Derived) -> set:
    """The components of vectors on which a condition, a floor or a sign in the gradient depends: there the gradient jumps, which
    no second derivative tells."""
    behind = {}
    for s, e in d.parts.items():
        behind[s] = set().union(*(behind.get(x, {x}) for x in e.free_symbols))
    nodes = {node for e in (*(x for row in d.gradient for x in row), *d.parts.values())
             for node in e.atoms(chosen, sp.sign, floor_, signum, lesser, greater)}
    found = set().union(*(behind.get(x, {x}) for node in nodes for x in node.free_symbols))
    return found & {x for v in d.vectors for x in v}


class NoRealValue(UsageError):
    """A formula without a finite real value, whatever the state."""

    def __init__(self, where: str = "a formula"):
        super().__init__(f"{where} has no finite real value, whatever the state: it divides by what is always zero, or takes a "
                         "root, a logarithm or a power of what never has one; write it so that it is defined, with "
                         "`max` or `if` around what is not")


UNREAL = (sp.I, sp.nan, sp.zoo, sp.oo, -sp.oo)


def is_real(e) -> bool:
    """Is e free of imaginary and infinite numbers?"""
    return not e.has(*UNREAL)


def raised(base, exponent):
    """base^exponent; sympy would write sqrt(-x^2) as I |x|, and the square root of a square as a function of
    complex numbers, where a real program has a number or none."""
    e = base ** exponent
    if is_real(e):
        return e.replace(sp.Abs, absolute)
    if base.is_number:
        raise NoRealValue()
    return power(base, exponent)


def exact(exponent):
    """0.5 is the half and 2.0 is two: roots and products, no `pow`."""
    twice = 2 * exponent
    return sp.Rational(int(twice), 2) if exponent.is_Float and twice == int(twice) else exponent


_PLAIN = {
    "sqrt": lambda a: raised(a, sp.S.Half), "exp": sp.exp, "log": sp.log, "sin": sp.sin, "cos": sp.cos, "tan": sp.tan,
    "asin": sp.asin, "acos": sp.acos, "atan": sp.atan, "sinh": sp.sinh, "cosh": sp.cosh,
    "tanh": sp.tanh, "atan2": sp.atan2, "abs": absolute, "floor": floor_, "min": lesser, "max": greater,
    "<": sp.StrictLessThan, "<=": sp.LessThan, ">": sp.StrictGreaterThan, ">=": sp.GreaterThan,
    "==": sp.Eq, "!=": sp.Ne, "and": sp.And, "or": sp.Or, "not": sp.Not,
}


class Algebra:
    """Turns resolved expressions into sympy; vectors become 3-tuples of scalars."""

    def __init__(self, slots: tuple, parts: Parts | Whole):
        self.parts = parts
        self.vectors = {s: sp.symbols(f"v{k}x v{k}y v{k}z", real=True) for k, s in enumerate(slots)}
        self.leaves: dict[str, Expr] = {}

    def leaf(self, name: str, node: Expr):
        self.leaves[name] = node
        return sp.Symbol(name, real=True)

    def of(self, e: Expr):
        """Scalar -> sympy expression; vector -> tuple of three; truth value -> sympy Boolean."""
        if isinstance(e, Num):
            return sp.Integer(e.value) if isinstance(e.value, int) else sp.Float(e.value)
        if isinstance(e, Spin):
            return self.vectors[e.family, e.slot]
        if isinstance(e, Op):
            value = self.apply(e.op, [self.of(a) for a in e.args])
            return tuple(map(self.checked, value)) if isinstance(value, tuple) else self.checked(value)
        return self.leaf(leaf_name(e), e)

    def checked(self, e):
        """A real number, by its name where it is large."""
        if not is_real(e):
            raise NoRealValue()
        return self.parts.held(e)

    def apply(self, op: str, args: list):
        if op in _VECTOR:
            return _VECTOR[op](*args)
        if op in _PLAIN:
            return _PLAIN[op](*args)
        return getattr(self, _SCALAR[op])(*args)

    def add(self, a, b):
        return tuple(x + y for x, y in zip(a, b)) if isinstance(a, tuple) else a + b

    def subtract(self, a, b):
        return tuple(x - y for x, y in zip(a, b)) if isinstance(a, tuple) else a - b

    def negate(self, a):
        return tuple(-x for x in a) if isinstance(a, tuple) else -a

    def multiply(self, a, b):
        if isinstance(a, tuple):
            a, b = b, a
        return tuple(a * x for x in b) if isinstance(b, tuple) else a * b

    def divide(self, a, b):
        return tuple(x / b for x in a) if isinstance(a, tuple) else a / b

    def raise_to(self, a, b):
        return raised(a, exact(b)) if b.is_number else power(a, b)

    def modulo(self, a, b):
        return a - b * floor_(self.checked(a / b))

    def choose(self, test, a, b):
        if isinstance(a, tuple):
            return tuple(chosen(test, x, y) for x, y in zip(a, b))
        return chosen(test, a, b)


_SCALAR = {"+": "add", "-": "subtract", "neg": "negate", "*": "multiply", "/": "divide",
           "^": "raise_to", "mod": "modulo", "if": "choose"}


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


_VECTOR = {"dot": dot, "cross": cross, "triple": lambda a, b, c: dot(a, cross(b, c)),
           "norm": lambda a: raised(dot(a, a), sp.S.Half), "vec": lambda *a: tuple(a),
           "x": lambda a: a[0], "y": lambda a: a[1], "z": lambda a: a[2]}


def leaf_name(e: Expr) -> str:
    """A symbol name that says what it stands for; equal nodes get equal names."""
    if isinstance(e, Par):
        return f"p.{e.name}"
    if isinstance(e, Time):
        return "t"
    if isinstance(e, Idx):
        return f"i.{e.name}"
    if isinstance(e, Weight):
        return f"e.{e.name}"
    return f"a.{e.name}[{index_text(e.index)}]"


def index_text(e: Expr) -> str:
    """Canonical text of an integer index expression."""
    if isinstance(e, Num):
        return str(e.value)
    if isinstance(e, Op):
        return f"({e.op} {' '.join(index_text(a) for a in e.args)})"
    return leaf_name(e)


def hessian_blocks(gradient: tuple, vectors: tuple, parts) -> dict:
    """Non-zero 3x3 blocks d2e/da db, by differentiating the gradient."""
    blocks = {}
    for k, row in enumerate(gradient):
        for l, column in enumerate(vectors):
            block = sp.Matrix(3, 3, lambda a, b: parts.slope(row[a], column[b]))
            if any(entry != 0 for entry in block):
                blocks[k, l] = block
    return blocks


def derive(term: Term, with_derivatives: bool = True) -> Derived:
    """Gradient and Hessian blocks of the representative term of one effect. Raises UsageError where it has none."""
    try:
        try:
            return _derived(term, Whole(), with_derivatives)
        except TooLarge:
            return _derived(term, Parts(), with_derivatives)
    except NoRealValue:
        raise NoRealValue(f"the formula of `{term.name}`, or its derivative,") from None


def _derived(term: Term, parts, with_derivatives: bool) -> Derived:
    slots = slots_of(term.value)
    algebra = Algebra(slots, parts)
    value = algebra.of(term.value)
    vectors = tuple(algebra.vectors[s] for s in slots)
    gradient = tuple(tuple(parts.slope(value, x) for x in v) for v in vectors if with_derivatives)
    hessian = hessian_blocks(gradient, vectors, parts)
    if not all(map(is_real, [value, *parts.of.values(), *(x for row in gradient for x in row), *hessian.values()])):
        raise NoRealValue()
    return Derived(term, slots, vectors, value, gradient, hessian, algebra.leaves, parts.of)


def scalar(e: Expr):
    """A formula without vectors of the state -> (sympy expression, leaves). Raises UsageError where it is too long."""
    algebra = Algebra((), Whole(SCALAR))
    try:
        return algebra.of(e), algebra.leaves
    except TooLarge:
        raise UsageError(f"a formula of parameters takes more than {SCALAR[0]} operations and operands when its vectors are "
                         "written out in components: give its value as a parameter") from None
