"""A spec and all that it builds on, written as one: what it calls for, and behind each value the file and the line it comes from."""
from __future__ import annotations

import json
import re
import tomllib

from ..errors import printable
from ..language.spec import Spec
from .source import Sources
from .tree import Node

LINES = ("model", "units", "space", "parameters", "formulas")       # sections with a line for each entry; of the others each entry is a table
BARE = re.compile(r"[A-Za-z0-9_-]+\Z", re.ASCII)


def flat_text(spec: Spec, root: Node) -> str:
    """root: the table from which the spec was read."""
    writer = Writer(spec)
    return "\n\n".join(block for node in root.items() for block in writer.section(node)) + "\n"


class Writer:
    """called: of sections of which the scene may not call for all, the names of what it does; texts: values that are others than those written."""

    def __init__(self, spec: Spec):
        self.called = {name: {x.name for x in held} for name, held in (
            ("space", spec.families), ("parameters", spec.parameters), ("observables", spec.observables))}
        self.texts = {("model", "name"): quoted(spec.name)}
        for run in spec.runs:
            path = ("runs", run.name)
            self.texts[(*path, "output", "what")] = listed(run.what)
            self.texts[(*path, "averages", "what")] = listed(run.averages.what if run.averages else ())
            if run.effects is not None:
                self.texts[(*path, "effects")] = self.texts[(*path, "without")] = listed(run.effects)

    def section(self, node: Node) -> list[str]:
        """The blocks of a section."""
        entries = [child for child in node.items() if child.name in self.called.get(node.name, {child.name})]
        if node.name in LINES:
            return ["\n".join([f"[{node.name}]", *map(self.line, entries)])] if entries else []
        return ["\n".join([f"[{node.name}.{key(child.name)}]", *map(self.line, self.inside(child))]) for child in entries]

    def inside(self, node: Node) -> list[Node]:
        """The entries of a table: not `without` beside `effects`, no start of a family that is gone, no list of what is all gone."""
        return [child for child in node.items() if not (child.name == "without" and node.has("effects")) and self.texts.get(child.path) != "[]" and not (
            node.path[0] == "starts" and isinstance(child.raw, dict) and child.name not in self.called["space"])]

    def line(self, node: Node) -> str:
        """`key = value`, and where the value stands."""
        places: dict = {}
        name = "effects" if node.path[0] == "runs" and node.name == "without" else node.name
        return f"{key(name)} = {self.value(node, places)}".ljust(60) + "  # " + ", ".join(places)

    def value(self, node: Node, places: dict) -> str:
        """As it stands in its file; a table, of which several files may have parts, entry by entry. Adds to places."""
        if isinstance(node.raw, dict):
            return "{ " + ", ".join(f"{key(c.name)} = {self.value(c, places)}" for c in self.inside(node)) + " }"
        sources, mark = node.problems.sources, node.marks[node.path]
        file = sources.of(mark.value.start)
        text = file.text[mark.value.start - file.begin:mark.value.end - file.begin]
        if node.path in self.texts or is_value(text, node.raw):
            places[at(sources, mark.value.start)] = None
            return self.texts.get(node.path, text)
        for offset in mark.text.offsets[:-1] if mark.text else (mark.value.start,):     # put together from a piece and its arguments
            places[at(sources, offset)] = None
        return quoted(node.raw) if isinstance(node.raw, str) else repr(node.raw)


def is_value(text: str, value) -> bool:
    """Does the text of a file say this value? Not where `3` is the new value of a real parameter."""
    try:
        said = tomllib.loads(f"x = {text}")["x"]
    except tomllib.TOMLDecodeError:
        return False
    return type(said) is type(value) and said == value


def at(sources: Sources, offset: int) -> str:
    file = sources.of(offset)
    return f"{printable(file.name)}:{file.place(offset - file.begin)[0]}"


def key(name: str) -> str:
    return name if BARE.match(name) else quoted(name)


def quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def listed(words) -> str:
    return "[" + ", ".join(map(quoted, words)) + "]"
