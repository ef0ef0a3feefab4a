"""The TOML layer: `tomllib` judges and reads; its complaints get a place and a code."""
from __future__ import annotations

import difflib
import re
import tomllib

from ..language import limits
from ..language import codes
from .marks import Marks
from .problems import Bad, Problems
from .recover import Aside, recovered
from .source import Source, Span
from .tree import LOST, Node

TAKEN = re.compile(r"cannot (declare|overwrite|mutate)|duplicate inline table key")
PLACE = re.compile(r"\(at line (\d+), column (\d+)\)\Z")


TOO_DEEP = (f"more than {limits.NESTING} nested tables or lists",
            "a spec never needs more than six")


def document(file: Source, problems: Problems, sections=()) -> tuple[Node, Aside]:
    """The root of a TOML file, and what was set aside in it; raises Bad where nothing can be read.

    sections: the names that tables of the root may have.
    """
    text = file.text
    lexical(file, problems)
    aside = Aside()
    while True:
        try:
            values = tomllib.loads(text)
            root = bounded(Node(values, (), Marks(text, file.begin).at, problems))
            return emptied(root, aside, file.begin, sections), aside
        except RecursionError:
            problems.fail(codes.LIMIT, Span(file.begin, file.begin + 1), *TOO_DEEP)
        except ValueError as e:
            rest = complaint(str(e), file, text, problems, aside)
        if rest in (None, text):        # nothing was set aside
            raise Bad
        text = rest


def emptied(root: Node, aside: Aside, begin: int, sections) -> Node:
    """Keys and tables that were set aside say nothing."""
    for path in [p for p, mark in root.marks.items() if mark.key.start - begin in aside.keys]:
        inside = root.raw
        for key in path[:-1]:
            inside = inside[key]
        inside[path[-1]] = LOST
    for head, *rest in aside.headers:
        meant = head if head in sections else "".join(difflib.get_close_matches(head, sections, 1))
        if meant:
            lose(root.raw, [meant, *rest], aside)
    return root


def lose(inside, path: list[str], aside: Aside) -> None:
    """Put LOST at the path; what stood there counts as declared."""
    if not isinstance(inside, dict):
        return
    if len(path) > 1:
        return lose(inside.setdefault(path[0], {}), path[1:], aside)
    before = inside.get(path[0])
    aside.names |= set(before) if isinstance(before, dict) else set()
    inside[path[0]] = LOST


def lexical(file: Source, problems: Problems) -> None:
    """Size, line length and nesting, before anything is read."""
    text, start = file.text, file.begin
    if len(text.encode("utf-8", "surrogatepass")) > limits.FILE_BYTES:
        problems.fail(codes.LIMIT, Span(start, start + 1), f"the spec has more than {limits.FILE_BYTES} "
                      "bytes", "move long lists into files")
    if not text.strip():
        problems.fail(codes.EMPTY, Span(start, start + 1), "the spec is empty",
                      'start with [model] and `name = "..."`')
    for line in text.split("\n"):
        if len(line) > limits.LINE:
            problems.fail(codes.LIMIT, Span(start + limits.LINE, start + limits.LINE + 1),
                          f"this line has {len(line)} characters; at most {limits.LINE} are allowed",
                          "break the line")
        start += len(line) + 1


def bounded(node: Node) -> Node:
    """Refuse tables and lists that lie too deep inside each other."""
    layer = [node]
    for _ in range(limits.NESTING + 1):
        layer = [child for item in layer for child in item.children()]
    for child in layer:
        child.wrong(codes.LIMIT, *TOO_DEEP)
    return node


HINTS = {"illegal character '\\n'": "a string must end on the line where it begins",
         "invalid value": "strings and formulas need quotes; a decimal point needs a digit before and after it",
         "expected newline or end of document after a statement":
             "one `key = value` per line; strings and formulas need quotes",
         "unclosed inline table": "inside { } entries are separated by commas, and formulas need quotes: "
                                  "`{ sphere = \"2*n\" }`",
         "expected ']' at the end of a table declaration":
             "a section is named `[effects.NAME]`, with letters, digits and `_` in NAME",
         "expected '=' after a key in a key/value pair":
             "a key is one word, or in quotes: `\"f(a, b)\" = \"a + b\"`"}


def complaint(message: str, file: Source, text: str, problems: Problems, aside: Aside):
    """Turn tomllib's message into an error at its place; the text without that statement, or None.

    text: that of the file, without what was set aside before.
    """
    match = PLACE.search(message)
    offset = file.offset(int(match[1]), int(match[2])) if match else len(text)
    cause = PLACE.sub("", message).replace("(at end of document)", "at the end of the file")
    cause = cause.strip()[:1].lower() + cause.strip()[1:]
    taken = TAKEN.match(cause) is not None
    if taken:
        start = text.rfind("\n", 0, offset) + 1
        problems.note(codes.DUPLICATE, Span(file.begin + start, file.begin + max(offset, start + 1)), spoken(cause),
                      "every key and table can be given only once")
    else:
        named = not text[offset:offset + 1].isascii() and text[offset].isalpha()
        problems.note(codes.TOML, Span(file.begin + offset, file.begin + offset + 1), f"`{text[offset]}` (U+{ord(text[offset]):04X}) is not allowed in a name" if named else cause,
                      "names consist of ASCII letters, digits and `_`; other characters are allowed in titles and meanings, in quotes" if named else
                      HINTS.get(cause, "a spec is a TOML file: [tables], `key = value`"))
    return recovered(text, offset, message, taken, aside)


def spoken(cause: str) -> str:
    """tomllib's words for a second declaration, with the name as the user writes it."""
    name = ".".join(re.findall(r"'([^']*)'", cause))
    return f"`{name}` is given twice" if name else "this key is given twice"
