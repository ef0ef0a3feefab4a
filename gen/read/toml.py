"""The TOML layer: `tomllib` judges and reads; its complaints get a place and a code."""
from __future__ import annotations

import re
import tomllib

from .. import limits
from . import codes
from .problems import Problems
from .source import Span

PLACE = re.compile(r"\(at line (\d+), column (\d+)\)\Z")


def document(text: str, problems: Problems) -> dict:
    """The values of a TOML text; notes what is wrong and raises Bad."""
    lexical(text, problems)
    try:
        return tomllib.loads(text)
    except RecursionError:
        problems.fail(codes.LIMIT, Span(0, 1), "values are nested too deeply")
    except ValueError as e:
        complaint(str(e), text, problems)


def lexical(text: str, problems: Problems) -> None:
    """Size, line length and nesting, before anything is read."""
    if len(text.encode("utf-8", "surrogatepass")) > limits.FILE_BYTES:
        problems.fail(codes.LIMIT, Span(0, 1), f"the spec has more than {limits.FILE_BYTES} "
                      "bytes", "put long lists into files")
    if not text.strip():
        problems.fail(codes.EMPTY, Span(0, 1), "the spec is empty",
                      'begin with [model] and `name = "..."`')
    start = 0
    for line in text.split("\n"):
        if len(line) > limits.LINE:
            problems.fail(codes.LIMIT, Span(start + limits.LINE, start + limits.LINE + 1),
                          f"a line of {len(line)} characters; at most {limits.LINE} are allowed",
                          "break the line")
        nested(line, start, problems)
        start += len(line) + 1


def nested(line: str, start: int, problems: Problems) -> None:
    """Bound what makes tomllib recurse or dotted keys deep."""
    if max(line.count("["), line.count("{"), line.split("=")[0].count(".")) <= limits.NESTING:
        return
    depth = 0
    for k, c in enumerate(line):
        depth += (c in "[{") - (c in "]}")
        if depth > limits.NESTING:
            problems.fail(codes.LIMIT, Span(start + k, start + k + 1), "more than "
                          f"{limits.NESTING} brackets inside each other")
    if line.split("=")[0].count(".") > limits.NESTING:
        problems.fail(codes.LIMIT, Span(start, start + 1), f"a key of more than "
                      f"{limits.NESTING} parts")


def complaint(message: str, text: str, problems: Problems):
    """Turn tomllib's message into an error at its place."""
    match = PLACE.search(message)
    offset = problems.source.offset(int(match[1]), int(match[2])) if match else len(text)
    cause = PLACE.sub("", message).replace("(at end of document)", "at the end of the file")
    taken = re.match(r"Cannot (declare|overwrite|mutate)", cause)
    code = codes.DUPLICATE if taken else codes.TOML
    mend = "every key and table is written once" if taken else \
        "strings stand in quotes, tables in [brackets], one `key = value` a line"
    problems.fail(code, Span(max(0, offset - (taken is not None)), offset + 1),
                  cause.strip()[:1].lower() + cause.strip()[1:], mend)
