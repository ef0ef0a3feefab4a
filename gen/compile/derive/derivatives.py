"""Derivation, orbit by orbit: differentiate the one representative term, never the sum.

A term e(a, b, ..) of an effect depends on the vectors of a few slots (the sites that its index
family binds). Its gradient de/da and Hessian blocks d2e/da db are all that any method needs:
the sum over the index family is a loop in the generated C.
"""
from __future__ import annotations

import functools
import operator
from dataclasses import dataclass

import sympy as sp

from ...errors import UsageError
from ...language.expr import Expr, Idx, Num, Op, Par, Spin, Time, Weight, is_draw, slots_of, walk
from ...language.spec import Term
from .parts import SCALAR, Parts, TooLarge, Whole
from .pieces import chosen
from .written import known, minus, negative, over, plus, times


class absolute(sp.Function):
    """abs(x), with the derivative sign(x) and no delta at 0. Its last argument: x as it is written, whose sign it is."""
    is_real = True

    @classmethod
    def eval(cls, x, *_):
        return abs(x) if x.is_Number else None

    def _eval_derivative(self, s):
        slope = sp.diff(self.args[0], s)
        return slope * signum(self.args[-1]) if slope != 0 else slope


class signum(sp.Function):
    """The sign of x; locally constant."""
    is_real = True

    @classmethod
    def eval(cls, x):
        return sp.sign(x) if x.is_Number else None

    def _eval_derivative(self, s):
        return sp.S.Zero


class floor_(sp.Function):
    """The floor of x; locally constant."""
    is_real = True

    @classmethod
    def eval(cls, x):
        return sp.floor(x) if x.is_Number else None

    def _eval_derivative(self, s):
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
    """min(a, b), differentiated branch by branch. Its last two arguments: a and b as they are written, which decide on the branch."""
    is_real = True

    @classmethod
    def eval(cls, a, b, *_):
        return min(a, b) if a.is_Number and b.is_Number else None

    def _eval_derivative(self, s):
        (a, b), (x, y) = self.args[:2], self.args[-2:]
        return chosen(x <= y, sp.diff(a, s), sp.diff(b, s))


class greater(sp.Function):
    """max(a, b), likewise."""
    is_real = True

    @classmethod
    def eval(cls, a, b, *_):
        return max(a, b) if a.is_Number and b.is_Number else None

    def _eval_derivative(self, s):
        (a, b), (x, y) = self.args[:2], self.args[-2:]
        return chosen(x >= y, sp.diff(a, s), sp.diff(b, s))


KINKED = (absolute, lesser, greater)


@dataclass(frozen=True)
class Derived:
    """A term with its derivatives.

    slots: the distinct sites (family, slot) it depends on, in order of appearance;
    vectors[k]: the three symbols of slot k; gradient[k]: de/d(slot k), three expressions;
    hessian[k, l]: 3x3 matrix d2e/d(slot k)d(slot l), only the non-zero blocks;
    leaves: symbol name -> the expression node (parameter, entry, index, ..) it stands for;
    parts: symbol -> expression of each part of a large formula, in order of definition;
    joined: the effects that it is a sum of, where they are several.
    pushed: of a torque the number of the slot that it moves: gradient[pushed] is its field, and the rest is 0.
    """
    term: Term
    slots: tuple
    vectors: tuple
    value: sp.Expr
    gradient: tuple
    hessian: dict
    leaves: dict
    parts: dict
    pushed: int | None = None
    joined: tuple = ()


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
        super().__init__(f"{where} has no finite real value for any state: it divides by zero, or takes a root, a logarithm or a power outside its domain; use `max` or `if` to stay inside the domain")


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
    "and": sp.And, "or": sp.Or, "not": sp.Not,
    "<": sp.StrictLessThan, "<=": sp.LessThan, ">": sp.StrictGreaterThan, ">=": sp.GreaterThan,
    "==": sp.Eq, "!=": sp.Ne,
}
JUMPS = {"floor", "<", "<=", ">", ">=", "==", "!="}      # what they look at is computed as it is written
KINKS = {"abs", "min", "max"}                           # whose derivatives jump


