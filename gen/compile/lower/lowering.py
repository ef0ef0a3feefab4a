"""Lowering: derivatives -> kernels in C statements, each computed as rarely as possible.

What depends on parameters alone is computed once (`prepare`), what depends on time too once a
step (`clock`), what depends on the sites each time; common subexpressions are shared.
"""
from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from types import MappingProxyType

import sympy as sp
from sympy.functions.elementary.piecewise import ExprCondPair
from sympy.logic.boolalg import Boolean
from sympy.simplify.cse_main import tree_cse

from ...language.counts import constant_integer, runtime_names, sizes_of
from ...language.expr import Elem, Expr, Idx, Num, Op, Par, Time, Weight, walk
from ...language.spec import Spec
from ..derive.derivatives import is_real, scalar
from ..derive.parts import in_order, needed
from .cprint import Printer, number

STEP = object()     # stands for the step h among the leaves
NUMBER, PREPARE, CLOCK, SITE = range(4)      # when a value is known


@dataclass
class Kernel:
    """One C function body: statements, and the expressions of its results."""
    lines: list
    results: list
    operations: int


class Lowering:
    """Collects hoisted values while it turns expressions into C text for one model."""
    printer, real, holder = Printer, "smg_real", "c"     # how numbers are written, their type, and what holds hoisted ones

    def __init__(self, spec: Spec):
        self.spec = spec
        self.parameters = {p.name: p for p in spec.parameters}
        self.tables = dict(spec.tables)
        self.hoisted: dict = {}         # sympy expression -> (name, level)
        self.kept: dict = {}            # symbol of a hoisted value -> its level
        self.integers = self.named_sizes()      # C text of a size -> member of the coefficients
        self.leaves: dict = {}
        self.used_tables: dict = {}
        self.uses_time = False

    # -- leaves -----------------------------------------------------------------------------
    def level(self, name: str) -> int:
        if name in self.kept:
            return self.kept[name]
        node = self.leaves.get(name)
        if node is STEP:
            return PREPARE
        if isinstance(node, Time):
            return CLOCK
        if isinstance(node, Par):
            return NUMBER if self.parameters[node.name].fixed else PREPARE
        if isinstance(node, Elem) and not index_names(node.index):
            return PREPARE
        return SITE

    def text(self, name: str) -> str:
        """The C text of a symbol."""
        node = self.leaves.get(name)
        if node is None:
            return component(name)
        if node is STEP:
            return "c->h"
        if isinstance(node, Time):
            self.uses_time = True
            return "c->t"
        if isinstance(node, Par):
            return self.parameter(node.name)
        if isinstance(node, Idx):
            return f"(smg_real){node.name}"
        if isinstance(node, Weight):
            return f"weight_{node.name}"
        return self.entry(node)

    def step_size(self):
        """The symbol of h, signed by the orientation: known like a parameter once a trajectory begins."""
        self.leaves["h"] = STEP
        return sp.Symbol("h", real=True)

    def parameter(self, name: str) -> str:
        p = self.parameters[name]
        if p.fixed:
            return number(p.default)
        return f"(smg_real)c->p.{name}" if p.kind == "int" else f"c->p.{name}"

    def entry(self, e: Elem) -> str:
        """Entry of an array parameter or of a constant table."""
        p = self.parameters.get(e.name)
        if p is not None and not p.fixed:
            return f"c->p.{e.name}[{self.index(e.index)}]"
        self.used_tables[e.name] = p.default if p is not None else self.tables[e.name]
        return f"table_{e.name}[{self.index(e.index)}]"

    def index(self, e: Expr) -> str:
        """An integer formula in bound indices and int parameters, as int64_t text."""
        if isinstance(e, Num):
            return str(int(e.value))
        if isinstance(e, Idx):
            return e.name
        if isinstance(e, Par):
            p = self.parameters[e.name]
            return str(int(p.default)) if p.fixed else f"c->p.{e.name}"
        args = [self.index(a) for a in e.args]
        if e.op == "neg":
            return f"(-{args[0]})"
        if e.op == "mod":
            return f"smg_mod({args[0]}, {args[1]})"
        if e.op == "floor" and isinstance(e.args[0], Op) and e.args[0].op == "/":
            return f"smg_quotient({self.index(e.args[0].args[0])}, {self.index(e.args[0].args[1])})"
        if e.op == "^":
            return "(" + "*".join([args[0]] * int(e.args[1].value)) + ")"
        return f"({args[0]} {e.op} {args[1]})"

    def size(self, e: Expr) -> str:
        """A size: a literal when it is known at compile time, else a member of the coefficients."""
        if not runtime_names(e, self.parameters):
            return str(constant_integer(e, self.parameters))
        return f"c->{self.integers[self.index(e)]}"

    def named_sizes(self) -> dict:
        """C text -> name of every size known at run time only: from the spec, before anything is printed."""
        texts = dict.fromkeys(self.index(e) for e in sizes_of(self.spec) if runtime_names(e, self.parameters))
        return {text: f"n{k}" for k, text in enumerate(texts)}

    # -- expressions ------------------------------------------------------------------------
    def when(self, e) -> int:
        return max((self.level(s.name) for s in e.free_symbols), default=NUMBER)

    def hoist(self, e):
        """Replace what is known before the site loop by names computed once."""
        level = self.when(e)
        if isinstance(e, (Boolean, ExprCondPair)):      # no number: only its parts can be kept
            return e.func(*[self.hoist(a) for a in e.args]) if e.args else e
        if level in (PREPARE, CLOCK):
            return self.remember(e, level)
        if not e.args or level == NUMBER:
            return e
        if isinstance(e, (sp.Add, sp.Mul)):
            return self.hoist_group(e)
        return e.func(*[self.hoist(a) for a in e.args])

    def hoist_group(self, e):
        """Sum or product: first what only parameters decide, then what time decides too."""
        late = [self.hoist(a) for a in e.args if self.when(a) == SITE]
        early = [a for a in e.args if self.when(a) != SITE]
        if not early:
            return e.func(*late)
        return e.func(self.remember(e.func(*early), max(self.when(a) for a in early)), *late)

    def remember(self, e, level: int):
        """The symbol that holds e; atoms and their negatives are no work and stay."""
        if level == NUMBER or e.is_Symbol or (e.is_Mul and e.args[0] == -1 and len(e.args) == 2
                                              and e.args[1].is_Symbol):
            return e
        if e.could_extract_minus_sign():
            return -self.remember(-e, level)
        if e not in self.hoisted:
            self.hoisted[e] = (f"k{len(self.hoisted)}", level)
        name = f"{self.holder}->{self.hoisted[e][0]}"
        self.kept[name] = level
        return sp.Symbol(name)          # nothing is assumed of it: a root may have no real value

    def number_values(self, e):
        """Put the values of fixed parameters in place of their names, where a real number comes of it."""
        values = {s: sp.Float(self.parameters[self.leaves[s.name].name].default)
                  for s in e.free_symbols if self.level(s.name) == NUMBER}
        done = e.subs(values) if values else e
        return done if is_real(done) else e

    def kernel(self, expressions, leaves, parts=None) -> Kernel:
        """Statements for several expressions at once, with their common parts named x0, x1, ..

        parts: of large formulas, symbol -> expression, as `derive` gives them.
        """
        self.leaves.update(leaves)
        work = [sp.sympify(e) for e in expressions]
        known, late = self.placed(needed(work, parts or {}))
        work = [self.hoist(self.number_values(e.xreplace(known))) for e in work]
        shared, results = shared_parts(late, work)
        show = self.printer(self.text)
        lines = [f"const int {show(s)} = {show.test(e)};" if isinstance(e, Boolean) and not e.is_Symbol else
                 f"const {self.real} {show(s)} = {show(e)};" for s, e in shared]
        operations = sum(int(sp.count_ops(e)) for e in [e for _, e in shared] + results)
        return Kernel(lines, [show(r) for r in results], operations)

    def placed(self, parts: dict):
        """(what stands for those parts that are known before the sites, the others as statements)."""
        known: dict = {}
        late: dict = {}
        for u, e in parts.items():
            e = self.number_values(e.xreplace(known))
            early = self.when(e) != SITE or not e.args
            (known if early else late)[u] = self.hoist(e)
        return known, late

    def formula(self, e: Expr) -> Kernel:
        """A scalar formula (kappa, radius, an entry of C)."""
        value, leaves = scalar(e)
        return self.kernel([value], leaves)

    def is_timed(self) -> bool:
        """Does any kernel so far depend on time?"""
        return self.uses_time or any(level == CLOCK for _, level in self.hoisted.values())

    def close(self):
        """All kernels are there: a value hoisted from here on would not be computed, so it raises TypeError."""
        self.hoisted = MappingProxyType(self.hoisted)

    def coefficients(self):
        """Hoisted values in dependency order: [(name, C text, level)]."""
        show = self.printer(self.text)
        return [(name, show(e), level) for e, (name, level) in self.hoisted.items()]


def shared_parts(late: dict, work: list):
    """([(symbol, expression)], results): common subexpressions as x0, x1, ..; large ones are only compared, not rearranged."""
    names = (sp.Symbol(f"x{n}") for n in count())
    if not late:
        return sp.cse(work, symbols=names, order="canonical")
    shared, results = tree_cse([*late.values(), *work], names, order="none")
    return in_order({**dict(zip(late, results)), **dict(shared)}), results[len(late):]


def component(name: str) -> str:
    """v0x -> v0[0]; dx -> d[0]; everything else is itself."""
    vector, axis = name[:-1], name[-1]
    known = vector == "d" or (vector[:1] == "v" and vector[1:].isdigit())
    return f"{vector}[{'xyz'.index(axis)}]" if known and axis in "xyz" else name


def index_names(e: Expr) -> set:
    return {n.name for n in walk(e) if isinstance(n, Idx)}
