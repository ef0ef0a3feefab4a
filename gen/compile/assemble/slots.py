"""The slots of a lattice by rows as numbers, at most: how much memory its states take."""
from __future__ import annotations

from math import prod

from ...resources import runtime_numbers
from .part import MOST_LANES


COMPOSED = 8        # increments that a composition keeps, as `composed` of gen/methods.py says


class Slots:
    """As runtime/lattice/smg_rows.h has them; found: a lattice; rings: its directions that close, as bits; value: the number that a size is."""

    def __init__(self, found, rings: int, size, value):
        first, *others = sizes = [value(size(n)) for n in found.over.size]
        length = -(-first // found.step)
        row = length if length < number("SMG_LONG_ROW") else whole_vectors(length)
        self.colours, self.ends = found.colours.colours, number("SMG_BEFORE") + number("SMG_AFTER")
        self.colour = whole_vectors(found.ranks * prod(others) * row)
        seam = any(rings >> d & 1 and w * n % self.colours for d, (w, n) in enumerate(zip(found.colours.weights, sizes)))
        self.kept_from = 0 if seam or found.meet or self.colours == 1 else self.colour

    @property
    def pitch(self) -> int:
        """smg_pitch."""
        return self.colours * self.colour + self.ends

    def arrays(self, of_midpoints: bool, stages: int | None = None, tangent: bool = False) -> int:
        """Those of smg_row_layout; stages: of a composition; tangent: with the tangent map."""
        history = COMPOSED + min(stages, COMPOSED) if stages else 5 if self.colours <= 2 else 4
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
