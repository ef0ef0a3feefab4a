"""Files that a spec names: tables of numbers inside the spec's own folder, nothing else."""
from __future__ import annotations

import os
import re
import stat
from pathlib import Path, PurePosixPath

from ..language import limits
from . import codes
from .tree import Node, number_trouble

CELL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\Z", re.ASCII)
PART = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*\Z", re.ASCII)
HOME = "name a file that lies beside the spec or in a folder below it, such as `tables/edges.csv`"


class Files:
    """Reads tables for one spec; `texts` keeps what was read, by name, for the digest."""

    def __init__(self, folder: str):
        self.folder = folder
        self.texts: dict[str, str] = {}

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
                self.broken(node, number, f"{len(rows[-1])} numbers, the first row has "
                            f"{len(rows[0])}", what)
        if not rows:
            node.wrong(codes.TABLE, f"`{node.raw}` holds no numbers", f"it should hold {what}")
        return rows

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
                   f"the file should hold {what}")

    def text(self, node: Node) -> str:
        """The text of the file, after all checks of its name and kind."""
        name = node.string()
        if not self.folder:
            node.wrong(codes.PATH, "a spec without a file of its own cannot name files",
                       "save the spec and load it by its path")
        self.check_name(node, name)
        path = Path(self.folder, name)
        self.check_kind(node, path)
        try:
            text = path.read_bytes().decode("utf-8-sig")
        except (OSError, UnicodeDecodeError) as e:
            node.wrong(codes.TABLE, f"`{name}` cannot be read: {reason(e)}",
                       "it should be UTF-8 text: rows of numbers with commas between them")
        self.texts[name] = text.replace("\r\n", "\n")
        return self.texts[name]

    def check_name(self, node: Node, name: str) -> None:
        """Only plain relative names: no `..`, no drive, no absolute path."""
        parts = PurePosixPath(name).parts
        if not parts or name != "/".join(parts) or not all(PART.match(p) for p in parts):
            node.wrong(codes.PATH, "this is not the plain name of a file", HOME)

    def check_kind(self, node: Node, path: Path) -> None:
        """A regular file of bounded size whose real place is inside the folder."""
        real, home = os.path.realpath(path), os.path.realpath(self.folder)
        if os.path.commonpath((real, home)) != home:
            node.wrong(codes.PATH, f"`{node.raw}` leads out of the spec's folder", HOME)
        try:
            info = os.stat(real)
        except OSError as e:
            node.wrong(codes.PATH, f"`{node.raw}` cannot be read: {reason(e)}", HOME)
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
    try:
        rows = [tuple(map(plain_number, line.split(","))) for line in body] if text.isascii() else []
    except ValueError:
        return None
    same = rows and len(rows[0]) >= columns and all(len(row) == len(rows[0]) for row in rows)
    return rows if same else None


def plain_number(cell: str):
    """Raises ValueError where the cell is none of ordinary size."""
    if len(cell) < 16 and cell.isdigit():
        return int(cell)
    if len(cell) > 40 or not CELL.match(cell):
        raise ValueError(cell)
    value = float(cell) if set(cell) & set(".eE") else int(cell)
    if number_trouble(value):
        raise ValueError(cell)
    return value


def header(cells: list[str]) -> bool:
    """A first line of column names."""
    return all(c and not CELL.match(c) for c in cells)


def reason(e: Exception) -> str:
    return (getattr(e, "strerror", None) or "it is not UTF-8 text").lower()
