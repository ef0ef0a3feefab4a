"""What a colour means: one rule for every figure and for the player.

    what is coloured                    its colour
    a method                            that of STYLES, with its dash and marker
    a component x, y, z                 that of COMPONENTS
    an orbit of a section               a shade of `regular`, or CHAOTIC
    a site                              that of `of_sites`
    one of an order (times, radii)      that of `ordered`, dark to bright
    a direction, of a site at its place that of `of_directions`
    a number of such a site             DIVERGING about 0, else SEQUENTIAL
    a curve alone, a line that guides   INK

Colours are those of Okabe and Ito (Color universal design, 2008), which stay apart for the
common kinds of colour blindness, and a brown. Methods, components and chaotic orbits share none.
All have a contrast of at least 3 with white paper (Web Content Accessibility Guidelines 2.2, 1.4.11): `legible` darkens
those that have less.
"""
from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.colors import to_hex, to_rgb

from ...methods import METHODS

CONTRAST = 3.7      # with white, of every colour that means something: 3 with the ball, which is darker


def luminance(color) -> float:
    """Relative luminance of a colour, 0 to 1 (sRGB, IEC 61966-2-1)."""
    c = np.array(to_rgb(color))
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(color, other="white") -> float:
    """The ratio (L1 + 0.05)/(L2 + 0.05) of the two luminances, 1 to 21."""
    dark, light = sorted((luminance(color), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def legible(color) -> str:
    """The colour itself, or the lightest of its hue that has CONTRAST with white."""
    shade, low, high = np.array(to_rgb(color)), 0.0, 1.0
    if contrast(color) >= CONTRAST:
        return to_hex(color)
    for _ in range(20):
        half = (low + high) / 2
        low, high = (half, high) if contrast(half * shade) >= CONTRAST else (low, half)
    return to_hex(low * shade)


BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BROWN = (
    legible(c) for c in ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#6B4C00"))
PALETTE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BROWN)
INK, SOFT, FAINT, SINGULAR = "#222222", "#5B6570", "#8A94A0", "#C8102E"

# method -> label, colour, dash, marker: the midpoints by name of the palette, the others in the order of the registry, compositions
# from light to dark
LOOKS = ((BLUE, "-", "o"), (VERMILION, "--", "s"), (GREEN, "-.", "^"),
         *((legible(matplotlib.colormaps["turbo"](k / 11)), (0, (1 + k, 1, 1, 1)), marker) for k, marker in enumerate("Dv<>pPhHXd*8")),
         *((legible(matplotlib.colormaps["plasma"](0.9 - 0.04 * k)), (0, (5, 1, *(1, 1) * (k % 4), 1, 2 + k)), marker)
           for k, marker in enumerate((*"1234+x|_", *((points, kind, 0) for kind in (1, 2) for points in range(3, 9))))),
         *((legible(matplotlib.colormaps["viridis"](0.95 - 0.05 * k)), (0, (8, 2, 1, 1 + k)), marker)
           for k, marker in enumerate((points, kind, 20) for kind in (1, 2) for points in range(3, 12))),
         *((legible(matplotlib.colormaps["cool"](0.05 * k)), (0, (10, 1, 2, 1 + k)), marker)
           for k, marker in enumerate((points, kind, 40) for kind in (1, 2) for points in range(3, 12))))
STYLES = {name: (method.label, *look) for (name, method), look in zip(METHODS.items(), LOOKS)}
COMPONENTS = {"x": PURPLE, "y": SKY, "z": BROWN}
CHAOTIC = ORANGE


def of_sites(counts: dict) -> dict:
    """family -> the colours of its sites, of {family: number of sites}.

    Families take from the palette in their order: one colour for each site while enough are
    left for the families that follow, else one colour in shades, dark to light by number.
    """
    found, taken = {}, 0
    for later, (name, count) in zip(reversed(range(len(counts))), counts.items()):
        own = count == 1 or taken + count + later <= len(PALETTE)
        found[name] = [palette(taken + i) for i in range(count)] if own else \
            shades(palette(taken), count)
        taken += count if own else 1
    return found


def palette(number: int) -> str:
    """Colour `number` of the palette; each further round through it is darker."""
    lap, place = divmod(number, len(PALETTE))
    return to_hex(0.6 ** lap * np.array(to_rgb(PALETTE[place])))


def shades(color: str, count: int) -> list[str]:
    """`count` shades of a colour, from dark to the lightest that is legible."""
    pure, share = np.array(to_rgb(color)), np.linspace(0, 1, count)[:, None]
    light = np.array(to_rgb(legible(pure + 0.35 * (1 - pure))))
    return [to_hex(c) for c in light * (0.3 + 0.7 * share)]


def regular(count: int) -> list[str]:
    """Colours of regular orbits, dark blue to sea green, so that neighbours can be told apart."""
    dark, light = np.array([0.0, 0.27, 0.55]), np.array([0.0, 0.62, 0.55])
    share = (np.arange(count) * 7 % max(count, 1)) / max(count - 1, 1)
    return [legible(c) for c in dark + share[:, None] * (light - dark)]


def ordered(shares) -> list[str]:
    """Colours of numbers between 0 (dark) and 1 (bright): shares of a time, of a radius."""
    return [legible(c) for c in matplotlib.colormaps["viridis"](0.75 * np.asarray(shares, float))]


# A unit vector u has the colour centre + tint u in CIELAB: lightness by u_z, hue by azimuth. x and -x differ by blue and yellow, y and -y by
# lightness too, so that a reader without red and green, or without blue, tells azimuths apart.
WHEEL = {"centre": [58, 0, 0], "tint": [[10, -18, 34], [0, 45, 0], [48, 0, 0]]}
DIVERGING, SEQUENTIAL = "coolwarm", "cividis"
_WHITE = np.array([0.95047, 1.0, 1.08883])
_RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])     # sRGB of XYZ, IEC 61966-2-1


def of_directions(u) -> np.ndarray:
    """sRGB (.., 3), 0 to 1, of unit vectors (.., 3)."""
    L, a, b = np.moveaxis(WHEEL["centre"] + np.asarray(u, float) @ np.transpose(WHEEL["tint"]), -1, 0)
    y = (L + 16) / 116
    f = np.stack([y + a / 500, y, y - b / 200], axis=-1)
    linear = np.clip(np.where(f > 6 / 29, f ** 3, (f - 4 / 29) * 108 / 841) * _WHITE @ _RGB.T, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def of_table(name: str) -> list[list[int]]:
    """33 colours of a map of matplotlib, 0 to 255."""
    return np.rint(255 * matplotlib.colormaps[name](np.linspace(0, 1, 33))[:, :3]).astype(int).tolist()
