"""Explicit splittings: which of them a Hamiltonian allows, found in the formulas; what stands in the way of the others.

Axes: H = A(all x) + B(all y) + C(all z), so no second derivative joins two components.
Sublattices: H is linear in every single site, so no second derivative is by one site twice.
Pairs: every term is a function of the scalar product of two sites.
"""
from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from ...errors import UsageError
from ...language.expr import Elem, Idx, Par, Time, Weight, slots_of
from ...language.spec import Lattice, Spec
from ...language.sublattice import together
from ...methods import METHODS, Method
from ..derive.derivatives import Derived, derive, index_text, switched
from ..derive.parts import expanded
from .colouring import Colouring, colouring

AXES = "xyz"
LONGEST = 80        # characters of a term that is quoted


def require_splitting(spec: Spec, method: Method) -> None:
    """Raises UsageError where the Hamiltonian does not allow the splitting of the method."""
    found = obstacle(spec, method)
    if found is not None:
        raise UsageError(f"method {method.name} {ASKED[method.splitting]}, but {found}")


def obstacle(spec: Spec, method: Method) -> str | None:
    """What stands in the way, in words: a factor of the space, or the first effect that does; None where nothing does."""
    for f in spec.families:
        if f.kind not in method.spaces:
            return f"'{f.name}' is a Nambu factor, on which the parts of H do not generate rotations"
        if f.tracer and method.splitting == "pairs":
            return f"'{f.name}' is a family of tracers, which do not act on other sites"
    derived = ((e.name, derive(e)) for e in spec.energies)
    found = ((name, "has a condition on its vectors" if switched(d) else OBSTACLES[method.splitting](d)) for name, d in derived)
    return next((f"effect '{name}' {why}" for name, why in found if why), None)


def splittings(spec: Spec) -> dict:
    """Method -> what stands in its way, None where nothing does."""
    return {m.name: obstacle(spec, m) for m in METHODS.values() if m.splitting and m.stages == 1}


# Axes

def mixing(d: Derived) -> str | None:
    """Two components that the term joins: a second derivative by both that is not zero."""
    for (k, l), block in d.hessian.items():
        for a in range(3):
            for b in range(3):
                if a != b and expanded(block[a, b]) != 0:
                    return f"joins {component(d, k, a)} and {component(d, l, b)}" + quoted(d, d.vectors[k][a], d.vectors[l][b])
    return None


def component(d: Derived, slot: int, axis: int) -> str:
    family, site = d.slots[slot]
    return f"{family}[{site}].{AXES[axis]}"


def quoted(d: Derived, x, y) -> str:
    """` in the term ..`: the first summand that joins the symbols, where the formula is whole and it is short."""
    if d.parts:
        return ""
    for term in sp.Add.make_args(expanded(d.value)):
        if sp.diff(term, x, y) != 0:
            text = written(d, term)
            return f" in the term {text}" if len(text) <= LONGEST else ""
    return ""


def written(d: Derived, e) -> str:
    """An expression as formulas of a spec are written."""
    names = {v: component(d, k, a) for k, row in enumerate(d.vectors) for a, v in enumerate(row)}
    names |= {s: leaf_text(d.leaves[s.name]) for s in e.free_symbols if s.name in d.leaves}
    return Formula().doprint(e.xreplace({s: sp.Symbol(name) for s, name in names.items()}))


def leaf_text(e) -> str:
    """A parameter, an index, an entry of an array, the time."""
    if isinstance(e, Elem):
        return f"{e.name}[{leaf_text(e.index)}]"
    return "t" if isinstance(e, Time) else e.name if isinstance(e, (Par, Idx, Weight)) else index_text(e)


class Formula(StrPrinter):
    """x^2, as specs have it."""

    def _print_Pow(self, expr, rational=False):
        if expr.exp.is_Integer and expr.exp > 1:
            return f"{self.parenthesize(expr.base, PRECEDENCE['Pow'])}^{expr.exp}"
        return super()._print_Pow(expr, rational)


# Sublattices

@dataclass(frozen=True)
class Sublattices:
    """The size and places of the lattices that all terms live on, their colours, and the directions in which bonds of some of them close: there the
    size must be a multiple of the colours.

    over: any of them, for its size and its places; of several families, with the places of all.
    """
    over: Lattice
    colours: Colouring
    closed: tuple


def bending(d: Derived) -> str | None:
    """A site in which the term is not linear: a second derivative by it that is not zero."""
    for k in range(len(d.slots)):
        block = d.hessian.get((k, k))
        for a in range(3 if block is not None else 0):
            for b in range(a, 3):
                if expanded(block[a, b]) != 0:
                    family, site = d.slots[k]
                    return f"is not linear in {family}[{site}]" + quoted(d, d.vectors[k][a], d.vectors[k][b])
    return None


