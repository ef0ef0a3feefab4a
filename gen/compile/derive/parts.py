"""Large formulas by parts: what grows large gets a name, and derivatives go through it by the chain rule.

A part is an expression in vectors, parameters and earlier parts, small enough for sympy. So the work and the
length of all derivatives grow with the formula, not with its power, however deep it is nested.
"""
from __future__ import annotations

import math

import sympy as sp

from .pieces import chosen

WHOLE = 150, 6      # nodes, and powers and functions inside each other, of a formula that stays whole
PART = 15, 1        # of a part; measured: larger ones take more operations and more time
SCALAR = 2000, 120  # of a formula of parameters, which is not differentiated
TERMS = 500         # of an expression that is multiplied out


class TooLarge(Exception):
    """A formula that does not stay whole."""


class Whole:
    """A formula in one piece; TooLarge where it grows beyond `most`, its nodes and their depth. variables: those that it is differentiated by; what has none
    of them counts as one node."""
    of: dict = {}

    def __init__(self, most=None):
        self.most = most or WHOLE
        self.variables: frozenset = frozenset()

    def held(self, e):
        constant = self.variables and isinstance(e, sp.Basic) and not e.free_symbols & self.variables
        if is_large(e, *SCALAR) if constant else is_large(e, *self.most, self.variables):
            raise TooLarge
        return e

    def slope(self, e, x):
        return sp.diff(e, x)


class Parts:
    """Named parts u0, u1, ..; `of` maps each symbol to its expression, in order of definition."""

    def __init__(self):
        self.of: dict = {}
        self.names: dict = {}
        self.slopes: dict = {}

    def held(self, e):
        """e, or its name where it is large. Nothing is assumed of a name: a root may have no real value."""
        if not isinstance(e, sp.Expr) or not is_large(e, *PART):
            return e
        if e not in self.names:
            self.names[e] = sp.Symbol(f"u{len(self.names)}")
            self.of[self.names[e]] = e
        return self.names[e]

    def slope(self, e, x):
        """de/dx; the slope of a part is worked out once, after those of the parts in it."""
        for u, part in needed([e], self.of).items():
            if (u, x) not in self.slopes:
                self.slopes[u, x] = self.chained(part, x)
        return self.chained(e, x)

    def chained(self, e, x):
        """de/dx = (its own derivative) + sum over its parts u of de/du du/dx."""
        terms = [sp.diff(e, x)]
        for u in sorted(e.free_symbols & self.of.keys(), key=lambda s: int(s.name[1:])):
            if self.slopes[u, x] != 0:
                terms.append(self.held(sp.diff(e, u)) * self.slopes[u, x])
        return self.held(sp.Add(*(self.held(term) for term in terms)))


def is_large(e, nodes: int, depth: int, variables=frozenset()) -> bool:
    """More nodes, or more powers and functions inside each other? Looks at no more of e than it must, and into nothing without `variables`, if there are any."""
    left = [(e, 0)]
    for _ in range(nodes):
        if not left:
            return False
        one, deep = left.pop()
        if variables and one.args and not one.free_symbols & variables:
            continue
        deep += isinstance(one, (sp.Pow, sp.Function)) and any(a.args for a in one.args)
        if deep > depth:
            return True
        left += [(a, deep) for a in one.args]
    return bool(left)


def expanded(e):
    """e multiplied out where it is short, or e as it is. Functions stay whole: exp(-(t - 3)^2) would lose its digits."""
    whole, back = functions_apart(e)
    return sp.expand(whole, power_base=False).xreplace(back) if is_short(e) else e


def functions_apart(e) -> tuple:
    """(e with a symbol for each function in it, what the symbols stand for)."""
    names = {f: sp.Dummy(real=True) for f in functions_of(e)}
    return e.xreplace(names), {d: f for f, d in names.items()}


def functions_of(e):
    """The functions in e that stand in no other one."""
    walk = sp.preorder_traversal(e)
    for x in walk:
        if isinstance(x, sp.Function) and not isinstance(x, chosen):
            walk.skip()
            yield x


def is_short(e) -> bool:
    """Can e be multiplied out in few terms, denominators too?"""
    return terms(e) <= TERMS


def terms(e) -> int:
    """How many terms e has at most when everything in it is multiplied out."""
    if e.is_Add:
        return sum(map(terms, e.args))
    if e.is_Pow and e.exp.is_Integer:
        return math.comb(terms(e.base) + abs(int(e.exp)) - 1, abs(int(e.exp)))
    return math.prod(map(terms, e.args)) if e.is_Mul else max(map(terms, e.args), default=1)


def needed(expressions, parts: dict) -> dict:
    """The parts that expressions depend on, in order of definition."""
    found, left = set(), list(expressions)
    while left:
        fresh = (left.pop().free_symbols & parts.keys()) - found
        found |= fresh
        left += [parts[u] for u in fresh]
    return {u: e for u, e in parts.items() if u in found}


def in_order(statements: dict) -> list:
    """[(symbol, expression)], each after those that it depends on."""
    done: dict = {}

    def visit(symbol):
        if symbol in done or symbol not in statements:
            return
        for s in sorted(statements[symbol].free_symbols, key=lambda s: s.name):
            visit(s)
        done[symbol] = statements[symbol]
    for symbol in statements:
        visit(symbol)
    return list(done.items())