class Algebra:
    """Turns resolved expressions into sympy; vectors become 3-tuples of scalars. `written`: the same without rearrangement."""

    def __init__(self, slots: tuple, parts: Parts | Whole):
        self.parts = parts
        self.vectors = {s: sp.symbols(f"v{k}x v{k}y v{k}z", real=True) for k, s in enumerate(slots)}
        parts.variables = frozenset(x for v in self.vectors.values() for x in v)
        self.leaves: dict[str, Expr] = {}
        self.written = Written(self)

    def leaf(self, name: str, node: Expr):
        self.leaves[name] = node
        return sp.Symbol(name, real=True)

    def of(self, e: Expr):
        """Scalar -> sympy expression; vector -> tuple of three; truth value -> sympy Boolean."""
        if isinstance(e, Num):
            return sp.Integer(e.value) if isinstance(e.value, int) else sp.Float(e.value)
        if isinstance(e, Spin):
            return self.vectors[e.family, e.slot]
        if isinstance(e, Op) and e.op == "kept" and not any(isinstance(n, Idx) for n in walk(e)):
            return self.of(e.args[0])
        if isinstance(e, Op) and not is_draw(e):
            value = self.operation(e)
            return tuple(map(self.checked, value)) if isinstance(value, tuple) else self.checked(value)
        return self.leaf(leaf_name(e), e)

    def operation(self, e: Op):
        """Jumps look at what is written, kinks at both. A remainder without vectors is as it is written: a factor, multiplied into
        x - n floor(x/n), would leave the rounding of large terms, below 0 too."""
        if e.op == "mod" and not slots_of(e):
            return self.written.of(e)
        jumps = e.op in JUMPS or e.op == "atan2" and not slots_of(e)
        exact = [self.written.of(a) for a in e.args] if jumps or e.op in KINKS or e.op == "mod" else []
        given = exact if jumps else [self.of(a) for a in e.args]
        if e.op == "mod":
            return given[0] - given[1] * floor_(self.checked(self.written.divide(*exact)))
        return self.apply(e.op, given + exact if e.op in KINKS and given != exact else given)

    def checked(self, e):
        """A real number, by its name where it is large."""
        if not is_real(e):
            raise NoRealValue()
        return self.parts.held(e)

    def apply(self, op: str, args: list):
        if op in _VECTOR:
            return _VECTOR[op](self, *args)
        if op in _PLAIN:
            return _PLAIN[op](*args)
        return getattr(self, _SCALAR[op])(*args)

    plus, minus, times, over, negative = (staticmethod(f) for f in (operator.add, operator.sub, operator.mul, operator.truediv, operator.neg))

    def add(self, a, b):
        return tuple(map(self.plus, a, b)) if isinstance(a, tuple) else self.plus(a, b)

    def subtract(self, a, b):
        return tuple(map(self.minus, a, b)) if isinstance(a, tuple) else self.minus(a, b)

    def negate(self, a):
        return tuple(map(self.negative, a)) if isinstance(a, tuple) else self.negative(a)

    def multiply(self, a, b):
        if isinstance(a, tuple):
            a, b = b, a
        return tuple(self.times(a, x) for x in b) if isinstance(b, tuple) else self.times(a, b)

    def divide(self, a, b):
        return tuple(self.over(x, b) for x in a) if isinstance(a, tuple) else self.over(a, b)

    def raise_to(self, a, b):
        return raised(a, exact(b)) if b.is_number else power(a, b)

    def choose(self, test, a, b):
        if isinstance(a, tuple):
            return tuple(chosen(test, x, y) for x, y in zip(a, b))
        return chosen(test, a, b)

    def dot(self, a, b):
        first, *others = map(self.times, a, b)
        return functools.reduce(self.plus, others, first)

    def cross(self, a, b):
        return tuple(self.minus(self.times(a[i], b[j]), self.times(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1)))


