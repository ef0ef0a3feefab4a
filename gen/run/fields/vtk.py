"""The legacy format of VTK, which ParaView reads.

The VTK User's Guide, 11th edition (Kitware 2010), "VTK File Formats": a title, ASCII or BINARY (big-endian), then the
points and the vectors at them, x fastest. A lattice of one site a cell without places is of STRUCTURED_POINTS. With
places, one whose cells are boxes is a RECTILINEAR_GRID with a vector in each cell, any other is POLYDATA of points. One of several sites a cell without places
is refused: a picture is made of places. All shapes are read.
"""
from __future__ import annotations

import re

import numpy as np

from ...errors import UsageError
from ...language import limits
from ..files.received import Wrong, within

TITLE = 200         # characters; the format ends it at 256
SIZES = {"double": 8, "float": 4}
KEYWORD = re.compile(rb"\n(?=[A-Z])")       # ends the numbers of a text
SHAPES = ("STRUCTURED_POINTS", "RECTILINEAR_GRID", "UNSTRUCTURED_GRID", "POLYDATA")
PASSED = ("ORIGIN", "SPACING", "ASPECT_RATIO")      # what is read and not used
INTEGERS = {"vtktypeint64": 8, "vtktypeint32": 4}   # of version 5, in whose CELLS two arrays follow


def written(w, grid, size, label: str, title: str, text: bool, unit: str = "1") -> bytes:
    """The bytes of a file. grid: the Grid on which the vectors lie; size: its cells in three directions; the format tells no unit. Raises UsageError without places of several sites."""
    if grid.places is None and grid.sites > 1:
        raise UsageError(f"this lattice cannot be written as .vtk: it has {grid.sites} sites per cell, and the spec gives no positions; .ovf does not need them")
    if grid.places is not None:
        return with_places(w, grid, size, label, title, text)
    head = (f"# vtk DataFile Version 3.0\n{title[:TITLE] or label}\n{'ASCII' if text else 'BINARY'}\n"
            f"DATASET STRUCTURED_POINTS\nDIMENSIONS {size[0]} {size[1]} {size[2]}\nORIGIN 0 0 0\nSPACING 1 1 1\n")
    return head.encode("ascii", "replace") + f"POINT_DATA {len(w)}\nVECTORS {label} double\n".encode() + block(w, ">f8", text)


def with_places(w, grid, size, label: str, title: str, text: bool) -> bytes:
    """A mesh of boxes, or points."""
    spacing, head = grid.spacing(), f"# vtk DataFile Version 3.0\n{title[:TITLE] or label}\n{'ASCII' if text else 'BINARY'}\n".encode("ascii", "replace")
    if spacing is None:
        data = f"DATASET POLYDATA\nPOINTS {len(w)} double\n".encode() + block(grid.where(), ">f8", text) + f"POINT_DATA {len(w)}\n".encode()
        return head + data + f"VECTORS {label} double\n".encode() + block(w, ">f8", text)
    axes = b"".join(f"{axis}_COORDINATES {n + 1} double\n".encode() + block(((np.arange(n + 1) - 0.5) * a)[None], ">f8", text) for axis, n, a in zip("XYZ", size, spacing))
    data = f"DATASET RECTILINEAR_GRID\nDIMENSIONS {' '.join(str(n + 1) for n in size)}\n".encode() + axes
    return head + data + f"CELL_DATA {len(w)}\nVECTORS field double\n".encode() + block(w, ">f8", text)


def block(rows, kind: str, text: bool) -> bytes:
    """Rows of numbers."""
    if text:
        return "".join(" ".join(f"{x:.17g}" for x in row) + "\n" for row in rows.tolist()).encode()
    return np.ascontiguousarray(rows).astype(kind).tobytes() + b"\n"


def read(file, length: int) -> tuple[np.ndarray, tuple | None]:
    """(vectors, cells in three directions or None): the first VECTORS of an open file of `length` bytes. Raises Wrong."""
    first = file.readline(limits.LINE)
    if not first.startswith(b"# vtk DataFile Version"):
        raise Wrong("it is not in the legacy format of VTK")
    file.readline(limits.LINE)
    form = file.readline(limits.LINE).split()
    if form not in ([b"ASCII"], [b"BINARY"]):
        raise Wrong("it is neither ASCII nor BINARY")
    return Reader(file, length, form == [b"ASCII"], first.split()[-1] >= b"5").vectors()


