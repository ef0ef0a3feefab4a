"""Files that a spec names: specs that it builds on and tables of numbers, by one rule.

A file is looked for in the folder of the spec that names it, then in the folders that the user has given (`--library`). It lies there or
below, and nowhere else. Specs that come with smidgen are bases by their names alone.
"""
from __future__ import annotations

import os
import re
import stat
from itertools import repeat
from operator import contains
from pathlib import Path, PurePosixPath

import numpy as np

from ..language import limits
from ..resources import pieces, shipped
from ..language import codes
from .problems import meant, nearest
from .tree import Node, number_trouble

LIBRARY = ".library"        # no file of a spec has such a name
CELL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\Z", re.ASCII)
WIDEST = 64         # columns that are converted one by one; a wider table is converted as a whole, since a list for each column would take longer
PART = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*\Z", re.ASCII)
HOME = "name a file in the folder of the spec or below it, such as `tables/edges.csv`, or name its folder with --library"


class Files:
    """Reads files for one spec; `texts` keeps what was read, by name, for the digest.

    folder: that of the spec, "" where it has no file; library: further folders, of the user.
    """

    def __init__(self, folder: str, library=()):
        self.library = [os.path.abspath(os.fspath(place)) for place in library]
        self.texts: dict[str, str] = {}
        self.names = {**dict.fromkeys(self.library, LIBRARY), folder: ""}       # of folders, in the names of `texts`

    # Specs

    def spec(self, node: Node) -> tuple[str, str, str]:
        """Of the spec that `node` names: what messages call it, its folder, its text."""
        word = node.string()
        return self.opened(node, *(self.place(node) if word.endswith(".toml") else self.by_name(node, word)))

    def opened(self, node: Node, folder: str, name: str) -> tuple[str, str, str]:
        path = Path(folder, name)
        try:
            text = path.read_bytes().decode("utf-8-sig").replace("\r\n", "\n")
        except (OSError, UnicodeDecodeError) as e:
            node.wrong(codes.PATH, f"`{node.raw}` cannot be read: {reason(e)}", "it should be a TOML file in UTF-8")
        self.keep(folder, name, text)
        self.names.setdefault(str(path.parent), os.path.dirname(self.name(folder, name)))
        return shown(path), str(path.parent), text

    def by_name(self, node: Node, word: str) -> tuple[str, str]:
        """(folder, file) of a spec of the library, or of one that comes with smidgen."""
        return self.among(node, self.library) or self.of_smidgen(
            node, shipped(), f"no spec `{word}` comes with smidgen", f"write the name of a file with its extension, `{word}.toml`; ")

    def piece(self, node: Node) -> tuple[str, str, str]:
        """As `spec`, of the piece that `node` names: beside the spec, in the library, or one that comes with smidgen."""
        home = node.problems.sources.of(node.span.start).folder
        folder, name = self.among(node, [home, *self.library] if home else self.library) or self.of_smidgen(
            node, pieces(), f"there is no piece `{node.raw}`", "", [*filter(None, (home,)), *self.library])
        return self.opened(node, folder, name)

    def among(self, node: Node, folders) -> tuple[str, str] | None:
        """(folder, file) of the first of these folders that holds NAME.toml."""
        name = f"{node.string()}.toml"
        self.check_name(node, name)
        folder = next((place for place in folders if os.path.isfile(os.path.join(place, name))), None)
        if folder is None:
            return None
        self.check_kind(node, Path(folder, name), folder)
        return folder, name

    def of_smidgen(self, node: Node, known: dict[str, Path], cause: str, hint: str, folders=()) -> tuple[str, str]:
        if node.raw not in known:
            near = next(filter(None, (neighbour(Path(folder, f"{node.raw}.toml"), folder, "") for folder in folders)), "")
            node.wrong(codes.UNKNOWN_NAME, cause, hint + (near or nearest(node.raw, known)))
        path, name = known[node.raw], f"{node.raw}.toml"
        return (str(path)[:-len(name) - 1], name) if str(path).endswith(f"/{name}") else (str(path.parent), path.name)

    # The names of texts: a folder that holds them under these names, with one for the library, holds the whole spec

    def name(self, folder: str, name: str) -> str:
        return "/".join(part for part in (self.names.get(folder, LIBRARY), name) if part)

    def keep(self, folder: str, name: str, text: str) -> None:
        self.texts[self.name(folder, name)] = text

    # Tables

    def rows(self, node: Node, columns: int, what: str) -> list[tuple]:
        """The rows of the table that `node` names, each with at least `columns` numbers."""
        text = self.text(node)
        rows = plain_rows(text, columns)
        if rows is not None:
            return rows
        rows = []
        for number, line in enumerate(text.splitlines(), 1):
            cells = [c.strip() for c in re.split(r"[,;\t]", line.split("#")[0])]
            if cells == [""] or (not rows and header(cells)):
                continue
            rows.append(self.row(node, number, cells, columns, what))
            if len(rows[-1]) != len(rows[0]):
                self.broken(node, number, f"{len(rows[-1])} numbers, but the first row has "
                            f"{len(rows[0])}", what)
        if not rows:
            node.wrong(codes.TABLE, f"`{node.raw}` contains no numbers", f"it should contain {what}")
        return rows

    def numbers(self, node: Node, columns: int) -> list[tuple]:
        """The rows of a table, of a .csv or a .npy file, each with `columns` numbers and no more."""
        what = "a number in each row" if columns == 1 else "rows `x, y, z`"
        if str(node.raw).endswith(".npy"):
            return self.array(node, columns, what)
        rows = self.rows(node, columns, what)
        if len(rows[0]) != columns:
            self.broken(node, 1, f"{len(rows[0])} columns", what + "; with `vector = true` rows `x, y, z`" * (columns == 1 and len(rows[0]) == 3))
        return rows

    def array(self, node: Node, columns: int, what: str) -> list[tuple]:
        """Those of a .npy file, which holds real numbers and no objects."""
        folder, name = self.place(node)
        try:
            found = np.load(Path(folder, name), mmap_mode="r", allow_pickle=False)
            shape = found.shape
            numbers = np.array(found, dtype=float).reshape(-1, columns) if found.dtype.kind in "fiu" and shape in ((shape[0], columns), (shape[0],)[:columns == 1]) else None
        except Exception:       # of what a damaged head is taken for, numpy gives no list
            node.wrong(codes.TABLE, f"`{name}` cannot be read: it is not a .npy file of numbers", "write it with numpy.save, without objects")
        if numbers is None or not len(numbers):
            flat = "; `a.ravel()` has its entries in the order of the sites" if len(shape) > 1 and columns == 1 else ""
            node.wrong(codes.TABLE, f"`{name}` contains an array of shape {shape} and type {found.dtype}", f"it should contain real numbers, {what}{flat}")
        if (bad := np.flatnonzero([bool(number_trouble(x)) for x in numbers.ravel().tolist()])).size:
            node.wrong(codes.TABLE, f"`{name}`, row {bad[0] // columns + 1}: {numbers.ravel()[bad[0]]:g} is out of range", f"it should contain {what}")
        self.keep(folder, name, "\n".join(",".join(map(repr, row)) for row in numbers.tolist()))
        return list(map(tuple, numbers.tolist()))

    def row(self, node: Node, number: int, cells: list[str], columns: int, what: str) -> tuple:
        for cell in cells:
            if not CELL.match(cell) or len(cell) > 40:
                self.broken(node, number, "a cell is not a number", what)
        values = tuple(float(c) if set(c) & set(".eE") else int(c) for c in cells)
        if any(number_trouble(v) for v in values):
            self.broken(node, number, "a number is out of range", what)
        if len(values) < columns:
            self.broken(node, number, f"{len(values)} of {columns} numbers", what)
        return values

    def broken(self, node: Node, number: int, cause: str, what: str):
        node.wrong(codes.TABLE, f"`{node.raw}`, line {number}: {cause}",
                   f"the file should contain {what}")

    def text(self, node: Node) -> str:
        """The text of the file, after all checks of its name and kind."""
        folder, name = self.place(node)
        try:
            text = Path(folder, name).read_bytes().decode("utf-8-sig").replace("\r\n", "\n")
        except (OSError, UnicodeDecodeError) as e:
            node.wrong(codes.TABLE, f"`{name}` cannot be read: {reason(e)}",
                       "it should be UTF-8 text: rows of numbers with commas between them")
        self.keep(folder, name, text)
        return text

    # The rule

    def place(self, node: Node) -> tuple[str, str]:
        """(folder, name) of the file that `node` names, after all checks of its name and kind."""
        name, home = node.string(), node.problems.sources.of(node.span.start).folder
        if not home:
            node.wrong(codes.PATH, "a spec that is not read from a file cannot name files",
                       "save the spec and load it by its path")
        self.check_name(node, name)
        places = (home, *self.library)
        found = next((place for place in places if os.path.lexists(os.path.join(place, name))), home)
        self.check_kind(node, Path(found, name), found)
        return found, name

    def check_name(self, node: Node, name: str) -> None:
        """Only plain relative names: no `..`, no drive, no absolute path."""
        parts = PurePosixPath(name).parts
        if ".." in parts or name.startswith("/"):
            node.wrong(codes.PATH, f"`{name}` is outside the folder of the spec", HOME)
        if not parts or name != "/".join(parts) or not all(PART.match(p) for p in parts):
            node.wrong(codes.PATH, "this is not the plain name of a file", HOME)

    def check_kind(self, node: Node, path: Path, folder: str) -> None:
        """A regular file of bounded size whose real place is inside the folder."""
        real, home = os.path.realpath(path), os.path.realpath(folder)
        if os.path.commonpath((real, home)) != home:
            node.wrong(codes.PATH, f"`{node.raw}` is outside the folder of the spec", HOME)
        try:
            info = os.stat(real)
        except OSError as e:
            node.wrong(codes.PATH, f"`{node.raw}` cannot be read: {reason(e)}", neighbour(path, folder) or HOME)
        if not stat.S_ISREG(info.st_mode):
            node.wrong(codes.PATH, f"`{node.raw}` is not a file", HOME)
        if info.st_size > limits.TABLE_BYTES:
            node.wrong(codes.LIMIT, f"`{node.raw}` has {info.st_size} bytes; at most "
                       f"{limits.TABLE_BYTES} are allowed", "use a smaller table")


