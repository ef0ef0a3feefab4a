"""Lattices by name: basis vectors, sites of a cell, and the corners of the zone.

Lengths are in units of the lattice constant: the side of the cubic cell of cubic, bcc, fcc, diamond and pyrochlore, the distance of
neighbours on a chain, ladder or square lattice, the shortest vector of the others. Cells are primitive. Corners of the zone have the names and the
coordinates of Setyawan and Curtarolo, Comp. Mater. Sci. 49 (2010) 299, in units of the reciprocal vectors.
"""
from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

Row = tuple[float, ...]


@dataclass(frozen=True)
class Crystal:
    """directions: those in which cells follow each other; vectors: (x, y, z) of these, then of those that measure positions alone; positions: fractions of all of them."""
    directions: int
    vectors: tuple[Row, ...]
    positions: tuple[Row, ...]
    corners: tuple[tuple[str, Row], ...] = ()


H = 1 / 2
THIRD = 1 / 3
SIDE = sqrt(3) / 2
HEIGHT = sqrt(8 / 3)        # of a cell of hcp: two layers of touching spheres

LINE = (("Gamma", (0,)), ("X", (H,)))
SQUARE = (("Gamma", (0, 0)), ("X", (H, 0)), ("M", (H, H)))
HEXAGON = (("Gamma", (0, 0)), ("M", (H, 0)), ("K", (THIRD, THIRD)))
CUBE = (("Gamma", (0, 0, 0)), ("X", (0, H, 0)), ("M", (H, H, 0)), ("R", (H, H, H)))
PRISM = (("Gamma", (0, 0, 0)), ("M", (H, 0, 0)), ("K", (THIRD, THIRD, 0)), ("A", (0, 0, H)), ("L", (H, 0, H)), ("H", (THIRD, THIRD, H)))
OF_BCC = (("Gamma", (0, 0, 0)), ("H", (H, -H, H)), ("P", (1 / 4, 1 / 4, 1 / 4)), ("N", (0, 0, H)))
OF_FCC = (("Gamma", (0, 0, 0)), ("X", (H, 0, H)), ("L", (H, H, H)), ("W", (H, 1 / 4, 3 / 4)), ("U", (5 / 8, 1 / 4, 5 / 8)), ("K", (3 / 8, 3 / 8, 3 / 4)))

UNIT = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
SIXTY = ((1, 0, 0), (-H, SIDE, 0))                          # 120 degrees between them, 60 between reciprocal vectors
FACES = ((0, H, H), (H, 0, H), (H, H, 0))
BODY = ((-H, H, H), (H, -H, H), (H, H, -H))

CRYSTALS = {
    "chain": Crystal(1, UNIT[:1], ((0,),), LINE),
    "ladder": Crystal(1, UNIT[:2], ((0, 0), (0, 1)), LINE),
    "square": Crystal(2, UNIT[:2], ((0, 0),), SQUARE),
    "triangular": Crystal(2, SIXTY, ((0, 0),), HEXAGON),
    "honeycomb": Crystal(2, SIXTY, ((0, 0), (THIRD, 2 * THIRD)), HEXAGON),
    "kagome": Crystal(2, SIXTY, ((0, 0), (H, 0), (H, H)), HEXAGON),
    "cubic": Crystal(3, UNIT, ((0, 0, 0),), CUBE),
    "bcc": Crystal(3, BODY, ((0, 0, 0),), OF_BCC),
    "fcc": Crystal(3, FACES, ((0, 0, 0),), OF_FCC),
    "hcp": Crystal(3, (*SIXTY, (0, 0, HEIGHT)), ((0, 0, 0), (THIRD, 2 * THIRD, H)), PRISM),
    "diamond": Crystal(3, FACES, ((0, 0, 0), (1 / 4, 1 / 4, 1 / 4)), OF_FCC),
    "pyrochlore": Crystal(3, FACES, ((0, 0, 0), (H, 0, 0), (0, H, 0), (0, 0, H)), OF_FCC),
}
