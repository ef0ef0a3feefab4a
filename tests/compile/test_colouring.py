"""Colours of a lattice: the first of all in their order, found with bounded work."""
from itertools import islice, product
from math import gcd
from types import SimpleNamespace

import numpy as np
import pytest

import smidgen
from smidgen.check.witness.splittings import first_rule
from smidgen.compile.plan import colouring as module
from smidgen.compile.plan.colouring import FEW_KINDS, KNOWN, LOOKED_AT, MOST_COLOURS, MOST_TRIED, Colouring, Trials
from smidgen.compile.plan.colouring import colouring, kinds_of_rows
from smidgen.language.spec import Lattice
from smidgen.resources import scenes, shipped

NAMED = {"chain(n, open, 3)": 1, "ladder(n)": 2, "square(n, n)": 1, "triangular(n, n)": 1, "honeycomb(n, n)": 2, "kagome(n, n)": 3, "cubic(n, n, n)": 1, "bcc(n, n, n)": 1,
         "fcc(n, n, n)": 1, "hcp(n, n, n)": 2, "diamond(n, n, n)": 2, "pyrochlore(n, n, n)": 4, "square(n, n).third": 1, "honeycomb(n, n).second": 2, "cubic(n, n, n).second": 1,
         "bcc(n, n, n).second": 1}


def named(over: str) -> Lattice:
    cells = "n" if "open" in over else "*".join("n" * (over.count("n,") + 1))
    sites = f"{NAMED[over]}*{cells}"
    return smidgen.load_text(f'[model]\nname = "m"\n[space]\nw = {{ sphere = "{sites}" }}\n[parameters]\nn = 6\n[effects.e]\nover = "bond(i, j) of {over}"\n'
                             'energy = "dot(w[i], w[j])"\n').effects[0].over


def separates(c: Colouring, members) -> bool:
    """Have they different colours?"""
    return len({c.of(*member) for member in members}) == len(members)


def first_of_all(lattices) -> Colouring:
    """By trying everything in order."""
    bonds, dimension, sites = [bond for over in lattices for bond in over.bonds], len(lattices[0].size), lattices[0].sites
    for colours in range(2, MOST_COLOURS + 1):
        every = (Colouring(colours, weights, (0, *shift)) for weights in product(range(colours - 1, -1, -1), repeat=dimension)
                 if gcd(weights[0], colours) == 1 or not any(weights) for shift in product(range(colours), repeat=sites - 1))
        some = list(islice((c for c in every if all(separates(c, dict.fromkeys(bond)) for bond in bonds)), LOOKED_AT))
        if some:
            return next((c for most in (FEW_KINDS, KNOWN) for c in some if kinds_of_rows(c, lattices) <= most), some[0])
    return Colouring(1, (0,) * dimension, (0,) * sites)


@pytest.mark.parametrize("over", NAMED)
def test_named_lattices_have_the_first_colouring(over):
    assert colouring([named(over)]) == first_of_all([named(over)])


def test_shipped_lattices_have_the_first_colouring():
    overs = [[e.over for e in smidgen.load(name).energies if isinstance(e.over, Lattice)] for name in {**shipped(), **scenes()}]
    assert sum(map(bool, overs)) >= 6
    for some in filter(None, overs):
        assert colouring(some) == first_of_all(some)


KNOWN_ONES = {"square(n, n)": (2, (1, 1), (0,)), "triangular(n, n)": (3, (2, 2), (0,)), "honeycomb(n, n)": (2, (0, 0), (0, 1)), "kagome(n, n)": (3, (2, 2), (0, 1, 2)),
              "fcc(n, n, n)": (4, (3, 2, 1), (0,)), "pyrochlore(n, n, n)": (4, (0, 0, 0), (0, 1, 2, 3))}


def test_known_colourings():
    """As they have been since lattices go by rows: other ones have other last digits."""
    found = {over: colouring([named(over)]) for over in KNOWN_ONES}
    assert {over: (c.colours, c.weights, c.shift) for over, c in found.items()} == KNOWN_ONES


def invented(dice):
    """Bonds of two to four ends, some of them twice the same site."""
    dimension, sites, span = dice.integers(1, 4), int(dice.integers(1, 4)), dice.integers(1, 3)

    def bond(ends):
        return tuple((int(dice.integers(sites)), tuple(int(n) for n in dice.integers(-span, span + 1, dimension) * dice.integers(0, 2, dimension))) for _ in range(ends))
    return SimpleNamespace(size=(0,) * dimension, sites=sites, bonds=tuple(bond(dice.integers(2, 5)) for _ in range(dice.integers(1, 5))))


def test_invented_lattices_have_the_first_colouring():
    dice = np.random.default_rng(1)
    for lattice in (invented(dice) for _ in range(60)):
        assert colouring([lattice]) == first_of_all([lattice])


# Work

def all_bound(places: int, dimension: int, far: bool = False):
    """All sites of a cell are bound to each other, and the first one to that of the next cell; far: the last to all of those."""
    here, there = (0,) * dimension, (1,) + (0,) * (dimension - 1)
    bonds = [((a, here), (b, here)) for a in range(places) for b in range(a)]
    ahead = [((places - 1, here), (b, there)) for b in range(places)] if far else [((0, here), (0, there))]
    return SimpleNamespace(size=(0,) * dimension, sites=places, bonds=(*bonds, *ahead))


@pytest.fixture
def counted(monkeypatch):
    """All trials of shifts, one after the other."""
    class Counted(Trials):
        def more(self):
            found.append(self)
            return super().more()
    found = []
    monkeypatch.setattr(module, "Trials", Counted)
    module.colouring_of_bonds.cache_clear()
    return found


@pytest.mark.parametrize("places, dimension", [(9, 1), (9, 3), (20, 3)])
def test_a_cell_that_needs_too_many_colours_takes_no_time(places, dimension, counted):
    assert colouring([all_bound(places, dimension)]) == Colouring(1, (0,) * dimension, (0,) * places) and len(counted) < 1000


def test_the_work_has_a_bound(counted):
    """Eight colours suffice for a cell, but the last of its sites shows for every order of the others that they do not for two cells."""
    assert colouring([all_bound(8, 2, far=True)]).colours == 1
    assert MOST_TRIED < len(counted) <= MOST_TRIED + 1000


def test_a_colouring_is_found_once(counted):
    one = all_bound(5, 2)
    assert colouring([one]) == colouring([all_bound(5, 2)]) and colouring([one]).colours == 5
    before = len(counted)
    colouring([one])
    assert len(counted) == before > 0


# The witness, which finds them for itself

@pytest.mark.parametrize("over", NAMED)
def test_the_witness_has_the_same_colours(over):
    same_rule(named(over))


def test_the_witness_has_the_same_colours_of_invented_lattices():
    """Also of cells that need six colours and more, or too many."""
    dice = np.random.default_rng(2)
    for lattice in (*(invented(dice) for _ in range(60)), *(all_bound(places, 1) for places in range(5, 11)), all_bound(4, 3)):
        same_rule(lattice)


def same_rule(lattice):
    found, rule = colouring([lattice]), first_rule([lattice])
    assert (rule and (rule.number, rule.weights, rule.shift)) == (None if found.colours == 1 else (found.colours, found.weights, found.shift))
