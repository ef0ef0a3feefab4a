"""Colours of a lattice: classes of sites that do not feel each other.

A sweep that takes one colour after the other finds the sites of a colour independent, so that a
processor works on many at once. The colour of a site is linear in its cell and place:
(weights . cell + shift[sub]) mod colours. Wrap-arounds of odd length may join equal colours; a
sweep is then still right, for it always uses the newest values.
"""
from __future__ import annotations

from dataclasses import dataclass
from itertools import islice, product
from math import gcd, prod

MOST_COLOURS = 8
FEW_KINDS, KNOWN = 300, 1000    # kinds of rows: of a colouring that is taken first; at most
LOOKED_AT = 1000        # colourings with the fewest colours, of which one of few kinds of rows is taken


@dataclass(frozen=True)
class Colouring:
    colours: int
    weights: tuple
    shift: tuple

    def of(self, sub: int, offset) -> int:
        return (sum(a * b for a, b in zip(self.weights, offset)) + self.shift[sub]) % self.colours


def colouring(lattices) -> Colouring:
    """The fewest colours that keep the members of every bond apart; one colour when none do."""
    dimension, sites = len(lattices[0].size), lattices[0].sites
    bonds = [list(dict.fromkeys(bond)) for over in lattices for bond in over.bonds]
    for colours in range(2, MOST_COLOURS + 1):
        some = list(islice(colourings(colours, dimension, sites, bonds), LOOKED_AT))
        if some:
            return next((c for most in (FEW_KINDS, KNOWN) for c in some if kinds_of_rows(c, lattices) <= most), some[0])
    return one_colour(lattices[0])


def colourings(colours: int, dimension: int, sites: int, bonds):
    """Those that keep the members of every bond apart, in order: by weights, then by shifts."""
    for weights in product(range(colours - 1, -1, -1), repeat=dimension):
        if usable(Colouring(colours, weights, (0,))):
            yield from (Colouring(colours, weights, shift) for shift in shifts(colours, weights, (0,), sites, bonds))


def shifts(colours: int, weights: tuple, found: tuple, sites: int, bonds):
    """Those that continue the ones of the first places of a cell."""
    last = len(found) - 1
    if not all(separates(Colouring(colours, weights, found), bond) for bond in bonds if max(sub for sub, _ in bond) == last):
        return
    if len(found) == sites:
        yield found
    for shift in range(colours) if len(found) < sites else ():
        yield from shifts(colours, weights, (*found, shift), sites, bonds)


def kinds_of_rows(c: Colouring, lattices) -> int:
    """SMG_KNOWN of smg_rows.h."""
    sites, step = lattices[0].sites, c.colours if any(c.weights) else 1
    ranks = sites if step > 1 else sites // c.colours
    reach = [max(abs(a[1][d] - b[1][d]) for over in lattices for bond in over.bonds for a in bond for b in bond) for d in range(1, len(lattices[0].size))]
    return c.colours * ranks * step * (2 * (reach or [0])[0] + step) * prod(2 * r + 1 for r in reach[1:])


def one_colour(over) -> Colouring:
    """All sites alike: cell by cell in their order."""
    return Colouring(1, (0,) * len(over.size), (0,) * over.sites)


def usable(candidate: Colouring) -> bool:
    """Rows along the fastest direction hold one colour, or each colour at equal strides."""
    first = candidate.weights[0]
    return gcd(first, candidate.colours) == 1 or not any(candidate.weights)


def separates(candidate: Colouring, members) -> bool:
    """Have they different colours?"""
    return len({candidate.of(sub, offset) for sub, offset in members}) == len(members)