def sublattices(spec: Spec) -> Sublattices | None:
    """None where sites are taken one by one: terms that live on no lattice or on several, or a family without bonds."""
    joint = [e.over for e in spec.energies if len(slots_of(e.value)) > 1]
    overs = [e.over for e in spec.energies if isinstance(e.over, Lattice)]
    if not joint or any(not isinstance(over, Lattice) for over in joint) or len({(o.size, o.sites) for o in overs}) > 1 or not all_joined(spec, joint):
        return None
    cells, directions = [together(over, [f.name for f in spec.families]) for over in overs], range(len(overs[0].size))
    colours = colouring(cells)
    return Sublattices(cells[0], colours, tuple(any(closes(over, d) for over in overs) for d in directions)) if colours.colours > 1 else None


def all_joined(spec: Spec, overs) -> bool:
    """Of several families: has each bonds, and are none tracers?"""
    homes = {name for over in overs for name in over.families or (over.family,)}
    return len(spec.families) == 1 or all(f.name in homes and not f.tracer for f in spec.families)


def closes(over: Lattice, d: int) -> bool:
    """Does a bond go on from one end of the direction at the other?"""
    return over.periodic[d] and any(len({offset[d] for _, offset in bond}) > 1 for bond in over.bonds)


# Pairs

@dataclass(frozen=True)
class BondClass:
    """Bonds of an effect of which no two meet: which one of its list, as seen from the first site, and the colour of that site."""
    effect: str
    number: int
    bond: tuple
    first: int
    colour: int


def bond_classes(spec: Spec) -> tuple:
    """The classes in which the bonds of a lattice are taken, where its rings fit the colours; none where bonds go one after the other."""
    found = sublattices(spec) if len(spec.families) == 1 else None
    joint = [e for e in spec.energies if len(slots_of(e.value)) == 2]
    bonds = [(e, n, bond) for e in joint if isinstance(e.over, Lattice) for n, bond in enumerate(e.over.bonds)]
    if found is None or not all(any(not any(offset) for _, offset in bond) for _, _, bond in bonds):
        return ()
    return tuple(BondClass(e.name, n, from_member(bond, first_member(e)), first_member(e), colour)
                 for e, n, bond in bonds for colour in colours_of(found.colours, bond[first_member(e)][0]))


def first_member(e) -> int:
    """Of a bond of two sites: the first that the effect feels."""
    return min(e.over.indices.index(index) for _, index in slots_of(e.value))


def from_member(bond, first: int) -> tuple:
    """The bond, as its cells lie from that of a member."""
    return tuple((sub, tuple(a - b for a, b in zip(offset, bond[first][1]))) for sub, offset in bond)


def colours_of(rule: Colouring, sub: int) -> tuple:
    """The colours of the sites of a place."""
    return tuple(range(rule.colours)) if any(rule.weights) else (rule.shift[sub],)


def of_the_product(d: Derived, u):
    """f(u) where the term is f(w_i.w_j), else None: its value at w_i = (u, 0, 0), w_j = (1, 0, 0), put back and compared."""
    if len(d.slots) != 2 or d.parts:
        return None
    (a, b), zero = d.vectors, sp.S.Zero
    f = d.value.xreplace({a[0]: u, a[1]: zero, a[2]: zero, b[0]: sp.S.One, b[1]: zero, b[2]: zero})
    product = sum(x * y for x, y in zip(a, b))
    if not f.has(u) or f.has(sp.nan, sp.zoo, sp.oo) or sp.expand(d.value - f.xreplace({u: product})) != 0:
        return None
    return f


def not_of_pairs(d: Derived) -> str | None:
    """A term that is no function of a scalar product."""
    if not d.slots or of_the_product(d, sp.Symbol("u", real=True)) is not None:
        return None
    if len(d.slots) != 2:
        return f"joins {len(d.slots)} sites" if len(d.slots) > 2 else "involves only a single site"
    one, other = (f"{family}[{site}]" for family, site in d.slots)
    return f"is not recognised as a function of dot({one}, {other}) alone"


ASKED = {"axes": "requires a sum of functions of single components, each of x, of y or of z alone",
         "sublattices": "requires an energy that is linear in every single site",
         "pairs": "requires a sum of functions of scalar products of two sites"}
OBSTACLES = {"axes": mixing, "sublattices": bending, "pairs": not_of_pairs}
