"""Lowering: derivatives -> kernels as data, each value computed as rarely as possible.

What depends on parameters alone is computed once a model (`prepare`), what depends on h too once a
state (`stride`), on time once a step (`clock`), on the sites each time; common subexpressions are shared.
"""
from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from types import MappingProxyType

import sympy as sp
from sympy.logic.boolalg import Boolean
from sympy.simplify.cse_main import tree_cse

from ...language.counts import constant_integer, runtime_names, sizes_of
from ...language.expr import Elem, Expr, Idx, Num, Op, Par, Time, Weight, is_draw, walk, with_index
from ...language.spec import Spec
from ..derive.derivatives import is_real, scalar
from ..derive.parts import in_order, needed
from .code import Component, Constant, Drawn, Entry, Held, Local, OfSite, Parameter, Real, Value, real_of
from .integers import Computed, Given, Index, Int, Node, Size, Whole, modulo, times, total

STEP = object()     # stands for the step h among the leaves
COEFFICIENTS = "c"  # what kernels are given
NUMBER, PREPARE, STRIDE, CLOCK, SITE = range(5)      # when a value is known


@dataclass(frozen=True)
class Kernel:
    """What one function computes: named values in their order, and the results. No text."""
    values: tuple
    results: tuple
    operations: int = 0


@dataclass(frozen=True)
class Coefficients:
    """What a model computes before its sites: values = ((name, number, level), ..) in order, sizes = ((name, integer), ..).

    timed: does anything depend on time?
    """
    values: tuple
    sizes: tuple
    timed: bool

    @property
    def names(self):
        return [name for name, _, _ in self.values]

    @property
    def of_model(self):
        """Names of those that parameters alone decide."""
        return [name for name, _ in self.at(PREPARE)]

    @property
    def of_state(self):
        """Names of the others."""
        return [name for name, _, when in self.values if when != PREPARE]

    def at(self, level: int):
        return [(name, value) for name, value, when in self.values if when == level]


