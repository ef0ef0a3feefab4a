"""The XML formats of VTK: points with bonds (.vtu), meshes (.vtr, .vti), and series of them (.pvd).

The VTK User's Guide, 11th edition (Kitware 2010), "XML File Formats". Numbers are text, or in base64 after their length in bytes, little-endian. In a
mesh each cell has its site in the middle.
"""
from __future__ import annotations

import base64
from xml.sax.saxutils import quoteattr

import numpy as np

from ...errors import UsageError
from .grid import Grid

TYPES = {"f": ("Float64", "<f8"), "i": ("Int64", "<i8"), "u": ("UInt8", "u1")}
VERTEX, LINE = 1, 3
NO_PLACES = "the spec gives no positions; give the lattice `vectors`, or use one that has a name"


def array(name: str, rows, text: bool) -> str:
    """A DataArray."""
    rows = np.asarray(rows)
    said, kind = TYPES[rows.dtype.kind]
    of_rows = f' NumberOfComponents="{rows.shape[1]}"' if rows.ndim == 2 else ""
    head = f'<DataArray type="{said}" Name={quoteattr(name)}{of_rows} format="{"ascii" if text else "binary"}">'
    if text:
        return head + " ".join(f"{x:.17g}" if kind == "<f8" else str(x) for x in rows.ravel().tolist()) + "</DataArray>\n"
    data = np.ascontiguousarray(rows).astype(kind).tobytes()
    return head + base64.b64encode(np.array([len(data)], "<u8").tobytes() + data).decode() + "</DataArray>\n"


def document(kind: str, body: str) -> bytes:
    return (f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n{body}</VTKFile>\n').encode()


def points(w, grid: Grid, label: str, text: bool, bonds=()) -> bytes:
    """.vtu: the sites at their places, a line for each bond (pairs of numbers) that does not go through the boundary. Raises UsageError."""
    where = grid.where()
    if where is None:
        raise UsageError(f"this lattice cannot be written as .vtu: {NO_PLACES}")
    lines = np.asarray(bonds, np.int64).reshape(-1, 2)
    cells = [np.arange(len(w)), lines.ravel()]
    ends = np.concatenate([np.arange(1, len(w) + 1), len(w) + 2 * np.arange(1, len(lines) + 1)])
    kinds = np.concatenate([np.full(len(w), VERTEX, np.uint8), np.full(len(lines), LINE, np.uint8)])
    return document("UnstructuredGrid", f'<UnstructuredGrid>\n<Piece NumberOfPoints="{len(w)}" NumberOfCells="{len(kinds)}">\n'
                    f"<PointData Vectors={quoteattr(label)}>\n{array(label, w, text)}</PointData>\n<Points>\n{array('points', where, text)}</Points>\n"
                    f"<Cells>\n{array('connectivity', np.concatenate(cells), text)}{array('offsets', ends, text)}{array('types', kinds, text)}</Cells>\n"
                    "</Piece>\n</UnstructuredGrid>\n")


def rectilinear(w, grid: Grid, label: str, text: bool) -> bytes:
    """.vtr: a mesh of one site a cell. Raises UsageError."""
    spacing, size = mesh(grid, ".vtr"), (*grid.size, 1, 1)[:3]
    extent = " ".join(f"0 {n}" for n in size)
    axes = "".join(array(axis, (np.arange(n + 1) - 0.5) * a, text) for axis, n, a in zip("xyz", size, spacing))
    return document("RectilinearGrid", f'<RectilinearGrid WholeExtent="{extent}">\n<Piece Extent="{extent}">\n<CellData Vectors={quoteattr(label)}>\n'
                    f"{array(label, w, text)}</CellData>\n<Coordinates>\n{axes}</Coordinates>\n</Piece>\n</RectilinearGrid>\n")


def image(w, grid: Grid, label: str, text: bool) -> bytes:
    """.vti: the same, by its spacing."""
    spacing, size = mesh(grid, ".vti"), (*grid.size, 1, 1)[:3]
    extent, origin = " ".join(f"0 {n}" for n in size), " ".join(f"{-a / 2:.17g}" for a in spacing)
    return document("ImageData", f'<ImageData WholeExtent="{extent}" Origin="{origin}" Spacing="{" ".join(f"{a:.17g}" for a in spacing)}">\n<Piece Extent="{extent}">\n'
                    f"<CellData Vectors={quoteattr(label)}>\n{array(label, w, text)}</CellData>\n</Piece>\n</ImageData>\n")


def mesh(grid: Grid, ending: str) -> tuple:
    """The spacing of a lattice whose cells are boxes along x, y and z with a site each. Raises UsageError."""
    spacing = grid.spacing()
    if spacing is None:
        raise UsageError(f"this lattice cannot be written as {ending}: " + (NO_PLACES if grid.places is None else "its cells are not boxes along x, y and z with one site each; use .vtu, which takes any lattice"))
    return spacing


def series(entries) -> bytes:
    """.pvd: files (time, name) of a series."""
    rows = "".join(f'<DataSet timestep="{time:.17g}" part="0" file={quoteattr(name)}/>\n' for time, name in entries)
    return ('<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">\n<Collection>\n' + rows + "</Collection>\n</VTKFile>\n").encode()
