"""Titles, meanings and units: text that must survive inside a comment of any language."""
from __future__ import annotations

from ..errors import plain
from ..language import limits
from ..language import codes
from .tree import Node

FORBIDDEN = ("*/", "/*", "*)", "(*", "??/", "\\")


def meaning(node: Node, key: str) -> str:
    """The text of `key` in table `node`, or nothing."""
    return checked(node.get(key)) if node.has(key) else ""


def checked(node: Node) -> str:
    """One line without control, direction or zero-width characters and comment marks."""
    text = node.text()
    if len(text.value) > limits.TEXT:
        node.wrong(codes.LIMIT, f"`{node.label}` has {len(text.value)} characters; at most "
                   f"{limits.TEXT} are allowed", "shorten it, and put the rest into a comment")
    for mark in FORBIDDEN:
        k = text.value.find(mark)
        if k >= 0:
            node.problems.fail(codes.TEXT, text.span(k, k + len(mark)), f"`{mark}` is not allowed in a text", "it would end or continue a comment")
    for k, c in enumerate(text.value):
        if not plain(c):
            node.problems.fail(codes.TEXT, text.span(k, k + 1), f"the character U+{ord(c):04X} "
                               "is not allowed in a text", "use a single line of printable characters")
    return text.value
