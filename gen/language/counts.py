"""Counts: the integer formulas that say how large families, lattices and arrays are."""
from __future__ import annotations

from .expr import Expr, Num, Par, walk
from .spec import Lattice, Spec


def sizes_of(spec: Spec):
    """Every size that the C reads: of families, of lattices, of arrays that are not compiled in."""
    yield from (f.count for f in spec.families)
    for term in (*spec.effects, *spec.observables):
        yield from term.over.size if isinstance(term.over, Lattice) else ()
    yield from (p.size for p in spec.parameters if p.kind == "array" and not p.fixed)


def runtime_names(e: Expr, parameters: dict) -> set:
    return {n.name for n in walk(e) if isinstance(n, Par) and not parameters[n.name].fixed}


def constant_integer(e: Expr, parameters: dict) -> int:
    """The value of an integer formula, with the parameters' defaults."""
    if isinstance(e, Num):
        return int(e.value)
    if isinstance(e, Par):
        return int(parameters[e.name].default)
    a = [constant_integer(x, parameters) for x in e.args]
    return {"+": lambda: a[0] + a[1], "-": lambda: a[0] - a[1], "*": lambda: a[0] * a[1],
            "/": lambda: a[0] // a[1], "neg": lambda: -a[0], "^": lambda: a[0] ** a[1],
            "mod": lambda: a[0] % a[1], "floor": lambda: a[0]}[e.op]()
