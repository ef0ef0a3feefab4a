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
                   f"{limits.TEXT} are allowed", "say it more briefly, the rest in a comment")
    for mark in FORBIDDEN:
        k = text.value.find(mark)
        if k >= 0:
            node.problems.fail(codes.TEXT, text.span(k, k + len(mark)), f"`{mark}` may not "
                               "stand in a text", "it would end or break a comment")
    for k, c in enumerate(text.value):
        if not plain(c):
            node.problems.fail(codes.TEXT, text.span(k, k + 1), f"the character U+{ord(c):04X} "
                               "may not stand in a text", "write one line of visible characters")
    return text.value
