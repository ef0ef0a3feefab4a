"""Terms whose bonds differ by their vectors, `r(i, j)`, as several terms: the bonds of each have one vector, which stands in its formula as a number.

So all that serves bonds that are alike, as rows in lanes, serves them. Bonds whose number the formula names stay together, since they are numbered through all of them.
"""
from __future__ import annotations

from dataclasses import replace

from ..language.expr import Elem, Expr, Num, Op, Weight
from ..language.spec import Lattice, Spec


def by_bond(spec: Spec) -> Spec:
    """The same motion by effects whose bonds are alike. Observables, which are sums and no more, stay."""
    found = split(spec)
    apart = tuple(part for some in found.values() for part in some)
    return spec if apart == spec.effects else replace(spec, effects=apart)


def split(spec: Spec) -> dict[str, tuple]:
    """Name of each effect -> the effects that it is made of."""
    names = {e.name for e in (*spec.effects, *spec.observables)}
    return {e.name: parts(e, names) for e in spec.effects}


def parts(effect, names: set) -> tuple:
    """An effect for each vector; names: those that are taken."""
    over = effect.over
    if not isinstance(over, Lattice) or not over.columns or over.number:
        return (effect,)
    rows = list(zip(*(values for _, values in over.columns)))
    found = []
    for row in dict.fromkeys(rows):
        bonds = tuple(bond for bond, other in zip(over.bonds, rows) if other == row)
        numbers = {name: Num(value) for (name, _), value in zip(over.columns, row)}
        found.append(effect.mapped(lambda _, b=bonds: replace(over, bonds=b, columns=()), lambda e, n=numbers: filled(e, n)))
    return tuple(replace(one, name=free(f"{effect.name}_{k + 1}_of_{len(found)}", names)) for k, one in enumerate(found)) if len(found) > 1 else tuple(found)


def free(name: str, names: set) -> str:
    """A name that no effect has."""
    while name in names:
        name += "x"
    return name


def filled(e: Expr, numbers: dict) -> Expr:
    """The formula with numbers in place of weights."""
    if isinstance(e, Weight):
        return numbers.get(e.name, e)
    if isinstance(e, Elem):
        return Elem(e.name, filled(e.index, numbers))
    return Op(e.op, tuple(filled(a, numbers) for a in e.args)) if isinstance(e, Op) else e
