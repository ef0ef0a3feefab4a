"""Few sites of one family that all feel each other: their field in lanes, a site in each (runtime/lattice/smg_few.h).

Terms of single sites and of pairs serve, the latter where both sites enter alike, so that every site feels the others by one formula. What
belongs to a site by its number must be an entry of an array, w[i] with gamma[i]: lanes hold it as they hold the vectors.
"""
from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...language.expr import Elem, Idx
from ...language.spec import Pairs, Sites
from ..derive.derivatives import switched
from ..lower.code import Argument, Call, Component, For, Function, Let, Local, Name, Parameter, Variable, Zeros
from ..lower.integers import ZERO, Computed, Index, Whole, total
from ..lower.kernels import COEFFICIENTS, additions
from ..lower.lowering import index_names
from ..plan.splitting import of_the_product
from .norms import spectral_bound
from .effort import few_in_lanes
from .part import MOST_LANES, Part, buffer
from .response import indexed
from .slots import whole_vectors

HISTORY = 12        # four vortices at h = 0.1 need 6.0 evaluations a step with 7, 4.8 with 10, 4.2 with 12
LANES = 4           # where the number of sites is known at run time alone
VECTOR, OUT = "const smg_lanes *", "smg_lanes *"


@dataclass(frozen=True)
class Pull:
    """What one term does to its first site: its kernels without and with the bound of norms, and the entries that belong to that site,
    ((name, array), ..)."""
    term: object
    field: Function
    norms: Function
    entries: tuple


def few(model, low):
    """The pulls of all terms, or None where a term, a factor or a feature does not allow it."""
    if not (model.plan.lanes and len(model.families) == 1 and model.families[0].kind == "sphere"):
        return None
    if any(map(indexed, model.responses.values())) or model.method.stages > 1 or {"extended", "tangent"} & set(model.features) or not all(serves(low, t) for t in model.fields):
        return None
    return tuple(pull(low, t, model.unit_radius()) for t in model.energies)


# Which terms serve

def serves(low, t) -> bool:
    d = t.derived
    if d.pushed is not None or not isinstance(t.over, (Pairs, Sites)) or d.parts or switched(d) or any(slot not in t.over.bound for _, slot in t.slots):
        return False
    if not all(plain(node) for node in d.leaves.values()) or len(t.slots) != len(t.over.bound):
        return False
    return symmetric(d, t.over) and formulas(low, t) is not None


def plain(node) -> bool:
    """No number that stands for a site but as the place of an entry."""
    return isinstance(node.index, Idx) if isinstance(node, Elem) and index_names(node) else not index_names(node)


def symmetric(d, over) -> bool:
    """Do both sites of a pair enter alike?"""
    if isinstance(over, Sites):
        return True
    swapped = {a: b for x, y in (d.vectors, d.vectors[::-1]) for a, b in zip(x, y)}
    by_node = {node: name for name, node in d.leaves.items()}
    other = {over.first: over.second, over.second: over.first}
    for s in d.value.free_symbols:
        node = d.leaves.get(s.name)
        if isinstance(node, Elem) and index_names(node):
            twin = by_node.get(Elem(node.name, Idx(other[node.index.name])))
            if twin is None:
                return False
            swapped[s] = sp.Symbol(twin, **s.assumptions0)
    return sp.expand(d.value.xreplace(swapped) - d.value) == 0


# Kernels

def pull(low, t, unit: bool) -> Pull:
    own = own_entries(t)
    gradient, bound, parts = formulas(low, t, unit)
    held = tuple((name, array_of(low, t.derived.leaves[symbol])) for symbol, name in own.items())
    return Pull(t, kernel(low, t, "pull", gradient, own, parts), kernel(low, t, "pull_and_norm", *one_division([*gradient, bound], own, parts)), held)


def own_entries(t) -> dict:
    """Symbol -> name of the entries that belong to the site that is pulled."""
    found = [symbol for symbol, node in sorted(t.derived.leaves.items()) if isinstance(node, Elem) and t.over.bound[0] in index_names(node)]
    return {symbol: f"own{k}" for k, symbol in enumerate(found)}


def array_of(low, node):
    p = low.parameters.get(node.name)
    return Parameter(node.name) if p is not None and not p.fixed else Name(f"table_{node.name}")


def kernel(low, t, what: str, expressions, own: dict, parts: dict) -> Function:
    """g += the gradient by the first slot, and, as the fourth number, the bound."""
    made = low.kernel(expressions, t.derived.leaves, parts, own={symbol: Local(name) for symbol, name in own.items()})
    arguments = (COEFFICIENTS, *(Argument("int64_t", i) for i in t.over.bound[1:]), *(Argument("smg_lanes", name) for name in own.values()),
                 *(Argument(VECTOR, f"v{k}") for k in range(len(t.slots))), Argument(OUT, "g"))
    targets = [Component("g", a) for a in range(len(expressions))]
    return Function("void", f"lane_{t.prefix}_{what}", arguments, (*made.values, *additions(targets, made.results)), target="lanes")


