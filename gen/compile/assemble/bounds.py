"""Bounds: every entry that a formula reads lies in its array, whatever the sizes. As in the reader: terms by interval
arithmetic, strengths and radii site by site. Bounds are real numbers, which cannot overflow.
"""
from __future__ import annotations

import sympy as sp

from ...language.expr import Elem, Idx, Num, Par, walk
from ...language.spec import Lattice, families_of
from ..derive.derivatives import greater, lesser
from ..lower.code import For, If, Local, Name, Not, Real, Return, Value, refuse
from ..lower.integers import ZERO, Int, Node, Product, Whole, compare, terms_of
from ..lower.loops import Loops
from ..lower.lowering import index_names

REFUSED = (Return(Name("SMG_BAD_PARAMETER")),)


class Bounds:
    """Checks of the indices of arrays and tables; count(family): its size."""

    def __init__(self, low, count):
        self.low, self.count = low, count
        self.leaves: dict = {}      # symbol name -> the integer it stands for
        self.products: dict = {}    # the extreme of some products -> its symbol

    def checks(self, spec) -> tuple:
        """Statements that refuse sizes for which an index leaves its array."""
        tests = [test for t in (*spec.effects, *spec.observables) for formula in t.formulas.values() for e in entries(formula)
                 for test in self.interval_tests(e, families_of(t.over), t.over)]
        tests += [test for f in spec.families for formula in (f.kappa, f.radius, *sum(f.casimir or (), ()))
                  for e in entries(formula) for test in self.site_tests(e, f)]
        return (*(Value(symbol.name, self.real(e)) for e, symbol in self.products.items()), *tests)

    def site_tests(self, e: Elem, f):
        """0 <= index < size at every site of a family."""
        if e.index == Idx("i") or not index_names(e.index):
            return self.interval_tests(e, {"i": f.name})
        index = self.low.index(e.index)
        return [For("i", ZERO, self.count(f.name), refuse(compare(index, "<", ZERO), compare(index, ">=", self.entry_size(e))))]

    def entry_size(self, e: Elem) -> Int:
        p = self.low.parameters.get(e.name)
        if p is not None and not p.fixed:
            return self.low.size(p.size)
        return Whole(len(self.low.tables[e.name] if p is None else p.default))

    def interval_tests(self, e: Elem, families, over=None):
        """0 <= index < size for indices from 0 to the sizes of their families, and numbers of bonds, without what the generator can see to hold."""
        size, tops = self.symbol(self.entry_size(e)), {i: self.symbol(self.count(f)) - 1 for i, f in families.items()}
        if isinstance(over, Lattice) and over.number:
            tops[over.number] = self.symbol(Loops(self.low, self.count).bonds_of(over, range(len(over.bonds)))) - 1
        low, high = self.interval(e.index, tops)
        tests = [] if low.is_Number and low >= 0 else [sp.GreaterThan(low, 0, evaluate=False)]
        tests += [] if (size - high).is_positive and (size - high).is_Number else [sp.StrictLessThan(high, size, evaluate=False)]
        return [If((Not(self.real(test)),), REFUSED) for test in tests]

    def interval(self, e, tops):
        """Least and largest value of an index formula."""
        if isinstance(e, Num):
            return sp.Integer(e.value), sp.Integer(e.value)
        if isinstance(e, Par):
            return (self.symbol(self.low.index(e)),) * 2
        if isinstance(e, Idx):
            return sp.S.Zero, tops[e.name]
        (a, b), *rest = [self.interval(x, tops) for x in e.args]
        if e.op == "neg":
            return -b, -a
        c, d = rest[0]
        if e.op in "+-":
            return (a + c, b + d) if e.op == "+" else (a - d, b - c)
        corners = list(dict.fromkeys(x * y for x in (a, b) for y in (c, d)))
        return self.extreme(lesser, min, corners), self.extreme(greater, max, corners)

    def extreme(self, which, of_numbers, values):
        """The least or the largest of some values, by a name of its own, so that nothing grows."""
        numbers = [v for v in values if v.is_Number]
        others = [v for v in values if not v.is_Number] + ([of_numbers(numbers)] if numbers else [])
        e = others[0]
        for other in others[1:]:
            e = which(e, other)
        return e if len(others) == 1 else self.products.setdefault(e, sp.Symbol(f"bound{len(self.products)}"))

    def symbol(self, n: Int):
        """An integer in real arithmetic."""
        if isinstance(n, Whole):
            return sp.Integer(n.value)
        if isinstance(n, Product):
            return sp.Mul(*map(self.symbol, n.factors))
        return sp.Add(*(factor * (self.factor(term) if not isinstance(term, Whole) else 1) for factor, term in terms_of(n)))

    def factor(self, n: Int):
        return self.symbol(n) if isinstance(n, Product) else self.named(n)

    def named(self, n: Node):
        name = f"{type(n).__name__}.{n.name}"
        self.leaves[name] = n
        return sp.Symbol(name, real=True)

    def real(self, e) -> Real:
        return Real(e, {s.name: self.leaves.get(s.name, Local(s.name)) for s in sorted(e.free_symbols, key=lambda s: s.name)})


def entries(e):
    """The entries of arrays and tables that a formula reads."""
    return [] if e is None else [node for node in walk(e) if isinstance(node, Elem)]
