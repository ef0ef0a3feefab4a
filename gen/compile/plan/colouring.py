"""Colours of a lattice: classes of sites that do not feel each other.

A sweep that takes one colour after the other finds the sites of a colour independent, so that a
processor works on many at once. The colour of a site is linear in its cell and place:
(weights . cell + shift[sub]) mod colours. Wrap-arounds of odd length may join equal colours; a
sweep is then still right, for it always uses the newest values.
"""
from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import gcd

MOST_COLOURS = 5


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
    bonds = [bond for over in lattices for bond in over.bonds]
    for colours in range(2, MOST_COLOURS + 1):
        for weights in product(range(colours - 1, -1, -1), repeat=dimension):
            for shift in product(range(colours), repeat=sites - 1):
                candidate = Colouring(colours, weights, (0, *shift))
                if usable(candidate) and separates(candidate, bonds):
                    return candidate
    return one_colour(lattices[0])


def one_colour(over) -> Colouring:
    """All sites alike: cell by cell in their order."""
    return Colouring(1, (0,) * len(over.size), (0,) * over.sites)


def usable(candidate: Colouring) -> bool:
    """Rows along the fastest direction hold one colour, or each colour at equal strides."""
    first = candidate.weights[0]
    return gcd(first, candidate.colours) == 1 or not any(candidate.weights)


def separates(candidate: Colouring, bonds) -> bool:
    for bond in bonds:
        members = list(dict.fromkeys(bond))
        seen = {candidate.of(sub, offset) for sub, offset in members}
        if len(seen) < len(members):
            return False
    return True