class Reader:
    """Goes from keyword to keyword; of text, lines of numbers are passed over."""

    def __init__(self, file, length: int, text: bool, arrays: bool):
        self.file, self.length, self.text, self.arrays = file, length, text, arrays
        self.size, self.points, self.count, self.scalars, self.cells = None, None, None, 0, {}

    def vectors(self):
        """The first VECTORS, and the DIMENSIONS."""
        while line := self.file.readline(limits.LINE):
            words = line.decode("ascii", "replace").split()
            if words and words[0].upper() == "VECTORS":
                return self.rows(words), self.size
            if words and words[0][0].isalpha():
                self.keyword(words[0].upper(), words[1:])
        raise Wrong("it contains no VECTORS")

    def keyword(self, key: str, rest: list) -> None:
        if key in ("DIMENSIONS", "POINTS", "POINT_DATA", "CELL_DATA"):
            self.counts(key, rest)
        elif key in ("CELLS", "VERTICES", "CELL_TYPES", "OFFSETS", "CONNECTIVITY"):
            self.elements(key, rest)
        elif key.endswith("_COORDINATES"):
            self.skip(count_of(rest[0]) * SIZES[rest[1].lower()])
        elif key == "SCALARS":
            self.scalars = (self.count or 0) * SIZES[rest[1].lower()] * count_of(rest[2] if rest[2:] else "1")
        elif key == "LOOKUP_TABLE":
            self.skip(self.scalars)
        elif key == "METADATA":
            while self.file.readline(limits.LINE).strip():
                pass
        elif not (key == "DATASET" and rest[0].upper() in SHAPES or key in PASSED):
            raise Wrong(f"'{key[:20]}' cannot be read: a file of spins contains points and VECTORS")

    def counts(self, key: str, rest: list) -> None:
        """How many there are."""
        if key == "DIMENSIONS":
            self.size = tuple(count_of(word) for word in rest[:3])
            self.points = self.size[0] * self.size[1] * self.size[2]
        elif key == "POINTS":
            self.points = count_of(rest[0])
            self.skip(3 * self.points * SIZES[rest[1].lower()])
        else:
            self.count = count_of(rest[0])
            if key == "CELL_DATA" and self.size:
                self.size = tuple(max(1, n - 1) for n in self.size)
                self.points = self.size[0] * self.size[1] * self.size[2]

    def elements(self, key: str, rest: list) -> None:
        """Which points make a cell does not matter here."""
        if key in ("CELLS", "VERTICES") and self.arrays:
            self.cells = {"OFFSETS": count_of(rest[0]), "CONNECTIVITY": count_of(rest[1])}
        elif key in self.cells:
            self.skip(self.cells[key] * INTEGERS[rest[0].lower()])
        else:
            self.skip(4 * count_of(rest[-1]))

    def skip(self, bytes_: int) -> None:
        """Binary numbers that are not used."""
        if not self.text:
            within([bytes_], self.length - self.file.tell())
            self.file.seek(bytes_, 1)

    def rows(self, words: list) -> np.ndarray:
        """The vectors; nothing is taken for more than the file has."""
        if self.count is None or self.count != self.points or not 1 <= self.count <= limits.SITES or words[2].lower() not in SIZES:
            raise Wrong("it has different numbers of VECTORS and points")
        left, size = self.length - self.file.tell(), SIZES[words[2].lower()]
        within([6 * self.count - 1 if self.text else 3 * self.count * size], left)
        if self.text:
            found = np.fromstring(KEYWORD.split(self.file.read(left), 1)[0], sep=" ")
        else:
            found = np.frombuffer(self.file.read(3 * self.count * size), f">f{size}").astype(float)
        if len(found) != 3 * self.count:
            raise Wrong(f"its VECTORS have {len(found)} numbers, not {3 * self.count}")
        return found.reshape(-1, 3)


def count_of(word: str) -> int:
    """A count."""
    if not word.isdecimal() or len(word) > 19:
        raise Wrong(f"'{word[:20]}' is not a count")
    return int(word)
