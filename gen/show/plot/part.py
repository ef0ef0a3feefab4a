"""A part of a lattice: ranges of coordinates, and the layer of three dimensions that is seen."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import UsageError

FLAT = 1e-6         # of the extent: thinner is flat


@dataclass(frozen=True)
class Seen:
    """What a picture shows. sites: their numbers; axes: the two coordinates that are drawn, across and up; said: of a layer, what to say."""
    sites: np.ndarray
    axes: tuple[int, int]
    said: str = ""

    @property
    def towards(self) -> int:
        """The coordinate that points to the viewer."""
        return 3 - sum(self.axes)


def part_of(given) -> dict:
    """axis -> (low, high) or a number, of `"x=0:20, z=1.5"` or of such a dictionary. Raises UsageError."""
    if given is None:
        return {}
    pairs = given.items() if hasattr(given, "items") else [split(piece) for piece in str(given).split(",")]
    found = {axis: span(axis, value) for axis, value in pairs}
    if sum(isinstance(value, float) for value in found.values()) > 1:
        raise UsageError("a part has at most one layer, such as z=1.5; others are ranges, such as x=0:20")
    return found


def split(piece: str):
    """`x=0:20` as ("x", ["0", "20"])."""
    axis, equals, value = (text.strip() for text in piece.partition("="))
    if not equals:
        raise UsageError(f"a part is written x=0:20,y=5:15 (ranges) or z=1.5 (a layer), not '{piece.strip()}'")
    return axis, value.split(":") if ":" in value else value


def span(axis: str, value):
    """A range, or the place of a layer. Raises UsageError."""
    if axis not in ("x", "y", "z"):
        raise UsageError(f"a part refers to x, y or z, not '{axis}'")
    try:
        numbers = [float(v) for v in ([value] if np.ndim(value) == 0 else value)]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (1, 2) or not all(map(math.isfinite, numbers)):
        raise UsageError(f"'{axis}' of a part must be a number or a range low:high, not {value!r}")
    if len(numbers) == 2 and not numbers[0] < numbers[1]:
        raise UsageError(f"the range of '{axis}' is empty: {numbers[0]:g} is not below {numbers[1]:g}")
    return tuple(numbers) if len(numbers) == 2 else numbers[0]


def seen(where, part: dict) -> Seen:
    """The sites of a part, of one layer where they fill three dimensions. Raises UsageError where there is none."""
    extent = np.ptp(where, axis=0)
    grain = FLAT * extent.max()
    thick = [d for d in range(3) if extent[d] > grain]
    layer = next((("xyz".index(axis), value) for axis, value in part.items() if isinstance(value, float)), None)
    if layer is None and len(thick) == 3:
        layer = 2, fullest(where[:, 2], grain)
    inside, said = ranges(where, part, grain), ""
    if layer is not None:
        inside, said = in_layer(where, inside, *layer, grain)
    if not inside.any():
        raise UsageError(f"no site is in this part; the lattice extends from ({', '.join(f'{x:g}' for x in where.min(axis=0))}) "
                         f"to ({', '.join(f'{x:g}' for x in where.max(axis=0))})")
    towards = layer[0] if layer else next((d for d in (2, 1, 0) if d not in thick), 2)
    return Seen(np.flatnonzero(inside), tuple(d for d in range(3) if d != towards), said)


def layers_of(heights, grain: float):
    """(the lowest height of each layer, how many sites it has): heights within a grain of each other are one."""
    rising = np.sort(heights)
    first = np.flatnonzero(np.diff(rising, prepend=-np.inf) > grain)
    return rising[first], np.diff(first, append=len(rising))


def fullest(heights, grain: float) -> float:
    """The height at which most sites lie; of several the lowest."""
    layers, many = layers_of(heights, grain)
    return float(layers[np.argmax(many)])


def ranges(where, part: dict, grain: float):
    """Which sites lie within all ranges."""
    inside = np.ones(len(where), bool)
    for axis, value in part.items():
        if not isinstance(value, float):
            x = where[:, "xyz".index(axis)]
            inside &= (x >= value[0] - grain) & (x <= value[1] + grain)
    return inside


def in_layer(where, inside, axis: int, at: float, grain: float):
    """(which sites of them lie in the layer nearest to `at`, what to say of it)."""
    layers, _ = layers_of(where[inside, axis], grain)
    if len(layers) < 2:
        return inside, ""
    nearest = layers[np.argmin(np.abs(layers - at))]
    return inside & (np.abs(where[:, axis] - nearest) <= grain), f"the layer {'xyz'[axis]} = {nearest:g}, one of {len(layers)}"
