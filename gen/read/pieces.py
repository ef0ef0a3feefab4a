"""Pieces: effects to be used by name, `use = "spins/uniaxial"`, with arguments that take the place of their `$words`.

    [piece]
    title = "Uniaxial anisotropy"
    source = "..."                              # where the formula comes from
    law = "..."                                 # what it does, to be tested
    [piece.arguments]
    K = { unit = "energy", meaning = "positive: the axis is easy" }
    axis = { default = [0, 0, 1], meaning = "unit vector" }
    on = { default = "w", meaning = "the family" }
    [effect]
    over = "site(i) of $on"
    energy = "-$K*dot($on[i], $axis)^2"

A piece is an effect in the words of the spec, no other language: what stands for a `$word` is the argument's own text, in brackets
where it is more than a name or a number. An effect that uses a piece is read as if it had been written out; its places are those of both files.
"""
from __future__ import annotations

import re

from ..language import codes
from .files import Files
from .marks import Mark
from .problems import Bad, Problems, nearest
from .source import Source, Text
from .text import meaning
from .toml import document
from .tree import LOST, Node

PIECE = ("title", "source", "law", "arguments")
ARGUMENT = ("meaning", "unit", "default", "one_of")
TEST = ("space", "parameters", "lattices", "formulas", "effects", "arguments", "start", "orientation", "method", "time", "steps", "law", "mean", "within")
WORD = re.compile(r"\$([A-Za-z][A-Za-z0-9_]*)?", re.ASCII)
ATOM = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z|[0-9.]+(e[+-]?[0-9]+)?\Z", re.ASCII)
PLAIN = ("over", "form", "meaning", "unit")     # keys whose words stand without brackets


class Pieces:
    """The pieces that the effects of a scene use, each read once."""

    def __init__(self, problems: Problems, files: Files):
        self.problems, self.files, self.read = problems, files, {}

    def expand(self, root: Node) -> None:
        """Write out every effect of the root that uses a piece."""
        for node in root.get("effects").items() if root.has("effects") and isinstance(root.raw["effects"], dict) else ():
            if isinstance(node.raw, dict) and "use" in node.raw:
                written = self.problems.tried(lambda effect=node: self.written(effect))[0]
                root.raw["effects"][node.name] = LOST if written is Bad else written

    def written(self, node: Node) -> dict:
        """The table of an effect that uses a piece; its places are added."""
        piece = self.piece(node.get("use"))
        given = Arguments(piece, node)
        home = dict.fromkeys((a for a in given.words if not node.has(a)), node.get("use").span.start)
        self.problems.defaults.update({start: {a: given.words[a].raw for a in home} for start in home.values()})
        found = {}
        for child in piece.get("effect").items():
            found[child.name], node.marks[(*node.path, child.name)] = filled(child, given.words, home)
        for key in ("meaning", "title"):
            holder = node if node.has("meaning") else piece.get("piece")
            if "meaning" not in found and holder.has(key):
                found["meaning"], node.marks[(*node.path, "meaning")] = holder.raw[key], holder.marks[(*holder.path, key)]
        return found

    def piece(self, use: Node) -> Node:
        """The root of the file that `use` names."""
        name, folder, text = self.files.piece(use)
        if (name, folder) not in self.read:
            self.read[name, folder] = checked(self.problems.sources.add(text, name, folder), self.problems)
        if self.read[name, folder] is Bad:
            raise Bad
        return self.read[name, folder]


def checked(file: Source, problems: Problems):
    """The root of a piece; Bad where it has errors, which are noted."""
    return problems.tried(lambda: sound(document(file, problems)[0]))[0]


def sound(root: Node) -> Node:
    """A piece with all that it needs."""
    root.table("piece", "effect", "test")
    says = root.need("piece", 'start with [piece] and `title = "..."`').table(*PIECE)
    says.need("title", 'give it a title: `title = "..."`')
    for key in ("title", "source", "law"):
        meaning(says, key)
    for node in says.get("arguments").table().items() if says.has("arguments") else ():
        node.table(*ARGUMENT)
    if root.has("test"):
        root.get("test").table(*TEST)
    effect = root.need("effect", "write the effect in the section [effect], with `$words` for its arguments").table()
    if effect.has("use"):
        effect.get("use").wrong(codes.NOT_HERE, "a piece cannot use another piece", "write out its effect instead")
    return root