def plain_rows(text: str, columns: int) -> list[tuple] | None:
    """The rows of a table that holds nothing but plain numbers between commas, equally many in each; None for one that must be looked at
    cell by cell, to take it in or to say what is wrong."""
    lines = text.split("\n")
    body = lines[all(c.strip().isidentifier() for c in lines[0].split(",")):-1 if not lines[-1] else None]
    wide = body[0].count(",") + 1 if body else 0
    if wide < columns or not text.isascii() or any(line.count(",") != wide - 1 for line in body):
        return None
    cells = ",".join(body).split(",")
    if wide > WIDEST:
        numbers = plain_numbers(cells)
        return numbers and [tuple(numbers[k:k + wide]) for k in range(0, len(numbers), wide)]
    found = [plain_numbers(cells[k::wide]) for k in range(wide)]
    return None if None in found else list(zip(*found))


def plain_numbers(cells: list[str]) -> list | None:
    """The numbers in these cells; None if one of them is not a number of ordinary size."""
    if max(map(len, cells)) < 16 and all(map(str.isdigit, cells)):
        return list(map(int, cells))
    if max(map(len, cells)) > 40 or not all(map(CELL.match, cells)):
        return None
    if all(map(contains, cells, repeat("."))):
        values = list(map(float, cells))
    else:
        values = [float(c) if "." in c or "e" in c or "E" in c else int(c) for c in cells]
    return None if untried(values) and any(map(number_trouble, values)) else values


def untried(values: list) -> bool:
    """Is any of these so large or so small that number_trouble() must judge it?"""
    sizes = np.abs(np.array(values, float))
    return not (sizes.max() < limits.INTEGER and sizes.min(where=sizes > 0, initial=1.0) >= limits.SMALLEST)


def neighbour(path: Path, folder: str, ending: str | None = None) -> str:
    """A guess for a file that is not there: one beside it; with `ending` in place of its own."""
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.suffix == path.suffix]
    except OSError:
        return ""
    guess = meant(path.name, names)
    if not guess:
        return ""
    found = path.with_name(guess)
    return f"did you mean `{(found if ending is None else found.with_suffix(ending)).relative_to(folder).as_posix()}`?"


def shown(path: Path) -> str:
    """As the user would write it: relative to where smidgen runs, where it lies below."""
    near = os.path.relpath(path)
    return str(path) if near.startswith(os.pardir) else near


def header(cells: list[str]) -> bool:
    """A first line of column names."""
    return all(c and not CELL.match(c) for c in cells)


def reason(e: Exception) -> str:
    return (getattr(e, "strerror", None) or "it is not UTF-8 text").lower()
