"""OVF 2.0, the format of OOMMF, mumax and Spirit.

M. J. Donahue and D. G. Porter, OOMMF User's Guide, release 2.0, "Vector field file format": a header of lines `# key: value`,
then a row of numbers for each cell, x fastest, as text or as little-endian binary after a number that tells the order of
bytes. A lattice of one site a cell is a `rectangular` mesh; of several sites it is an `irregular` one, where each row
begins with the position.
"""
from __future__ import annotations

import numpy as np

from ...language import limits
from ..files.received import Wrong, within

CHECK = {4: 1234567.0, 8: 123456789012345.0}        # the first number of binary data
HEADER = 200        # lines; OOMMF writes thirty
AXES = "xyz"
SCHEMATIC = "Desc: the sites of a cell are placed at fractions of its diagonal, since the spec gives no positions"
READ = ("valuedim", "segment count", "meshtype", "pointcount", *(f"{axis}nodes" for axis in AXES))     # what counts of the header


def written(w, grid, size, label: str, title: str, text: bool, unit: str = "1") -> bytes:
    """The bytes of a file. grid: the Grid on which the vectors lie; size: its cells in three directions; unit: of the vectors."""
    spacing = (1, 1, 1) if grid.places is None and grid.sites == 1 else grid.spacing()
    regular = spacing is not None
    where = in_three(grid.positions()) if grid.places is None else grid.where()
    rows = w if regular else np.hstack([where, w])
    kind = "Text" if text else "Binary 8"
    head = ["OOMMF OVF 2.0", "Segment count: 1", "Begin: Segment", "Begin: Header", f"Title: {title}",
            f"meshunit: {'cell' if grid.places is None else grid.unit or 1}", "valuedim: 3", f"valuelabels: {' '.join(f'{label}_{axis}' for axis in AXES)}", f"valueunits: {' '.join([listed(unit)] * 3)}",
            *box(where, size, spacing if grid.places is not None else (1, 1, 1)),
            *(mesh(size, spacing) if regular else [*([SCHEMATIC] if grid.places is None else []), "meshtype: irregular", f"pointcount: {len(rows)}"]),
            "End: Header", f"Begin: Data {kind}"]
    body = "".join(" ".join(f"{x:.17g}" for x in row) + "\n" for row in rows.tolist()).encode() if text \
        else np.concatenate([[CHECK[8]], rows.ravel()]).astype("<f8").tobytes() + b"\n"
    return "".join(f"# {line}\n" for line in head).encode() + body + f"# End: Data {kind}\n# End: Segment\n".encode()


def listed(word: str) -> str:
    """As a list of Tcl has it."""
    return f"{{{word}}}" if " " in word else word


def box(where, size, spacing) -> list[str]:
    """The corners of all cells of a mesh; without one those of all cells in cells, or of all places."""
    if spacing is not None:
        low, high = [-a / 2 for a in spacing], [(n - 0.5) * a for n, a in zip(size, spacing)]
    else:
        low, high = where.min(axis=0).tolist(), where.max(axis=0).tolist()
    return [*(f"{axis}min: {x:.17g}" for axis, x in zip(AXES, low)), *(f"{axis}max: {x:.17g}" for axis, x in zip(AXES, high))]


def mesh(size, spacing) -> list[str]:
    """Cells whose centres are the sites."""
    return ["meshtype: rectangular", *(f"{axis}base: 0" for axis in AXES), *(f"{axis}stepsize: {a:.17g}" for axis, a in zip(AXES, spacing)),
            *(f"{axis}nodes: {n}" for axis, n in zip(AXES, size))]


def in_three(positions) -> np.ndarray:
    """Positions in up to three directions with zeros for the rest."""
    return np.pad(positions, ((0, 0), (0, 3 - positions.shape[1])))


def read(file, length: int) -> tuple[np.ndarray, tuple | None]:
    """(vectors, cells in three directions or None) of an open file of `length` bytes. Raises Wrong."""
    head, kind = header(file)
    if head.get("valuedim") != "3":
        raise Wrong("it does not contain vectors (valuedim must be 3)")
    if whole(head, "segment count", "1") != 1:
        raise Wrong("it has several segments")
    regular = head.get("meshtype", "").lower() == "rectangular"
    size = tuple(whole(head, f"{axis}nodes") for axis in AXES) if regular else None
    count = size[0] * size[1] * size[2] if regular else whole(head, "pointcount")
    if not 1 <= count <= limits.SITES:
        raise Wrong(f"from 1 to {limits.SITES} sites can be read, not {count}")
    return numbers(file, length, kind, count, 3 if regular else 6)[:, -3:], size


def header(file) -> tuple[dict, list]:
    """({key: value}, words of the kind of data) of the lines up to the data."""
    first = file.readline(limits.LINE).decode("ascii", "replace").strip("#\r\n ").upper()
    if first != "OOMMF OVF 2.0":
        raise Wrong("it is not in the format OVF 2.0")
    found = {}
    for _ in range(HEADER):
        line = file.readline(limits.LINE).decode("utf-8", "replace").strip()
        key, _, value = line[1:].partition("##")[0].partition(":")      # ## begins a comment
        if key.strip().lower() == "begin" and value.lower().split()[:1] == ["data"]:
            return found, value.lower().split()[1:]
        if not line.startswith("##") and found.setdefault(key.strip().lower(), value.strip()) != value.strip() and key.strip().lower() in READ:
            raise Wrong(f"its header contains '{key.strip()}' twice")
    raise Wrong("it has no data")


def whole(head: dict, key: str, default: str = "") -> int:
    """A count of the header."""
    text = head.get(key, default)
    if not (text.isascii() and text.isdecimal()) or len(text) > 19:
        raise Wrong(f"'{key}' is missing from its header, or is not a count")
    return int(text)


def numbers(file, length: int, kind: list, count: int, width: int) -> np.ndarray:
    """`count` rows of `width` numbers; nothing is taken for more than the file has."""
    if kind == ["text"]:
        within([2 * count * width - 1], length - file.tell())       # a digit and a space at least
        found = np.fromstring(file.read(length).partition(b"#")[0], sep=" ")
        if len(found) != count * width:
            raise Wrong(f"it has {len(found)} numbers, not {count * width}")
        return found.reshape(count, width)
    if kind not in (["binary", "4"], ["binary", "8"]):
        raise Wrong("its data are neither Text, Binary 4 nor Binary 8")
    size = int(kind[1])
    within([(1 + count * width) * size], length - file.tell())
    data = np.frombuffer(file.read((1 + count * width) * size), f"<f{size}")
    if data[0] != CHECK[size]:
        raise Wrong("its byte order is not that of OVF 2.0")
    rest = [file.readline(limits.LINE).strip() for _ in range(2)]
    if not (rest[0] or rest[1]).lower().startswith(b"# end: data"):
        raise Wrong("its data have the wrong length")
    return data[1:].astype(float).reshape(count, width)
