"""The least and the largest value of a formula at all times, and for all values of some symbols whose ends are known, as formulas of what neither decides.

By interval arithmetic (R. E. Moore, "Interval Analysis", 1966): each operation takes the ends of its operands to the ends of its result,
so that what comes of it may be too wide, never too narrow. An end is None where there is none, as of the time itself.
"""
from __future__ import annotations

import operator
from functools import reduce
from math import prod
from types import MappingProxyType

import sympy as sp

from ..derive.derivatives import absolute, floor_, greater, is_real, lesser, signum
from ..derive.parts import is_large, is_short
from ..derive.pieces import chosen
from ..derive.written import Operation, minus, negative, over, plus
from ..derive.written import times as written_times
from ..lower.lowering import CLOCK

ALL, NO_ENDS = (None, None), MappingProxyType({})
HALF_TURN = sp.pi / 2
ROUNDED = 1e-14       # of a coefficient, what rounding leaves of it
MOST = 1000, 80      # nodes of an end, and how deep they are: products of products of ends grow


class OneTime:
    """A lowering as bounds see it at the time of one step, which is then known."""

    def __init__(self, low):
        self.low = low

    def __getattr__(self, name):
        return getattr(self.low, name)

    def level(self, name):
        found = self.low.level(name)
        return None if found == CLOCK else found


def varies(low, e, ends=NO_ENDS) -> bool:
    """Does the time enter, or a symbol of those with ends?"""
    return any(s in ends or low.level(s.name) == CLOCK for s in e.free_symbols)


def largest_ever(low, e, ends=NO_ENDS):
    """An upper bound of a formula at all times, itself where it is the same at all of them; None where none is found. ends: {symbol: (least, largest)}."""
    return extent(low, in_cosines(e), ends)[1] if varies(low, e, ends) else e


def expanded(e):
    """Expanded, except inside exponentials: exp(-(t - 1)^2) is bounded at all times, but its factor exp(2 t) is not."""
    held, back = without_exponentials(e)
    return sp.expand(held).xreplace(back)


def without_exponentials(e) -> tuple:
    """e with symbols in place of its exponentials, and {symbol: exponential}."""
    e = sp.sympify(e)
    held = {x: sp.Dummy(real=True) for x in e.atoms(sp.exp)}
    return e.xreplace(held), {symbol: x for x, symbol in held.items()}


def in_cosines(e):
    """cos^2 + sin^2 = 1 below a root, of short formulas: a field that goes around is no larger than one that stands."""
    squares = {p: 1 - sp.cos(p.base.args[0]) ** 2 for p in e.atoms(sp.Pow) if p.exp == 2 and isinstance(p.base, sp.sin)}
    root = e.is_Pow and e.exp == sp.S.Half and is_short(e)
    return sp.sqrt(sp.expand_mul(e.base.xreplace(squares))) if root and squares else e


def extent(low, e, ends=NO_ENDS) -> tuple:
    """(least, largest) value."""
    if not varies(low, e, ends):
        return e, e
    if e in ends:
        return ends[e]
    if isinstance(e, Operation):
        return extent(low, plain(e), ends)
    rule = next((rule for kind, rule in RULES if isinstance(e, kind)), None)
    if rule is None:
        return ALL
    found = tuple(map(sound, rule(e, [extent(low, a, ends) if isinstance(a, sp.Expr) else ALL for a in e.args])))
    return found if known(*found) or not e.is_Add else remainder(low, e, ends) or found


def remainder(low, e, ends):
    """The extent of a sum as mod(x, n) = x - n floor(x/n): with floor(y) = y - f, 0 <= f <= 1, the time may cancel; None where it does not."""
    for step in e.atoms(floor_):
        part = sp.Dummy("f", real=True)
        rest = cancelled(*(sp.expand(e.xreplace({step: x})) for x in (sp.S.Zero, plain(step.args[0]) - part)))
        found = extent(low, rest, {**ends, part: (sp.S.Zero, sp.S.One)}) if step not in rest.atoms(floor_) else ALL
        if known(*found):
            return found
    return None


def plain(e):
    """The operations of `written` as those of sympy."""
    return PLAIN.get(e.func, e.func)(*map(plain, e.args)) if e.args else e


def cancelled(without, e):
    """The sum e, whose terms include those of `without`, less terms that cancel in it but for the rounding of their coefficients."""
    before = without.as_coefficients_dict()
    return sp.Add(*(c * term for term, c in e.as_coefficients_dict().items() if term not in before or abs(c) > ROUNDED * abs(before[term])))


def sound(end):
    """An end that is a real number, and not too long."""
    return None if end is None or not is_real(end) or is_large(end, *MOST) else sp.sympify(end)


def least(*ends):
    """The least of some ends, each known once."""
    return among(min, lesser, ends)


def largest(*ends):
    return among(max, greater, ends)


def among(of_numbers, of_formulas, ends):
    """Of numbers the value, of others a formula."""
    ends = dict.fromkeys(map(sp.sympify, ends))
    return of_numbers(ends, key=float) if all(e.is_number for e in ends) else reduce(of_formulas, ends)


def known(*ends) -> bool:
    return None not in ends


def size(a, b):
    """The largest of |x|, a <= x <= b."""
    if not known(a, b):
        return None
    return sp.Abs(b) if a == b else b if a == -b else largest(-a, b)