class Arguments:
    """words: the arguments of a piece as an effect gives them, each a node."""

    def __init__(self, piece: Node, node: Node):
        says = piece.get("piece")
        self.known = {a.name: a for a in says.get("arguments").items()} if says.has("arguments") else {}
        self.node = node
        for child in node.items():
            if child.name not in (*self.known, "use", "meaning"):
                child.problems.note(codes.UNKNOWN_KEY, child.key, f"the piece `{node.raw['use']}` has no argument `{child.name}`", nearest(child.name, self.known))
        self.words = dict(zip(self.known, node.problems.together(*(lambda a=a: self.given(a) for a in self.known.values()))))

    def given(self, argument: Node) -> Node:
        """The value of one argument: that of the effect, else its default."""
        value = self.node.get(argument.name) or argument.get("default")
        if value is None:
            said = argument.raw.get("meaning", "")
            self.node.problems.fail(codes.MISSING, self.node.key, f"`{self.node.label}` does not give `{argument.name}`" + f": {said}" * bool(said),
                                    f"the piece `{self.node.raw['use']}` needs this argument: `{argument.name} = ...`")
        if argument.has("one_of") and value.raw not in argument.raw["one_of"]:
            value.wrong(codes.CHOICE, f"`{value.label}` is {value.raw!r}", "it must be one of " + ", ".join(map(str, argument.raw["one_of"])))
        return value


def filled(child: Node, words: dict[str, Node], home: dict[str, int]):
    """(value, mark) of a key of the piece, with the arguments in the place of its words; home: of a default, the place in the scene."""
    if not isinstance(child.raw, str):
        return child.raw, child.marks[child.path]
    text = child.text()
    alone = WORD.fullmatch(text.value)
    if alone and alone[1] in words and not isinstance(words[alone[1]].raw, list):
        value = words[alone[1]]
        return value.raw, Mark(child.key, value.span, value.marks[value.path].text)
    whole = joined(list(parts(child, text, words, home)), text)
    return whole.value, Mark(child.key, child.span, whole)


def parts(child: Node, text: Text, words: dict[str, Node], home: dict[str, int]):
    """(characters, their offsets): what stands between words, and for each word its argument."""
    end = 0
    for match in WORD.finditer(text.value):
        yield text.value[end:match.start()], text.offsets[end:match.start()]
        if match[1] not in words:
            child.problems.fail(codes.UNKNOWN_NAME, text.span(*match.span()), f"`{match[0]}` is not an argument of this piece", nearest(match[1] or "", words))
        alone = (text.value[:match.start()].rstrip()[-1:] or "(") in "(," and (text.value[match.end():].lstrip()[:1] or ")") in "),"
        characters, offsets = spoken(words[match[1]], alone or child.name in PLAIN)
        yield characters, (home[match[1]],) * len(characters) if match[1] in home else offsets
        end = match.end()
    yield text.value[end:], text.offsets[end:-1]


def spoken(value: Node, plain: bool):
    """An argument as it stands in a formula."""
    if isinstance(value.raw, list):
        pieces = [spoken(entry, False) for entry in value.entries("vector")]
        characters = "vec(" + ", ".join(c for c, _ in pieces) + ")"
        return characters, (value.span.start,) * len(characters)
    if isinstance(value.raw, str):
        text = value.text()
        characters, offsets = text.value, text.offsets[:-1]
    else:
        characters = repr(value.number())
        offsets = (value.span.start,) * len(characters)
    if plain or ATOM.match(characters):
        return characters, offsets
    return f"({characters})", (value.span.start, *offsets, value.span.start)


def joined(pieces, text: Text) -> Text:
    return Text("".join(c for c, _ in pieces), (*(k for _, offsets in pieces for k in offsets), text.offsets[-1]))