class Lowering:
    """Collects hoisted values while it turns expressions into kernels for one model; `finished` says which they are.

    holder: the variable that holds them.
    """

    def __init__(self, spec: Spec, holder: str = COEFFICIENTS):
        self.spec, self.holder = spec, holder
        self.parameters = {p.name: p for p in spec.parameters}
        self.tables = dict(spec.tables)
        self.hoisted: dict = {}         # sympy expression -> (name, level)
        self.kept: dict = {}            # name of the symbol of a hoisted value -> (what it stands for, its level)
        self.sizes = self.named_sizes()         # size -> member of the coefficients
        self.leaves: dict = {}
        self.levels: dict = {}          # expression of the kernel that is made -> its level
        self.reads_time = False
        self.draws = False              # is any number random?
        self.keeps = holder == COEFFICIENTS
        self.site_numbers: dict = {}    # formula in Idx("i") -> function that gives its value, which a state keeps

    # -- leaves -----------------------------------------------------------------------------
    def level(self, name: str) -> int:
        if name in self.kept:
            return self.kept[name][1]
        node = self.leaves.get(name)
        if node is STEP:
            return STRIDE
        if isinstance(node, Time):
            return CLOCK
        if isinstance(node, Par):
            return NUMBER if self.parameters[node.name].fixed else PREPARE
        if (isinstance(node, Elem) or is_draw(node)) and not index_names(node):
            return PREPARE
        return SITE

    def leaf(self, name: str):
        """What a symbol stands for."""
        node = self.leaves.get(name)
        if name in self.kept:
            return self.kept[name][0]
        if node is None:
            return component(name)
        if node is STEP:
            return Held("h", self.holder)
        if isinstance(node, Time):
            self.reads_time = True
            return Held("t", self.holder)
        if isinstance(node, Par):
            return self.parameter(node.name)
        if isinstance(node, Idx):
            return Index(node.name)
        if isinstance(node, Weight):
            return Local(f"weight_{node.name}", exact=True)
        return self.drawn(node) if is_draw(node) else self.entry(node)

    def real(self, e, own=MappingProxyType({})) -> Real:
        """An expression with what its symbols stand for; own: symbol name -> leaf, where it is another than the model's."""
        names = sorted(s.name for s in e.free_symbols)
        return Real(e, {name: own[name] if name in own else self.leaf(name) for name in names})

    def step_size(self):
        """The symbol of h, signed by the orientation: known once a trajectory begins."""
        self.leaves["h"] = STEP
        return sp.Symbol("h", real=True)

    def parameter(self, name: str):
        p = self.parameters[name]
        if p.fixed:
            return Constant(p.default)
        return Given(name) if p.kind == "int" else Parameter(name)

    def entry(self, e: Elem):
        """Entry of an array parameter or of a constant table."""
        p = self.parameters.get(e.name)
        if p is not None and not p.fixed:
            return Parameter(e.name, self.index(e.index))
        return Entry(f"table_{e.name}", self.index(e.index))

    def drawn(self, e: Op) -> Node:
        """A random number: that of a single site is kept, where there is a state to keep it."""
        names = index_names(e)
        if len(names) != 1 or not self.keeps or any(isinstance(n, Idx) and n.bond for n in walk(e)):
            return Drawn(e.op, tuple(map(self.index, e.args)))
        (name,) = names
        number = e.args[0] if e.op == "kept" else e
        return OfSite(self.site_number(with_index(number, name, Idx("i"))), Index(name))

    def site_number(self, e: Expr) -> str:
        """The function of the coefficients and the number i of a site in its family that gives e, which depends on no more than i and parameters."""
        return self.site_numbers.setdefault(e, f"site_number_{len(self.site_numbers)}")

    def unkept(self, e: Expr) -> Kernel:
        """A formula in Idx("i") that `site_number` has a name for, as it is found."""
        self.keeps = False
        found = self.formula(e)
        self.keeps = True
        return found

    def constants(self) -> dict:
        """Tables and arrays whose values are compiled in."""
        return {**self.tables, **{p.name: p.default for p in self.parameters.values() if p.fixed and p.kind == "array"}}

    def index(self, e: Expr) -> Int:
        """An integer formula in bound indices and int parameters."""
        if isinstance(e, Num):
            return Whole(int(e.value))
        if isinstance(e, Idx):
            return Index(e.name)
        if isinstance(e, Par):
            p = self.parameters[e.name]
            return Whole(int(p.default)) if p.fixed else Given(e.name)
        if e.op == "floor" and isinstance(e.args[0], Op) and e.args[0].op == "/":
            return Computed("smg_quotient", tuple(map(self.index, e.args[0].args)))
        if e.op == "^":
            return times(*[self.index(e.args[0])] * int(e.args[1].value))
        args = [self.index(a) for a in e.args]
        return {"neg": lambda: times(-1, *args), "mod": lambda: modulo(*args), "floor": lambda: args[0], "+": lambda: total(*args),
                "-": lambda: args[0] - args[1], "*": lambda: times(*args)}[e.op]()

    def size(self, e: Expr) -> Int:
        """A size: a number when it is known at compile time, else a member of the coefficients."""
        if not runtime_names(e, self.parameters):
            return Whole(constant_integer(e, self.parameters))
        return Size(self.sizes[self.index(e)])

    def named_sizes(self) -> dict:
        """Every size known at run time only, and its name."""
        found = dict.fromkeys(self.index(e) for e in sizes_of(self.spec) if runtime_names(e, self.parameters))
        return {size: f"n{k}" for k, size in enumerate(found)}

    # -- expressions ------------------------------------------------------------------------
    def when(self, e) -> int:
        """The level of an expression: the latest of what it is made of."""
        if e not in self.levels:
            self.levels[e] = self.level(e.name) if e.is_Symbol else max(map(self.when, e.args), default=NUMBER)
        return self.levels[e]

    def hoist(self, e):
        """Replace what is known before the site loop by names computed once."""
        level = self.when(e)
        if isinstance(e, Boolean):      # no number: only its parts can be kept
            return e.func(*[self.hoist(a) for a in e.args]) if e.args else e
        if level in (PREPARE, STRIDE, CLOCK):
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

    def is_atom(self, e) -> bool:
        """Is it at hand without work?"""
        return e.is_Symbol and not is_draw(self.leaves.get(e.name))

    def remember(self, e, level: int):
        """The symbol that holds e; atoms and their negatives are no work and stay."""
        if level == NUMBER or self.is_atom(e) or (e.is_Mul and e.args[0] == -1 and len(e.args) == 2 and self.is_atom(e.args[1])):
            return e
        if e.could_extract_minus_sign():
            return -self.remember(-e, level)
        if e not in self.hoisted:
            self.hoisted[e] = (f"k{len(self.hoisted)}", level)
        short = self.hoisted[e][0]
        name = f"{self.holder}.{short}"
        self.kept[name] = Held(short, self.holder, self.holder == COEFFICIENTS and level == PREPARE), level
        return sp.Symbol(name)          # nothing is assumed of it: a root may have no real value

    def number_values(self, e):
        """Put the values of fixed parameters in place of their names, where a real number comes of it."""
        values = {s: sp.Float(self.parameters[self.leaves[s.name].name].default)
                  for s in e.free_symbols if self.level(s.name) == NUMBER}
        done = e.subs(values) if values else e
        return done if is_real(done) else e

    def kernel(self, expressions, leaves, parts=None, own=MappingProxyType({})) -> Kernel:
        """Several expressions at once, their common parts named x0, x1, ..

        parts: of large formulas, symbol -> expression, as `derive` gives them; own: as in `real`.
        """
        self.leaves.update(leaves)
        self.draws = self.draws or any(is_draw(node) and node.op != "kept" for leaf in leaves.values() for node in walk(leaf))
        self.levels.clear()
        work = [sp.sympify(e) for e in expressions]
        known, late = self.placed(needed(work, parts or {}))
        work = [self.hoist(self.number_values(e.xreplace(known))) for e in work]
        shared, results = shared_parts(late, work)
        operations = sum(int(sp.count_ops(e)) for e in [e for _, e in shared] + results)
        kept = needed(results, dict(shared))        # without what has cancelled out
        draws = self.draws_of([*kept.values(), *results])
        own = {**own, **{symbol: Local(name) for symbol, name in draws.items()}}
        return Kernel((*(Value(name, real_of(self.leaf(symbol))) for symbol, name in draws.items()), *(Value(s.name, self.real(e, own)) for s, e in kept.items())),
                      tuple(self.real(e, own) for e in results), operations)

    def draws_of(self, expressions) -> dict:
        """Symbol -> name of the numbers that are random or kept, each found once."""
        found = sorted({s.name for e in expressions for s in e.free_symbols if is_draw(self.leaves.get(s.name))})
        return {symbol: f"number{n}" for n, symbol in enumerate(found)}

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

    def finished(self) -> Coefficients:
        """What is hoisted, each after those that it depends on. A value hoisted from here on would not be computed, so it
        raises TypeError."""
        self.hoisted = MappingProxyType(self.hoisted)
        values = tuple((name, self.real(e), level) for e, (name, level) in self.hoisted.items())
        return Coefficients(values, tuple((name, size) for size, name in self.sizes.items()), self.is_timed())

    def is_timed(self) -> bool:
        """Does anything so far depend on time?"""
        return self.reads_time or any(level == CLOCK for _, level in self.hoisted.values())


def shared_parts(late: dict, work: list):
    """([(symbol, expression)], results): common subexpressions as x0, x1, ..; large ones are only compared, not rearranged."""
    names = (sp.Symbol(f"x{n}") for n in count())
    if not late:
        return sp.cse(work, symbols=names, order="canonical")
    shared, results = tree_cse([*late.values(), *work], names, order="none")
    return in_order({**dict(zip(late, results)), **dict(shared)}), results[len(late):]


def component(name: str):
    """v0x and dx are components of the vectors v0 and d; everything else is a number of its own."""
    vector, axis = name[:-1], name[-1]
    known = vector == "d" or (vector[:1] == "v" and vector[1:].isdigit())
    return Component(vector, "xyz".index(axis)) if known and axis in "xyz" else Local(name)


def index_names(e: Expr) -> set:
    return {n.name for n in walk(e) if isinstance(n, Idx)}