class Written(Algebra):
    """The values of formulas, operation by operation as they are written."""
    plus, minus, times, over, negative = plus, minus, times, over, negative

    def __init__(self, plain: Algebra):
        self.parts, self.vectors, self.leaves = plain.parts, plain.vectors, plain.leaves
        self.done: dict = {}

    def of(self, e: Expr):
        """Each once: what one jump looks at another may look at too."""
        if id(e) not in self.done:
            self.done[id(e)] = super().of(e)
        return self.done[id(e)]

    def operation(self, e: Op):
        args = [self.of(a) for a in e.args]
        if e.op == "mod":
            return minus(args[0], times(args[1], floor_(self.checked(over(*args)))))
        return self.apply(e.op, args)

    def checked(self, e):
        return super().checked(known(e))


_SCALAR = {"+": "add", "-": "subtract", "neg": "negate", "*": "multiply", "/": "divide",
           "^": "raise_to", "if": "choose"}

_VECTOR = {"dot": Algebra.dot, "cross": Algebra.cross, "triple": lambda f, a, b, c: f.dot(a, f.cross(b, c)),
           "norm": lambda f, a: raised(f.dot(a, a), sp.S.Half), "vec": lambda _, *a: a,
           "x": lambda _, a: a[0], "y": lambda _, a: a[1], "z": lambda _, a: a[2]}


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
    if is_draw(e):
        return f"r.{e.op}({' '.join(map(index_text, e.args))})"
    return f"a.{e.name}[{index_text(e.index)}]"


def index_text(e: Expr) -> str:
    """Canonical text of an integer index expression."""
    if isinstance(e, Num):
        return str(e.value)
    if isinstance(e, Op) and not is_draw(e):
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
    return _by_parts(term, lambda parts: _derived(term, parts, with_derivatives))


def derive_field(torque: Term, slots: tuple, field: Expr) -> Derived:
    """A field, a formula in the vectors of `slots`, in the place of the gradient by the first of them, and its derivatives."""
    def derived(parts):
        algebra = Algebra(slots, parts)
        rows = (algebra.of(field), *[(sp.S.Zero,) * 3] * (len(slots) - 1))
        return _checked(torque, algebra, sp.S.Zero, rows, pushed=0)
    return _by_parts(torque, derived)


def _by_parts(term: Term, derived) -> Derived:
    """derived(parts) of a formula in one piece, or where that is too large by parts."""
    try:
        try:
            return derived(Whole())
        except TooLarge:
            return derived(Parts())
    except NoRealValue:
        raise NoRealValue(f"the formula of `{term.name}`, or its derivative,") from None


def _derived(term: Term, parts, with_derivatives: bool) -> Derived:
    algebra = Algebra(slots_of(term.value), parts)
    value = algebra.of(term.value)
    return _checked(term, algebra, value, tuple(tuple(parts.slope(value, x) for x in v) for v in algebra.vectors.values() if with_derivatives))


def _checked(term: Term, algebra: Algebra, value, gradient: tuple, pushed=None) -> Derived:
    """With the derivatives of the gradient; all of them have real values."""
    parts, slots, vectors = algebra.parts, tuple(algebra.vectors), tuple(algebra.vectors.values())
    hessian = hessian_blocks(gradient, vectors, parts)
    if not all(map(is_real, [value, *parts.of.values(), *(x for row in gradient for x in row), *hessian.values()])):
        raise NoRealValue()
    return Derived(term, slots, vectors, bare(value), tuple(tuple(map(bare, row)) for row in gradient),
                   {k: block.applyfunc(bare) for k, block in hessian.items()}, algebra.leaves, {u: bare(e) for u, e in parts.of.items()}, pushed)


def bare(e):
    """e without what its kinks only compare: it is differentiated."""
    if not e.has(*KINKED):
        return e
    return e.replace(lambda x: isinstance(x, KINKED), lambda x: x.func(*x.args[:1 if isinstance(x, absolute) else 2]))


def scalar(e: Expr):
    """A formula without vectors of the state -> (sympy expression, leaves). Raises UsageError where it is too long."""
    algebra = Algebra((), Whole(SCALAR))
    try:
        return bare(algebra.of(e)), algebra.leaves
    except TooLarge:
        raise UsageError(f"a formula of parameters has more than {SCALAR[0]} operations and operands once its vectors are written in components: compute its value beforehand and give it as a parameter") from None