def total(e, parts) -> tuple:
    return tuple(sum(ends) if known(*ends) else None for ends in zip(*parts))


def product(e, parts) -> tuple:
    return reduce(times, parts)


def times(x, y) -> tuple:
    """By the products of their ends; where one is missing, by signs."""
    if all(z[0] is not None and side(z[0]) == 1 for z in (x, y)):
        return x[0] * y[0], x[1] * y[1] if known(x[1], y[1]) else None
    if known(*x, *y):
        if y[0] == -y[1] or x[0] == -x[1]:
            most = size(*x) * size(*y)
            return -most, most
        corners = [a * b for a in x for b in y]
        return least(*corners), largest(*corners)
    for (a, b), z in ((x, y), (y, x)):
        if a is not None and a == b and side(a):
            ends = tuple(None if end is None else a * end for end in z)
            return ends if side(a) > 0 else ends[::-1]
    return ALL


def side(e) -> int:
    """1: at least 0, or no number; -1: at most 0; 0: that is not seen."""
    if e.is_nonnegative or e.is_Pow and e.exp.is_even:
        return 1
    return prod(map(side, e.args)) if e.is_Mul else -int(bool(e.is_nonpositive))


def raised(e, parts) -> tuple:
    """x^p for a number p: by products, roots, or the inverse of either."""
    (a, b), p = parts[0], e.exp
    if not p.is_Rational:
        return ALL
    if p < 0:
        return inverse(*raised(sp.Pow(e.base, -p, evaluate=False), parts))
    if p.is_Integer and p % 2 == 0:
        if a is not None and side(a) == 1:
            return a ** p, None if b is None else b ** p
        most = size(a, b)
        return sp.S.Zero, None if most is None else most ** p
    if p.is_Integer:
        return tuple(None if end is None else end ** p for end in (a, b))
    return sp.S.Zero, None if b is None or b.is_negative else b ** p


def inverse(a, b) -> tuple:
    """1/x of what is on one side of 0."""
    above, below = (end is not None and side(end) == sign and not end.is_zero for end, sign in ((a, 1), (b, -1)))
    return ALL if not above and not below else (below_inverse(b) if above else 1 / b, 1 / a if above else below_inverse(a))


def below_inverse(end):
    """1/x at an end that may be infinite."""
    return sp.S.Zero if end is None else 1 / end


def rising(function, first=None, last=None):
    """A function that grows, from one limit to another."""
    return lambda e, parts: tuple(limit if end is None else function(end) for end, limit in zip(parts[0], (first, last)))


def opposite(e, parts) -> tuple:
    return tuple(None if end is None else -end for end in reversed(parts[0]))


def difference(e, parts) -> tuple:
    return total(e, (parts[0], opposite(e, parts[1:])))


def quotient(e, parts) -> tuple:
    return times(parts[0], inverse(*parts[1]))


def logarithm(e, parts) -> tuple:
    return tuple(sp.log(end) if end is not None and end.is_positive else None for end in parts[0])


def between(a, b):
    return lambda e, parts: (sp.sympify(a), sp.sympify(b))


def magnitude(e, parts) -> tuple:
    return sp.S.Zero, size(*parts[0])


def even_growing(e, parts) -> tuple:
    """cosh."""
    most = size(*parts[0])
    return sp.S.One, None if most is None else sp.cosh(most)


def rounded(e, parts) -> tuple:
    a, b = parts[0]
    return None if a is None else a - 1, b


def smaller(e, parts) -> tuple:
    (a, b), (c, d) = parts[:2]
    ends = [end for end in (b, d) if end is not None]
    return least(a, c) if known(a, c) else None, least(*ends) if ends else None


def larger(e, parts) -> tuple:
    (a, b), (c, d) = parts[:2]
    ends = [end for end in (a, c) if end is not None]
    return largest(*ends) if ends else None, largest(b, d) if known(b, d) else None


def either(e, parts) -> tuple:
    """One branch or the other."""
    (a, b), (c, d) = parts[1:]
    return least(a, c) if known(a, c) else None, largest(b, d) if known(b, d) else None


PLAIN = {plus: operator.add, minus: operator.sub, written_times: operator.mul, over: operator.truediv, negative: operator.neg}
RULES = ((sp.Add, total), (sp.Mul, product), (sp.exp, rising(sp.exp, sp.S.Zero)), (sp.Pow, raised), ((sp.sin, sp.cos), between(-1, 1)),
         (sp.tanh, rising(sp.tanh, sp.S.NegativeOne, sp.S.One)), (sp.atan, rising(sp.atan, -HALF_TURN, HALF_TURN)), (sp.asin, between(-HALF_TURN, HALF_TURN)),
         (sp.acos, between(0, sp.pi)), (sp.atan2, between(-sp.pi, sp.pi)), (sp.sinh, rising(sp.sinh)), (sp.log, logarithm), (sp.cosh, even_growing),
         ((absolute, sp.Abs), magnitude), ((signum, sp.sign), between(-1, 1)), (floor_, rounded), (lesser, smaller), (greater, larger), (chosen, either),
         (plus, total), (minus, difference), (written_times, product), (over, quotient), (negative, opposite))
