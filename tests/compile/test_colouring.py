"""Colours of a lattice: the first of all in their order, found with bounded work."""
import dataclasses
from itertools import islice, product
from math import gcd
from types import SimpleNamespace

import numpy as np
import pytest

import smidgen
from smidgen.check.witness.splittings import first_rule
from smidgen.compile.plan import colouring as module
from smidgen.compile.plan.colouring import FEW_KINDS, KNOWN, LOOKED_AT, MOST_COLOURS, MOST_TRIED, Colouring, Trials
from smidgen.compile.plan.colouring import colouring, field_colouring, fit, keeps_apart, kinds_of_rows, row_colouring, serves
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


# For sweeps by rows

RINGS = {("triangular(n, n)", (64, 100)): 4, ("triangular(n, n)", (64, 50)): 4, ("triangular(n, n)", (66, 99)): 3, ("triangular(n, n)", (64, 49)): 2, ("square(n, n)", (8, 8)): 2, ("square(n, n)", (5, 7)): 2,
         ("fcc(n, n, n)", (4, 4, 4)): 4, ("fcc(n, n, n)", (5, 4, 4)): 2, ("kagome(n, n)", (6, 6)): 3, ("chain(n, open, 3)", (64,)): 2}


@pytest.mark.parametrize("over, sizes", RINGS)
def test_colours_by_rows_fit_the_rings_or_are_two(over, sizes):
    found = row_colouring([named(over)], sizes)
    assert found.colours == RINGS[over, sizes] and keeps_apart(found, [named(over)]) == (found.colours > 2 or colouring([named(over)]).colours == 2)


def test_one_direction_has_no_four_in_place_of_three():
    further = closed(((0, (0,)), (0, (1,))), ((0, (0,)), (0, (2,))))
    assert [row_colouring([further], [n]) for n in (63, 64)] == [colouring([further]), Colouring(2, (1,), (0,))] and colouring([further]).colours == 3


def test_open_directions_have_no_seam():
    over = named("triangular(n, n)")
    assert row_colouring([dataclasses.replace(over, periodic=(False, False))], (64, 64)).colours == 3
    assert row_colouring([dataclasses.replace(over, periodic=(True, False))], (64, 65)).colours == 4


def closed(*bonds):
    return SimpleNamespace(size=(0,) * len(bonds[0][0][1]), sites=1, periodic=(True,) * len(bonds[0][0][1]), bonds=bonds)


def shells(squares: int, dimension: int):
    """All bonds up to a distance."""
    ends = [o for o in product(range(-6, 7), repeat=dimension) if 0 < sum(n * n for n in o) <= squares and o > (0,) * dimension]
    return closed(*(((0, (0,) * dimension), (0, end)) for end in ends))


def along(reach: int):
    return closed(*(((0, (0,)), (0, (k,))) for k in range(1, reach + 1)))


MANY = {"square, r < 4": (shells(9, 2), 2), "cubic, r < 3": (shells(4, 3), 2), "cubic, r < 5": (shells(16, 3), 2), "chain to 12": (along(12), 2), "chain to 20": (along(20), 3),
        "of many kinds": (closed(((0, (0, 0, 0)), (0, (1, 0, 0))), ((0, (0, 0, 0)), (0, (1, 11, 11))), ((0, (0, 0, 0)), (0, (1, 10, 11)))), 1)}


@pytest.mark.parametrize("name", MANY)
def test_lattices_with_many_neighbours_go_by_rows(name):
    """Where no eight colours keep bonds apart, or rows would be of too many kinds."""
    some, colours = MANY[name]
    found = row_colouring([some], (48,) * len(some.size))
    assert found.colours == colours and serves(found, [some]) and not keeps_apart(found, [some])


def test_invented_rings_have_colours_that_serve():
    dice, kinds_of = np.random.default_rng(2), set()
    for _ in range(300):
        one = invented(dice)
        lattice = SimpleNamespace(size=one.size, sites=one.sites, bonds=one.bonds, periodic=tuple(dice.integers(2, size=len(one.size)) > 0))
        sizes = [int(n) for n in dice.integers(1, 9, len(one.size))]
        found = row_colouring([lattice], sizes)
        separate = all(separates(found, dict.fromkeys(bond)) for bond in one.bonds)
        assert serves(found, [lattice]) and separate == keeps_apart(found, [lattice])
        assert found.colours <= 2 or fit(found, [lattice], sizes) or found == colouring([lattice])
        kinds_of.add((found.colours, separate))
    assert {(2, True), (2, False), (3, True), (4, True)} <= kinds_of


def test_two_colours_separate_half_of_the_bonds_or_none_are_joined():
    """Two that separate none would leave sweeps as slow as those of one colour."""
    further = closed(((0, (0, 0)), (0, (2, 0))), ((0, (0, 0)), (0, (0, 2))))
    assert row_colouring([further], (10, 10)) == colouring([further]) and colouring([further]).colours == 3


def test_as_few_bonds_as_may_be_join_sites_of_one_colour():
    lattice = named("triangular(n, n)")

    def met(c):
        return sum(not separates(c, bond) for bond in lattice.bonds)
    every = [Colouring(2, (1, w), (0,)) for w in (0, 1)]
    assert met(row_colouring([lattice], (64, 49))) == min(map(met, every)) == 1


def test_fields_take_one_colour_where_bonds_do_not_reach_far():
    assert [field_colouring([some]).colours for some in (named("fcc(n, n, n)"), along(8), along(9))] == [1, 1, 2]


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


def test_no_colours_are_tried_that_cannot_serve(monkeypatch):
    """A large cell whose bonds reach far has rows of too many kinds, whatever the colours."""
    tried = []
    monkeypatch.setattr(module, "joining", lambda *given: tried.append(given))
    dice = np.random.default_rng(3)
    ends = dice.integers(24, size=(300, 2)), dice.integers(-3, 4, size=(300, 3))
    lattice = SimpleNamespace(size=(0,) * 3, sites=24, periodic=(True,) * 3, bonds=tuple(((int(a), (0, 0, 0)), (int(b), tuple(map(int, o)))) for (a, b), o in zip(*ends)))
    assert not serves(row_colouring([lattice], (8, 8, 8)), [lattice]) and not serves(field_colouring([lattice]), [lattice]) and tried == []


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
