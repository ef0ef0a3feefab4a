"""Bonds of a lattice that are numbered: how many there are, and arrays with an entry for each."""
from __future__ import annotations

import math
from collections import Counter
from typing import Iterator

from ..language import codes
from ..language.expr import Elem, Idx, Num, Op, walk
from ..language.spec import Lattice, Term
from .names import plural
from .trouble import Trouble
from .values import integer


def bond_lengths(over: Lattice, bond) -> list:
    """(size, what the bond spans of it between open ends) of each direction."""
    spans = [[0, *(offset[d] for _, offset in bond)] if not periodic else [0] for d, periodic in enumerate(over.periodic)]
    return [(size, max(span) - min(span)) for size, span in zip(over.size, spans)]


def number_of_bonds(over: Lattice, values: dict) -> int:
    return sum(math.prod(max(0, integer(size, values) - span) for size, span in bond_lengths(over, bond)) for bond in over.bonds)


def all_bonds(over: Lattice) -> str:
    """The same as a formula."""
    found = Counter("*".join(f"({factor(size)} - {span})" if span else factor(size) for size, span in bond_lengths(over, bond)) for bond in over.bonds)
    text = " + ".join(f"{times}*{one}" if times > 1 else one for one, times in found.items())
    return text[1:-1] if text.startswith("(") and text.count("(") == 1 and text.endswith(")") else text


def one_for_each_bond(term: Term, over: Lattice, path: tuple, values: dict) -> Iterator[Trouble]:
    """Arrays by the number of a bond have as many entries as there are bonds."""
    number, bonds = Idx(over.number, bond=True), number_of_bonds(over, values)
    for e in {e.name: e for e in walk(term.value) if isinstance(e, Elem)}.values():
        width = 3 if e.index in [Op("+", (Op("*", (Num(3), number)), Num(k))) for k in range(3)] else 1
        if (width == 3 or e.index == number) and len(values[e.name]) != width * bonds:
            yield Trouble(path, codes.COUNT, f"`{e.name}` has {plural(len(values[e.name]) // width, 'number' if width == 1 else 'vector')} for {plural(bonds, 'bond')}",
                          f"give one for each bond, `size = \"{all_bonds(over)}\"`, in their order", part=e)


def factor(e) -> str:
    """A count as a factor of a product."""
    if not isinstance(e, Op):
        return str(e.value) if isinstance(e, Num) else e.name
    if e.op == "*":
        return "*".join(map(factor, e.args))
    return f"(-{factor(e.args[0])})" if e.op == "neg" else f"({f' {e.op} '.join(map(factor, e.args))})"