def formulas(low, t, unit: bool = False):
    """(gradient by the first slot, a bound on the norms of the Hessian blocks in its row, symbol -> what they share); None where no bound is at hand.

    Of f(a.b) the block on the diagonal is f'' b b^T, that beside it f' I + f'' b a^T. On vectors across a, and across b on the right, they are at most
    |f''| c/|a|^2 and |f'| + |f''| c/(|a||b|), c = |a x b|^2; 1/(|a||b|) is at most (1/|a|^2 + 1/|b|^2)/2. unit: |a| = |b| = 1.
    """
    blocks = [sp.Matrix(3, 3, [low.number_values(x) for x in block]) for (k, _), block in t.derived.hessian.items() if k == 0]
    vectors = {v for vector in t.derived.vectors for v in vector}
    if not any(vectors & block.free_symbols for block in blocks):
        return list(t.derived.gradient[0]), sum((spectral_bound(b, t.derived.joined) for b in blocks), sp.S.Zero), {}
    u = sp.Symbol("product", real=True)
    f = of_the_product(t.derived, u)
    if f is None:
        return None
    a, b = t.derived.vectors
    dot, aa, bb = (sum(x * y for x, y in zip(p, q)) for p, q in ((a, b), (a, a), (b, b)))
    aa, bb = (sp.S.One, sp.S.One) if unit else (aa, bb)
    first, second = (sp.factor(sp.diff(f, u, n)) for n in (1, 2))
    slope = sp.Symbol("slope", real=True)
    bound = sp.Abs(slope) + sp.Abs(second) * (aa * bb - u ** 2) * (sp.Rational(3, 2) / aa + sp.Rational(1, 2) / bb)
    return [slope * x for x in b], bound, {u: dot, slope: first}


def one_division(expressions, own: dict, parts: dict) -> tuple:
    """The same with each inverse computed once: 1/x, 1/x^2 of what the parts make up are powers of one more part."""
    powers = {p for e in (*expressions, *parts.values()) for p in e.atoms(sp.Pow) if p.exp.is_Integer and p.exp < 0 and p.free_symbols & set(parts)}
    inverse = {base: sp.Symbol(f"inverse{k}", real=True) for k, base in enumerate(sorted({p.base for p in powers}, key=sp.default_sort_key))}
    replaced = {p: inverse[p.base] ** -p.exp for p in powers}
    shared = {**{symbol: 1 / base for base, symbol in inverse.items()}, **{symbol: e.xreplace(replaced) for symbol, e in parts.items()}}
    return [e.xreplace(replaced) for e in expressions], own, shared


# What runtime/lattice/smg_few_step.h asks of a model

def few_functions(model) -> list:
    arguments = (COEFFICIENTS, Argument("const smg_real *", "all"), Argument("int64_t", "pitch"), Argument("int64_t", "i"), Argument(OUT, "g"))
    bodies = {"smg_few_field": field(model, 3, lambda p: p.field), "smg_few_norms": field(model, 4, lambda p: p.norms)}
    return [*(f for p in model.few for f in (p.field, p.norms)),
            *(Function("void", name, arguments, body, target="lanes", wanted=True) for name, body in bodies.items())]


def field(model, numbers: int, kernel_of) -> tuple:
    """g = what all terms add for the sites of one vector."""
    own = (Variable("smg_lanes", "own[3]"), Call("smg_take_slots", (Name("all"), Name("pitch"), Index("i"), Name("own"))))
    n = model.families[0].count
    lines = [line for k, p in enumerate(model.few) for line in term(p, kernel_of(p), f"_{k}", n, numbers)]
    return (*own, *lines)


def term(p: Pull, f: Function, tag: str, n, numbers: int) -> tuple:
    entries = [Let(name + tag, Call("smg_few_entries", (array, Index("i"), n)), "const smg_lanes") for name, array in p.entries]
    given = tuple(Name(name + tag) for name, _ in p.entries)
    if isinstance(p.term.over, Sites):
        return (*entries, Call(f.name, (Name("c"), *given, Name("own"), Name("g"))))
    i, j = Index("i"), Index("j")
    other = (Variable("smg_lanes", "other[3]"), Call("smg_few_spread", (Name("all"), Name("pitch"), j, Name("other"))))
    called = [Call(f.name, (Name("c"), j, *given, Name("own"), Name("other"), Name(out))) for out in ("g", "more")]
    within = (other[0], Zeros("more", numbers), other[1], called[1], Call("smg_few_add", (total(numbers), j - i, Name("more"), Name("g"))))
    return (*entries, For("j", ZERO, i, (*other, called[0]), over="pairs"), For("j", i, Computed("smg_few_end", (i, n)), within, over="pairs"),
            For("j", i + Index("SMG_LANES"), n, (*other, called[0]), over="pairs"))


class FewInLanes(Part):
    """Few sites, all at once in lanes."""
    name = layout = "few"

    def made(self, model, low):
        return few(model, low)

    def functions(self, model):
        return few_functions(model)

    def headers(self, model):
        return ["smg_few.h"]

    def settings(self, model):
        return {"SMG_FEW_IN_LANES": 1}

    def buffers(self, model):
        return [buffer("few", Computed("SMG_FEW_SIZE", (model.total,)), "w and the field in lanes, by components")]

    def sizes(self, model, value):
        return {"SMG_FEW_SIZE": lambda n: 15 * whole_vectors(n)}

    def most(self, model, step):
        return few_in_lanes() + step

    def history(self, model):
        return HISTORY

    def lanes(self, model):
        sites = model.total.value if isinstance(model.total, Whole) else LANES
        return min(1 << max(sites - 1, 1).bit_length(), MOST_LANES)
