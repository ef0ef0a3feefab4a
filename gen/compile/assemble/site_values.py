"""Terms of single sites that differ from site to site, on lattices by rows: what the number of a site alone decides stands in arrays by
slots (smg_fill_values of runtime/lattice/smg_row_slots.h), which the gradient loads in lanes; the rest is as for terms that are the same everywhere.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

import sympy as sp
from sympy.logic.boolalg import Boolean

from ...language.expr import Elem, Idx, Time, is_draw
from ...language.spec import Lattice, Sites
from ..lower.code import Argument, Call, Function, If, Let, Local, Name, Not, Ordered, Return, Scope, mentions
from ..lower.integers import ZERO, Computed, Index, Int, compare, total
from ..lower.kernels import COEFFICIENTS, gradient_function
from ..lower.lowering import index_names
from .families import returned
from .lanes import in_lanes


@dataclass(frozen=True)
class Sited:
    """A term: its gradient in lanes, the functions of its values and the number of the first; bounds at a site of the field of no spins, and of the Hessian; the families of its sites, the first
    of which has its values."""
    gradient: Function
    values: tuple
    first: int
    rest: Function | None
    norm: Function | None
    homes: tuple

    @property
    def width(self) -> int:
        """Numbers that a site has of it."""
        return len(self.values)

    def calls(self) -> list:
        """The statements that return each."""
        return [self.homes[0].value(f.name) for f in self.values]

    def bound(self, f: Function) -> Call:
        """That bound at site k."""
        return Call(f.name, (Name("c"), Index("k") - self.homes[0].first))

    def moves(self, family: str) -> bool:
        """Do sites of that family feel it?"""
        return any(home.name == family for home in self.homes)

    @property
    def functions(self) -> list:
        return [f for f in (self.gradient, *self.values, self.rest, self.norm) if f is not None]


def differs(t) -> bool:
    """Is it a term of single sites, or of those of a sublattice, whose gradient depends on the number of the site?"""
    gradient = next(f for f in t.functions if f.name == f"{t.prefix}_gradient")
    return isinstance(t.over, (Sites, Lattice)) and len(t.over.bound) == 1 and bool(set(t.over.bound) & mentions(*gradient.body))


def numbered(low, e) -> bool:
    """Does the number of the site enter?"""
    return any(isinstance(node := low.leaves.get(s.name), Idx) or (isinstance(node, Elem) or is_draw(node)) and index_names(node) for s in e.free_symbols)


def lasting(low, e) -> bool:
    """Is it free of time and of vectors?"""
    return all(s.name in low.leaves and not isinstance(low.leaves[s.name], Time) for s in e.free_symbols)


def parted(low, e, values: dict):
    """e with a symbol in place of all that the number of the site alone decides: {that: its symbol}."""
    if not numbered(low, e):
        return e
    if isinstance(e, Boolean) and not e.is_Symbol:      # no number: only its parts are
        return e.func(*[parted(low, a, values) for a in e.args])
    if lasting(low, e):
        return kept(e, values)
    if isinstance(e, (sp.sin, sp.cos)) and (waves := in_waves(low, e)) is not None:
        return parted(low, waves, values)
    if not isinstance(e, (sp.Add, sp.Mul)):
        return e.func(*[parted(low, a, values) for a in e.args])
    here = e.func(*[a for a in e.args if lasting(low, a)])
    return e.func(kept(here, values) if numbered(low, here) else here, *[parted(low, a, values) for a in e.args if not lasting(low, a)])


def in_waves(low, e):
    """cos(a + b) = cos a cos b - sin a sin b where the number of the site decides a, and b has it not: no function is left to be found in every lane."""
    terms = sp.Add.make_args(e.args[0])
    a, b = (sp.Add(*[x for x in terms if lasting(low, x) == last]) for last in (True, False))
    if numbered(low, b) or a == 0:
        return None
    return sp.cos(a) * sp.cos(b) - sp.sin(a) * sp.sin(b) if isinstance(e, sp.cos) else sp.sin(a) * sp.cos(b) + sp.cos(a) * sp.sin(b)


def kept(e, values: dict):
    if e.could_extract_minus_sign():
        return -kept(-e, values)
    return values.setdefault(e, sp.Symbol(f"value{len(values)}", real=True))


def partings(low, t) -> tuple:
    """(components of the gradient, {what stands in arrays: its symbol})."""
    values: dict = {}
    return [parted(low, low.number_values(x), values) for x in t.derived.gradient[0]], values


def sited(low, terms, first: dict, homes, bounds) -> dict:
    """{prefix: `Sited`} of the terms that differ; first: the number of the first value of each; homes(term): the families of its sites; bounds(term): of the field of no spins and of the Hessian at a site, None where
    nobody asks."""
    found = {}
    for t in terms:
        gradient, values = partings(low, t)
        ends = [None if e is None else of_site(low, t, what, e) for what, e in zip(("rest", "norm"), bounds(t))]
        found[t.prefix] = Sited(lane_gradient(low, t, gradient, values), tuple(of_site(low, t, symbol.name, e) for e, symbol in values.items()), first[t.prefix], *ends, homes(t))
    return found


def count(low, t) -> int:
    """Of its values."""
    return len(partings(low, t)[1])


def lane_gradient(low, t, gradient, values) -> Function:
    kernel = low.kernel(gradient, t.derived.leaves, own={symbol.name: Local(symbol.name) for symbol in values.values()})
    f = in_lanes(gradient_function(t, kernel, f"{t.prefix}_gradient"))
    return replace(f, arguments=(*f.arguments, *(Argument("smg_lanes", symbol.name) for symbol in values.values())), inlined="always")


def of_site(low, t, what: str, e) -> Function:
    """A number of a site."""
    arguments = (COEFFICIENTS, Argument("int64_t", t.over.bound[0]))
    return Function("smg_real", f"{t.prefix}_{what}", arguments, returned(low.kernel([e], t.derived.leaves)))


# What the model says of them

def taken(one: Sited) -> tuple:
    """The values of the slots of one vector, in lanes."""
    return tuple(Let(name, taken_value(one.first + n), "const smg_lanes") for n, name in enumerate(names(one)))


def taken_value(n: int) -> Call:
    return Call("smg_take_value", (Name("run"), total(n), Index("pitch"), Index("j")))


def names(one: Sited) -> list:
    """Of its values as its gradient has them."""
    return [a.name for a in one.gradient.arguments if a.kind == "smg_lanes"]


def value_function(found, factors, more, zeros=()) -> list:
    """smg_site_value(c, n, site): the n-th number of a site; factors: {name: function} of those behind those of terms; more: the statements of others behind them; zeros: those that return 0 where a site is absent."""
    bodies = [*(returned_by(found, n) for n in range(max((one.first + one.width for one in found), default=0))), *map(value_call, factors.values()), *more]
    if not bodies:
        return []
    tests = [If((compare(Index("n"), "==", total(n)),), body) for n, body in enumerate(bodies[:-1])]
    return [Function("smg_real", "smg_site_value", (COEFFICIENTS, Argument("int64_t", "n"), Argument("int64_t", "site")), (*zeros, *tests, *bodies[-1]), wanted=True)]


def returned_by(found, n: int) -> tuple:
    """The statements that return the n-th value of a site: of a term, or of several of different families."""
    calls = [one.calls()[n - one.first] for one in found if one.first <= n < one.first + one.width]
    return calls[0] if len(calls) == 1 else (*(Scope(body[:-1]) for body in calls), Return(ZERO))


def value_call(name: str) -> tuple:
    return (Return(Call(name, (Name("c"), Index("site")))),)


def is_there(site: Int):
    """Is that site not absent?"""
    return compare(Computed("smg_present", (Index("c"), site)), ">", ZERO)


def zero_if_absent(site: Int, *tests) -> tuple:
    """Returns 0 at once, whatever a formula is there: it may be infinite."""
    return (If((*tests, Not(is_there(site))), (Return(ZERO),)),)


def zeros(found, numbers: int) -> tuple:
    """Numbers of absent sites are 0, but for the last one where that is 1/r^2."""
    last = (compare(Index("n"), "<", total(numbers - 1)),) if found.radii else ()
    return zero_if_absent(Index("site"), *last) if found.sited else ()


def with_sites(bound, apart):
    """A bound of what all sites have alike, and those of site k: calls."""
    apart = list(apart)
    if apart and not isinstance(bound, Ordered) and bound.is_number(0):
        bound = apart.pop(0)
    for one in apart:
        bound = Ordered("+", bound, one)
    return bound
