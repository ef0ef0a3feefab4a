"""One table over another: tables merge; of single values and lists the nearer one counts.

Where keys exclude each other (`time` and `steps`), the nearer one takes the place of the farther. A number for a parameter that has a
table is its new default; a real parameter stays one where its new value is written without a point.
"""
from __future__ import annotations

from ..effects.kinds import KINDS
from ..language.units import KINDS as KINDS_OF_UNITS
from .starts import FORMS
from .tree import LOST, Node

# Keys of a table that say the same thing in different ways; * is any name.
WAYS = (
    (("units",), (("dimensionless",), tuple(KINDS_OF_UNITS))),
    (("space", "*"), (("sphere", "radius"), ("r3",), ("nambu", "C"))),
    (("space", "*"), (("kappa",), ("moment",))),
    (("lattices", "*"), (("name",), ("vectors", "positions"))),
    (("graphs", "*"), (("edges",), ("file",))),
    (("effects", "*"), tuple(kind.keys for kind in KINDS)),
    (("parameters", "*"), (("default",), ("file",))),
    (("starts", "*"), tuple(FORMS.values())),
    (("starts", "*", "*"), tuple(FORMS.values())),
    (("runs", "*"), (("time",), ("steps",))),
    (("runs", "*", "output"), (("every",), ("period",))),
)


def merged(far: Node, near: Node) -> Node:
    """The table of a file over that of its base, with the places of both."""
    merge = Merge(far.marks, near.marks)
    return Node(merge.over(far.raw, near.raw, ()), (), merge.marks, near.problems)


class Merge:
    """far, near: the places of both tables; marks: those of what is made of them."""

    def __init__(self, far: dict, near: dict):
        self.far, self.near = far, near
        self.marks = {**far, **near}

    def over(self, far, near, path: tuple):
        """What stands at a path."""
        if far is LOST or near is LOST:
            return LOST
        if path[:1] == ("parameters",) and len(path) == 2 and isinstance(far, dict) != isinstance(near, dict):
            return self.parameter(far, near, path)
        if path[:1] == ("effects",) and len(path) == 2 and another(far, near):
            return near
        if not (isinstance(far, dict) and isinstance(near, dict)):
            return float(near) if isinstance(far, float) and type(near) is int and path[0] == "parameters" else near
        piece = path[:1] == ("effects",) and len(path) == 2 and "use" in far        # whose arguments may have the names of any keys
        kept = {key: value for key, value in far.items() if piece or not displaced(key, near, path)}
        return {**kept, **{key: self.over(kept[key], value, (*path, key)) if key in kept else value for key, value in near.items()}}

    def parameter(self, far, near, path: tuple) -> dict:
        """A parameter whose default stands alone in one file, and in a table in the other."""
        place = (*path, "default")
        if isinstance(far, dict):
            self.moved(self.near, path, place)
            return {**{key: value for key, value in far.items() if key != "file"}, "default": self.over(far.get("default"), near, place)}
        if "file" in near:
            return near
        if "default" not in near:
            self.moved(self.far, path, place)
        return {"default": far, **near}

    def moved(self, places: dict, path: tuple, place: tuple) -> None:
        """The places of a value, and of the entries of a list, that stands elsewhere in what is made."""
        self.marks |= {place + at[len(path):]: mark for at, mark in places.items() if at[:len(path)] == path}


def another(far, near) -> bool:
    """Is the nearer table another effect, of which nothing of the farther one is meant: by another piece, or one of the two by its own formula?"""
    if not (isinstance(far, dict) and isinstance(near, dict)):
        return False
    if "use" in near:
        return near["use"] != far.get("use")
    own = {key for kind in KINDS for key in kind.told_by} - {"kT"}      # that is no effect without a damping, and an argument of the bath
    return "use" in far and not own.isdisjoint(near)


def displaced(key: str, near: dict, path: tuple) -> bool:
    """Does the nearer table say in another way what this key of the farther one says?"""
    return any(key in way and not any(k in near for k in way) and any(k in near for other in ways for k in other)
               for pattern, ways in WAYS if fits(path, pattern) for way in ways)


def fits(path: tuple, pattern: tuple) -> bool:
    return len(path) == len(pattern) and all(one in (name, "*") for name, one in zip(path, pattern))
