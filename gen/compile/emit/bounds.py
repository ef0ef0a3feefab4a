"""Bounds: every entry that a formula reads lies in its array, whatever the sizes. As in the reader: terms by interval
arithmetic, strengths and radii site by site.
"""
from __future__ import annotations

from functools import reduce

from ...language.expr import Elem, Idx, Num, Par, walk
from ...read.terms import families_of
from ..lower.lowering import index_names


class BoundParts:
    """Checks of the indices of arrays and tables; part of `Emitter`."""

    def entry_checks(self):
        """Statements that refuse sizes for which an index leaves its array."""
        self.products = {}      # C text of the extreme of some products -> its name
        tests = [test for t in (*self.spec.effects, *self.spec.observables) for e in entries(t.value)
                 for test in self.interval_tests(e, families_of(t.over))]
        tests += [test for f in self.spec.families for formula in (f.kappa, f.radius, *sum(f.casimir or (), ()))
                  for e in entries(formula) for test in self.site_tests(e, f)]
        return [*(f"const smg_real {name} = {text};" for text, name in self.products.items()), *tests]

    def site_tests(self, e: Elem, f):
        """0 <= index < size at every site of a family."""
        if e.index == Idx("i") or not index_names(e.index):
            return self.interval_tests(e, {"i": f.name})
        index, loop = self.low.index(e.index), f"for (int64_t i = 0; i < {self.by_name[f.name].count}; ++i)"
        return [f"{loop}\n    {refuse_unless(f'{index} >= 0 && {index} < {self.entry_size(e)}')}"]

    def entry_size(self, e: Elem) -> str:
        p = self.low.parameters.get(e.name)
        if p is not None and not p.fixed:
            return self.low.size(p.size)
        return str(len(self.low.tables[e.name] if p is None else p.default))

    def interval_tests(self, e: Elem, families):
        """0 <= index < size for indices from 0 to the sizes of their families, without what the generator can see to hold."""
        size, tops = self.entry_size(e), {i: number_or_text(self.by_name[f].count, "{} - 1") for i, f in families.items()}
        low, high = self.interval(e.index, tops)
        tests = [] if isinstance(low, int) and low >= 0 else [f"{low} >= 0"]
        inside = high == number_or_text(size, "{} - 1") or isinstance(high, int) and size.isdigit() and high < int(size)
        tests += [] if inside else [f"{high} < {number_or_text(size, '{}')}"]
        return [refuse_unless(test) for test in tests]

    def interval(self, e, tops):
        """Least and largest value of an index formula, each a number or C text of a real, which cannot overflow."""
        if isinstance(e, Num):
            return int(e.value), int(e.value)
        if isinstance(e, Par):
            return (number_or_text(self.low.index(e), "{}"),) * 2
        if isinstance(e, Idx):
            return 0, tops[e.name]
        (a, b), *rest = [self.interval(x, tops) for x in e.args]
        if e.op == "neg":
            return combined("-", 0, b), combined("-", 0, a)
        c, d = rest[0]
        if e.op in "+-":
            return (combined(e.op, a, c if e.op == "+" else d), combined(e.op, b, d if e.op == "+" else c))
        corners = list(dict.fromkeys(combined("*", x, y) for x in (a, b) for y in (c, d)))
        return self.extreme("min", corners), self.extreme("max", corners)

    def extreme(self, which: str, values):
        """The least or the largest of numbers and texts, by a name of its own, so that texts do not grow."""
        numbers = [v for v in values if isinstance(v, int)]
        texts = [v for v in values if isinstance(v, str)]
        if numbers:
            texts.append(min(numbers) if which == "min" else max(numbers))
        if len(texts) == 1:
            return texts[0]
        text = reduce(lambda x, y: f"smg_{which}({x}, {y})", map(str, texts))
        return self.products.setdefault(text, f"bound{len(self.products)}")


def entries(e):
    """The entries of arrays and tables that a formula reads."""
    return [] if e is None else [node for node in walk(e) if isinstance(node, Elem)]


def refuse_unless(test: str) -> str:
    return f"if (!({test})) return SMG_BAD_PARAMETER;"


def number_or_text(size: str, form: str):
    """A size in the form "{}" or "{} - 1": an int where it is a literal, else C text."""
    if size.isdigit():
        return int(size) - form.count("1")
    text = form.format(f"(smg_real){size}")
    return f"({text})" if " - " in form else text


def combined(op: str, a, b):
    if isinstance(a, int) and isinstance(b, int):
        return {"+": a + b, "-": a - b, "*": a * b}[op]
    if (op, a) in (("+", 0), ("*", 1)):
        return b
    return a if (op, b) in (("+", 0), ("-", 0), ("*", 1)) else f"({a} {op} {b})"
