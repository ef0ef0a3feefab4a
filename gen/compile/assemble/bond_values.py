"""Bonds that differ from cell to cell, on lattices by rows: what the numbers of their sites decide stands in arrays by slots, one for each of
the bonds of a site, which the gradient loads in lanes as it does that of `site_values.py`.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from ...language.spec import Lattice
from ..lower.code import Argument, Assign, Call, Function, If, Let, Name, Return, Scope, Variable, mentions
from ..lower.integers import ZERO, Computed, Index, Int, compare, total, whole
from ..lower.kernels import COEFFICIENTS
from .families import returned
from .site_values import Sited, is_there, lane_gradient, parted

SITE = (COEFFICIENTS, Argument("int64_t", "k"))


@dataclass(frozen=True)
class End:
    """One end of a bond, as a site at another end sees it; beside: its number among what stands beside that site, None at that site itself; first: the first site of its family; lacking: may it be absent?"""
    beside: int | None
    first: Int
    lacking: bool

    def site(self, n: int) -> Int:
        """The n-th end: site k, or the one beside it."""
        return Index("k") if self.beside is None else Index(f"end{n}")


@dataclass(frozen=True)
class Role:
    """A site feels a term by a slot, through a bond with these ends; number: the function that gives the number of the bond from the site in its base cell, which is the base-th end, where the formula asks."""
    slot: int
    bond: tuple
    ends: tuple
    number: str
    base: int

    @property
    def sites(self) -> tuple:
        """The ends, as their families number them."""
        return tuple(end.site(n) - end.first for n, end in enumerate(self.ends))

    @property
    def others(self) -> list:
        """(number, end) of those that are not site k."""
        return [(n, end) for n, end in enumerate(self.ends) if end.beside is not None]


@dataclass(frozen=True)
class Bonded(Sited):
    """A term on bonds; numbers: the functions of the numbers of its bonds; roles: for each place the `Role`s in which its sites feel it; place: that of site k; ends: the functions of the bounds of one bond, by slot: (of the
    field of no spins, of the Hessian)."""
    roles: tuple = ()
    place: Int = ZERO
    ends: tuple = ()
    numbers: tuple = ()

    @property
    def width(self) -> int:
        return len(self.values) * max(map(len, self.roles))

    @property
    def functions(self) -> list:
        return [*self.numbers, *[f for pair in self.ends for f in pair if f is not None], *super().functions]

    def at(self, sub: int, k: int, bond) -> Sited:
        """With the number of the first value of a role."""
        n = next(n for n, role in enumerate(self.roles[sub]) if (role.slot, role.bond) == (k, bond))
        return replace(self, first=self.first + n * len(self.values))

    def calls(self) -> list:
        """The statements that return each number of a site, in their order; 0 where it has none."""
        return [self.returned(n // len(self.values), self.values[n % len(self.values)]) for n in range(self.width)]

    def bound(self, f: Function) -> Call:
        return Call(f.name, (Name("c"), Index("k")))

    def returned(self, n: int, f: Function) -> tuple:
        """Of the n-th role of each place."""
        return (Let("k", Index("site")), *by_sub(self.roles, self.place, lambda some: found_end(some[n], (Return(ended(f, some[n])),)) if n < len(some) else ()), Return(ZERO))


def unlike_bonds(t) -> bool:
    """Is it a term on bonds, all of whose ends it names, whose gradient depends on their numbers?"""
    gradient = next(f for f in t.functions if f.name == f"{t.prefix}_gradient")
    named = isinstance(t.over, Lattice) and len(t.slots) == len(t.over.indices) > 1 and {slot for _, slot in t.slots} == set(t.over.indices)
    told = named and (not t.over.number or len(set(t.over.bonds)) == len(t.over.bonds))      # a bond that is listed twice has two numbers
    return told and bool(set(t.over.bound) & mentions(*gradient.body))


def bonded(low, t, first: int, homes, roles, place, bounds, numbers=()) -> Bonded:
    """bounds(k): (of the field of no spins, of the Hessian) of one bond in the row of slot k; None where nobody asks."""
    gradient, values = bond_partings(low, t)
    functions = tuple(of_bond(low, t, symbol.name, e) for e, symbol in values.items())
    ends = tuple(tuple(None if e is None or e == 0 else of_bond(low, t, f"{what}{k}", e) for what, e in zip(("rest", "norm"), bounds(k))) for k in range(len(t.slots)))
    sums = [sum_of(t, what, n, roles, place, ends) if any(end[n] for end in ends) else None for n, what in enumerate(("rest", "norm"))]
    return Bonded(lane_gradient(low, t, gradient, values), functions, first, *sums, homes, roles, place, ends, tuple(numbers))


def number_functions(loops, t, over) -> list:
    """The number of each bond of the list, from the site in its base cell; over: the bonds as the families number their sites."""
    place = tuple(line for line in loops.cell_of_site(over) if line.name != "sub")
    cells = [Index(f"s{d}") for d in range(len(over.size))]
    return [Function("int64_t", number_name(t, n), (COEFFICIENTS, Argument("int64_t", "site")), (*place, Return(loops.bond_number(over, n, cells))))
            for n in range(len(over.bonds)) if over.number]


def number_name(t, n: int) -> str:
    return f"{t.prefix}_number_of_bond{n}"


def bond_partings(low, t) -> tuple:
    values: dict = {}
    return [parted(low, low.number_values(x), values) for row in t.derived.gradient for x in row], values


def numbers_of(low, t, roles) -> int:
    return len(bond_partings(low, t)[1]) * max(map(len, roles))


def of_bond(low, t, what: str, e) -> Function:
    """A number of a bond."""
    arguments = (COEFFICIENTS, *(Argument("int64_t", i) for i in t.over.bound))
    return Function("smg_real", f"{t.prefix}_{what}", arguments, returned(low.kernel([e], t.derived.leaves)))


def ended(f: Function, role: Role) -> Call:
    """That number of the bond of a role, of site k and those beside it."""
    number = (Computed(role.number, (Index("c"), role.sites[role.base])),) if role.number else ()
    return Call(f.name, (Name("c"), *role.sites, *number))


def found_end(role, body) -> tuple:
    """The statements where the bond of a role is not cut at an open end, and its other ends are there."""
    found = tuple(Let(f"end{n}", Computed("smg_site_beside", (Index("c"), Index("k"), whole(end.beside)))) for n, end in role.others)
    tests = (test for n, end in role.others for test in (compare(end.site(n), ">=", ZERO), *[is_there(end.site(n))] * end.lacking))
    return (*found, If(tuple(tests), body))


def by_sub(roles, place, body_of) -> tuple:
    """Statements for the sites of each place."""
    if len(roles) == 1:
        return body_of(roles[0])
    return tuple(If((compare(place, "==", total(sub)),), body_of(some)) for sub, some in enumerate(roles) if body_of(some))


def sum_of(t, what: str, n: int, roles, place, ends) -> Function:
    """A bound at site k: the sum of those of its bonds; a slot may have none, where it is 0."""
    def added(some):
        return tuple(Scope(found_end(role, (Assign(Name("sum"), ended(ends[role.slot][n], role), "+="),))) for role in some if ends[role.slot][n])
    return Function("smg_real", f"{t.prefix}_{what}", SITE, (Variable("smg_real", "sum", ZERO), *by_sub(roles, place, added), Return(Name("sum"))))
