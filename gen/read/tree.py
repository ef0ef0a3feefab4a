"""TOML values with their places, read with checks: what every section is made of."""
from __future__ import annotations

import math
from typing import Iterator, Optional

from ..language import limits
from ..renamed import KEYS, now
from ..language import codes
from .problems import Bad, Problems, meant, nearest
from .source import Span, Text

KINDS = {bool: "true or false", int: "an integer", float: "a number", str: "a string",
         list: "a list", dict: "a table"}


LOST = object()     # stands for what could not be read: its error is noted


def describe(value) -> str:
    return KINDS.get(type(value), "a date or time")


class Node:
    """A value of the spec: what it is, where it and its key stand."""

    def __init__(self, value, path: tuple, marks: dict, problems: Problems):
        self.raw, self.path, self.marks, self.problems = value, path, marks, problems

    @property
    def name(self) -> str:
        return str(self.path[-1]) if self.path else ""

    @property
    def label(self) -> str:
        """The dotted path as the user writes it."""
        return ".".join(str(p) for p in self.path)

    @property
    def key(self) -> Span:
        return self.marks[self.path].key if self.path in self.marks else Span(0, 1)

    @property
    def span(self) -> Span:
        return self.marks[self.path].value if self.path in self.marks else Span(0, 1)

    def wrong(self, code: str, cause: str, hint: str):
        """Report this value and give it up; silently when it was set aside."""
        if self.raw is LOST:
            raise Bad
        self.problems.fail(code, self.span, cause, hint)

    # Tables

    def table(self, *keys: str, **within: tuple[str, ...]) -> "Node":
        """This node as a table whose keys are all among `keys` (any, when none given). within: the keys of its own tables, by their names."""
        if not isinstance(self.raw, dict):
            self.wrong(codes.TYPE, f"`{self.label}` must be a table, not {describe(self.raw)}",
                       "write `[section]` or `name = { key = value }`")
        for child in list(self.items()) if keys else ():
            if child.name not in keys and child.raw is not LOST:
                self.misnamed(child, keys, within)
        return self

    def misnamed(self, child: "Node", keys, within) -> None:
        """Report a key that is none of `keys`, and go on as if it were the one that was meant; of one that belongs to a table, say so."""
        if home := next((name for name, inner in within.items() if child.name in inner), None):
            self.problems.note(codes.UNKNOWN_KEY, child.key, f"`{self.label}` has no key `{child.name}`", f"it belongs to `{home}`: write `{home} = {{ {child.name} = ... }}`")
            return
        new, where = now(child.name, KEYS, keys), f"`{self.label}` has no key" if self.path else "a spec has no section"
        if not (new and self.problems.recorded):
            self.problems.note(codes.UNKNOWN_KEY, child.key, f"{where} `{child.name}`",
                               f"it is now called `{new}`" if new else nearest(child.name, keys))
        self.take_as_meant(child, new or meant(child.name, keys))

    def take_as_meant(self, child: "Node", key: str | None) -> None:
        """A misspelt key is read as the one that was meant, so that no other error follows from it."""
        if self.path and key is not None and key not in self.raw and not isinstance(child.raw, (dict, list)):
            self.raw[key], self.marks[self.path + (key,)] = child.raw, self.marks[child.path]

    def items(self) -> Iterator["Node"]:
        for key in self.raw:
            yield Node(self.raw[key], self.path + (key,), self.marks, self.problems)

    def children(self) -> list["Node"]:
        """The tables and lists that this table or list holds."""
        inner = self.raw.items() if isinstance(self.raw, dict) else enumerate(self.raw)
        return [Node(v, self.path + (k,), self.marks, self.problems) for k, v in inner
                if isinstance(v, (dict, list))]

    def get(self, key: str) -> Optional["Node"]:
        if key not in self.raw:
            return None
        return Node(self.raw[key], self.path + (key,), self.marks, self.problems)

    def need(self, key: str, hint: str) -> "Node":
        child = self.get(key)
        if child is None and any((codes.UNKNOWN_KEY, c.key) in self.problems.seen
                                 for c in self.items()):
            raise Bad           # most likely misspelt, which is noted already
        if child is None:
            where = f"`{self.label}` has no `{key}`" if self.path else f"the spec has no [{key}]"
            self.problems.fail(codes.MISSING, self.key, where, hint)
        return child

    def has(self, key: str) -> bool:
        return key in self.raw

    # Lists and scalars

    def entries(self, what: str = "list", most: int = limits.LIST) -> list["Node"]:
        if not isinstance(self.raw, list):
            self.wrong(codes.TYPE, f"`{self.label}` must be a {what}, not {describe(self.raw)}",
                       "lists are written `[a, b, c]`")
        if len(self.raw) > most:
            self.wrong(codes.LIMIT, f"`{self.label}` has {len(self.raw)} entries; "
                       f"at most {most} are allowed", "shorten it, or use a file")
        return [Node(v, self.path + (k,), self.marks, self.problems)
                for k, v in enumerate(self.raw)]

    def text(self) -> Text:
        """A string with positions."""
        if not isinstance(self.raw, str):
            self.wrong(codes.TYPE, f"`{self.label}` must be a string, not {describe(self.raw)}",
                       "write it between quotes")
        if len(self.raw) > limits.STRING:
            self.wrong(codes.LIMIT, f"`{self.label}` has {len(self.raw)} characters; "
                       f"at most {limits.STRING} are allowed",
                       "split it into named [formulas]")
        return self.marks[self.path].text

    def string(self) -> str:
        return self.text().value

    def flag(self) -> bool:
        if not isinstance(self.raw, bool):
            self.wrong(codes.TYPE, f"`{self.label}` must be true or false, "
                       f"not {describe(self.raw)}", "write `true` or `false` without quotes")
        return self.raw

    def is_number(self) -> bool:
        return isinstance(self.raw, (int, float)) and not isinstance(self.raw, bool)

    def is_integer(self) -> bool:
        return isinstance(self.raw, int) and not isinstance(self.raw, bool)

    def number(self):
        """An int or a finite float of ordinary size."""
        if not self.is_number():
            self.wrong(codes.TYPE, f"`{self.label}` must be a number, not {describe(self.raw)}",
                       "write a number without quotes, such as `1.0`")
        trouble = number_trouble(self.raw)
        if trouble:
            self.wrong(codes.NUMBER, f"`{self.label}` {trouble}",
                       "use a number in this range; choose other units if necessary")
        return self.raw

    def integer(self, least: int, most: int) -> int:
        if not self.is_integer():
            self.wrong(codes.TYPE, f"`{self.label}` must be an integer, not {describe(self.raw)}",
                       f"write a whole number from {least} to {most}")
        if not least <= self.raw <= most:
            self.wrong(codes.LIMIT, f"`{self.label}` is {self.raw}",
                       f"it must be between {least} and {most}")
        return self.raw


def number_trouble(value) -> str:
    """What is wrong with a number, or nothing: NaN, infinity, out of range."""
    if isinstance(value, float) and not math.isfinite(value):
        return "is not a finite number"
    if isinstance(value, int) and abs(value) > limits.INTEGER:
        return "is an integer beyond 2^53, which a double cannot hold"
    if abs(value) > limits.LARGEST or 0 < abs(value) < limits.SMALLEST:
        return f"is not between {limits.SMALLEST:g} and {limits.LARGEST:g} in absolute value"
    return ""
