"""The slots of a lattice by rows as numbers, at most: how much memory its states take."""
from __future__ import annotations

from math import prod

from ...resources import runtime_numbers
from ..plan.colouring import fit
from .part import MOST_LANES


class Slots:
    """As runtime/lattice/smg_rows.h has them; found: a lattice; lattices: of all bonds; value: the number that a size is."""

    def __init__(self, found, lattices, size, value):
        first, *others = sizes = [value(size(n)) for n in found.over.size]
        row = found.colours.row_length(first)
        self.colours, self.ends = found.colours.colours, number("SMG_BEFORE") + number("SMG_AFTER")
        self.colour = whole_vectors(found.ranks * prod(others) * row)
        self.kept_from = 0 if not fit(found.colours, lattices, sizes) or found.meet or self.colours == 1 else self.colour

    @property
    def pitch(self) -> int:
        """smg_pitch."""
        return self.colours * self.colour + self.ends

    def arrays(self, of_midpoints: bool, stages: int | None, kept: int, tangent: bool) -> int:
        """Those of smg_row_layout; stages: of a composition, which keeps so many increments; tangent: with the tangent map."""
        history = kept + min(stages, kept) if stages else 5 if self.colours <= 2 else 4
        of_sweeps = 3 * (1 + tangent) * (self.kept_from + self.ends) + 3 * (history + 1) * (self.pitch - self.kept_from) + (3 * (2 + stages * tangent) * self.pitch + MOST_LANES if stages else 0)
        return MOST_LANES + 9 * self.pitch + of_sweeps * of_midpoints

    def beyond(self) -> int:
        """Those of smg_place_beyond."""
        return MOST_LANES + (15 + 3 * number("SMG_PATH_ARRAYS")) * self.pitch + 3 * self.ends

    def tables(self, values: int, besides: int, kinds: int) -> int:
        """Those of smg_place_tables, with the neighbours of blocks, whether there are blocks or not; kinds: of many kinds of rows."""
        return (MOST_LANES + kinds) * (kinds > 0) + (MOST_LANES + values * self.pitch) * (values > 0) + -(-self.colours * self.colour // MOST_LANES * besides // 2)


def number(name: str) -> int:
    return runtime_numbers()[name][0]


def whole_vectors(n: int) -> int:
    return -(-n // MOST_LANES) * MOST_LANES
