"""Colours of a lattice: classes of sites that are solved at once, and that do not feel each other where few colours are enough for that.

A sweep that takes one colour after the other finds the sites of a colour independent, so that a
processor works on many at once. The colour of a site is linear in its cell and place:
(weights . cell + shift[sub]) mod colours. Wrap-arounds of odd length may join equal colours; a
sweep is then still right, for it always uses the newest values, and so it is where bonds join
sites of one colour (`row_colouring`); but only sites that do not feel each other may be shared
by threads and ranks.
"""
from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, islice, product
from math import gcd, prod

from ...resources import runtime_numbers

MOST_COLOURS = 8
# slots beside a row that vectors may reach into; from which a row takes whole vectors, and those of one
REACH, LONG_ROW, VECTOR = (runtime_numbers()[name][0] for name in ("SMG_BEFORE", "SMG_LONG_ROW", "SMG_WIDEST"))
FEW_KINDS, KNOWN = 300, 1000    # kinds of rows: of a colouring that is taken first; at most
LOOKED_AT = 1000        # colourings with the fewest colours, of which one of few kinds of rows is taken
MOST_TRIED = 100_000    # shifts that are tried of each number of colours; then there is none with so many, or none but those found


@dataclass(frozen=True)
class Colouring:
    colours: int
    weights: tuple
    shift: tuple

    @property
    def step(self) -> int:
        """Cells along direction 0 from one site of a colour to the next."""
        return self.colours if any(self.weights) else 1

    def row_length(self, cells: int) -> int:
        """Slots of a colour in a row of so many cells, as smg_row_length has it."""
        slots = -(-cells // self.step)
        return slots if slots < LONG_ROW else -(-slots // VECTOR) * VECTOR

    def of(self, sub: int, offset) -> int:
        return (sum(a * b for a, b in zip(self.weights, offset)) + self.shift[sub]) % self.colours


def colouring(lattices) -> Colouring:
    """The fewest colours that keep the members of every bond apart; one colour when none do, or none is found by so many trials."""
    return colouring_of_bonds(len(lattices[0].size), lattices[0].sites, tuple(bonds_of(lattices)))


def row_colouring(lattices, sizes) -> Colouring:
    """For sweeps by rows of cells of these `sizes`. The fewest colours that keep bonds apart, if they fit the rings or are two; else four in place of three, if those do. Else colours in which bonds
    join sites, but no more than half of the pairs where others serve: a sweep then needs more turns, but takes less time than one over many short rows with seams."""
    fewest = colouring(lattices)
    apart = fewest.colours > 1 and serves(fewest, lattices)
    if apart and (fewest.colours == 2 or fit(fewest, lattices, sizes)):
        return fewest
    found = four_that_fit(lattices, sizes, fewest) or first_joining(lattices, (2, 1, *range(3, MOST_COLOURS + 1))) or fewest
    return fewest if apart and 2 * met(found, lattices) > len(pairs_of(lattices)) else found


def field_colouring(lattices) -> Colouring:
    """For the field of all sites at once: one colour, or as few as bonds that reach far along rows need."""
    return first_joining(lattices, range(1, MOST_COLOURS + 1)) or colouring(lattices)


def first_joining(lattices, numbers) -> Colouring | None:
    """The first of these numbers of colours that serves; which does not depend on the weights that are taken, as long as rows hold all colours."""
    places, others = lattices[0].sites, (0,) * (len(lattices[0].size) - 1)
    served = next((n for n in numbers if serves(Colouring(n, (int(n > 1), *others), (0,) * places), lattices)), None)
    return None if served is None else joining(lattices, served)


def four_that_fit(lattices, sizes, fewest: Colouring) -> Colouring | None:
    """Four colours that fit the rings of a lattice of several directions on which the fewest are three and do not. They fit the halves of its rings as well, so that it may stand in blocks."""
    if fewest.colours != 3 or len(sizes) == 1:
        return None
    some = islice(colourings(4, len(sizes), lattices[0].sites, pairs_of(lattices)), LOOKED_AT)
    return next((c for c in some if fit(c, lattices, sizes) and serves(c, lattices)), None)


def joining(lattices, colours: int) -> Colouring:
    """So many colours, in which bonds join few pairs of places."""
    pairs, directions, places = pairs_of(lattices), len(lattices[0].size), lattices[0].sites
    weights = [w for w in product(range(colours - 1, -1, -1), repeat=directions) if gcd(w[0], colours) == 1]
    return min((Colouring(colours, w, least_shifts(colours, w, places, pairs)) for w in weights), key=lambda c: met(c, lattices))


def met(c: Colouring, lattices) -> int:
    """How many pairs of places of one colour bonds join."""
    return sum(joined(c.colours, c.weights, c.shift, pair) for pair in pairs_of(lattices))


def least_shifts(colours: int, weights, places: int, pairs) -> tuple:
    """Place after place, each so that bonds join it to few of the earlier ones."""
    found = ()
    for k in range(places):
        behind = [pair for pair in pairs if pair[0] == k]
        found += (min(range(colours), key=lambda s: sum(joined(colours, weights, (*found, s), pair) for pair in behind)),)
    return found


def joined(colours: int, weights, shift, pair) -> bool:
    """Have the sites of a pair of `apart_from` one colour?"""
    a, b, cells = pair
    return (shift[a] - shift[b] - sum(w * n for w, n in zip(weights, cells))) % colours == 0


def keeps_apart(c: Colouring, lattices) -> bool:
    """Have the members of every bond different colours?"""
    return met(c, lattices) == 0


def even(c: Colouring) -> bool:
    """Has each colour as many sites as the others?"""
    return c.step > 1 or len({c.shift.count(k) for k in range(c.colours)}) == 1


def serves(c: Colouring, lattices) -> bool:
    """May such a lattice be swept by rows? With as many sites of each colour, bonds that reach no farther along rows than vectors may, and few kinds of rows."""
    near = all(abs(a[1][0] - b[1][0]) <= REACH * c.step for bond in bonds_of(lattices) for a in bond for b in bond)
    return even(c) and near and kinds_of_rows(c, lattices) <= KNOWN


def fit(c: Colouring, lattices, sizes) -> bool:
    """Do colours go on around all periodic directions as they are within?"""
    return seam(c, lattices, sizes) is None


def seam(c: Colouring, lattices, sizes) -> int | None:
    """The first periodic direction around which they do not."""
    rings = {d for over in lattices for d, closes in enumerate(over.periodic) if closes}
    return next((d for d in sorted(rings) if c.weights[d] * sizes[d] % c.colours), None)


def bonds_of(lattices) -> dict:
    return dict.fromkeys(bond for over in lattices for bond in over.bonds)


@lru_cache(maxsize=256)
def colouring_of_bonds(dimension: int, sites: int, bonds: tuple) -> Colouring:
    """The same, by the number of directions, the places of a cell, and the bonds of all lattices."""
    apart = apart_from(bonds)
    for colours in range(2, MOST_COLOURS + 1) if bonds else ():
        some = list(islice(colourings(colours, dimension, sites, apart), LOOKED_AT))
        if some:
            return next((c for most in (FEW_KINDS, KNOWN) for c in some if kinds(c, sites, bonds) <= most), some[0])
    return Colouring(1, (0,) * dimension, (0,) * sites)


def pairs_of(lattices) -> list:
    return apart_from(tuple(bonds_of(lattices)))


@lru_cache(maxsize=256)
def apart_from(bonds) -> list:
    """Pairs of sites that a bond joins: (place, an earlier or the same one, cells from the first to the second)."""
    pairs = [max(pair, pair[::-1]) for bond in bonds for pair in combinations(dict.fromkeys(bond), 2)]
    return list(dict.fromkeys((a, b, tuple(y - x for x, y in zip(one, other))) for (a, one), (b, other) in pairs))


def colourings(colours: int, dimension: int, sites: int, apart):
    """Those that keep such pairs apart, in order: by weights, then by shifts; none is tried where a cell alone needs more colours."""
    within, trials = [[(b, 0) for a, b, cells in apart if a == k and not any(cells)] for k in range(sites)], Trials(MOST_TRIED)
    if next(shifts(colours, within, (), trials, alike=True), None) is None:
        return
    for weights in product(range(colours - 1, -1, -1), repeat=dimension):
        ahead = [(a, b, sum(w * n for w, n in zip(weights, cells)) % colours) for a, b, cells in apart]
        if usable(Colouring(colours, weights, (0,))) and all(far or a != b for a, b, far in ahead):
            others = [[(b, far) for a, b, far in ahead if a == k and a != b] for k in range(sites)]
            yield from (Colouring(colours, weights, shift) for shift in shifts(colours, others, (), trials))


class Trials:
    """How many are left."""

    def __init__(self, left: int):
        self.left = left

    def more(self) -> bool:
        self.left -= 1
        return self.left >= 0


def shifts(colours: int, others: list, found: tuple, trials: Trials, alike: bool = False):
    """Those that continue the ones of the first places of a cell, of which the first is 0; others: of each place, (an earlier
    one, by how much its colour must not differ). alike: a place takes a colour that is used or the next one, so that of those
    that differ by the names of their colours there is one."""
    if len(found) == len(others):
        yield found
        return
    wrong = {(found[b] + far) % colours for b, far in others[len(found)]}
    most = max(found, default=-1) + 2 if alike or not found else colours
    for shift in range(min(most, colours)):
        if shift not in wrong and trials.more():
            yield from shifts(colours, others, (*found, shift), trials, alike)


def kinds_of_rows(c: Colouring, lattices) -> int:
    """SMG_KNOWN of smg_rows.h."""
    return kinds(c, lattices[0].sites, bonds_of(lattices))


def kinds(c: Colouring, sites: int, bonds) -> int:
    step = c.step
    ranks = sites if step > 1 else sites // c.colours
    reach = [max(abs(a[1][d] - b[1][d]) for bond in bonds for a in bond for b in bond) for d in range(1, len(c.weights))]
    return c.colours * ranks * step * (2 * (reach or [0])[0] + step) * prod(2 * r + 1 for r in reach[1:])


def one_colour(over) -> Colouring:
    """All sites alike: cell by cell in their order."""
    return Colouring(1, (0,) * len(over.size), (0,) * over.sites)


def usable(candidate: Colouring) -> bool:
    """Rows along the fastest direction hold one colour, or each colour at equal strides."""
    first = candidate.weights[0]
    return gcd(first, candidate.colours) == 1 or not any(candidate.weights)
