"""A smaller text of a spec that still has a property: sections, lines, entries and parts of formulas are left out."""
from __future__ import annotations

import re
import time

FORMULA = re.compile(r'"""(.*?)"""|"([^"\n]*[-+*/(\[][^"\n]*)"', re.DOTALL)


def smaller(text: str, still, seconds: float) -> str:
    """The smallest text found for which still(text) holds, within some seconds of the clock."""
    end, changed = time.monotonic() + seconds, True
    while changed and time.monotonic() < end:
        changed = False
        for candidate in candidates(text):
            if time.monotonic() > end:
                break
            if len(candidate) < len(text) and still(candidate):
                text, changed = candidate, True
                break
    return text


def candidates(text: str):
    """Texts with one thing less, the largest things first."""
    yield from without(text, re.split(r"(?m)^(?=\[|# )", text))
    yield from without(text, text.splitlines(keepends=True))
    yield from entries(text)
    for found in FORMULA.finditer(text):
        k = 1 if found.group(1) is not None else 2
        for less in lesser(found.group(k)):
            yield text[:found.start(k)] + less + text[found.end(k):]


def without(text, pieces):
    for k in sorted(range(len(pieces)), key=lambda k: -len(pieces[k])):
        yield "".join(pieces[:k] + pieces[k + 1:])


def entries(text):
    """Without one `, key = value` of an inline table, or one `{..}, ` or number of a list."""
    for found in re.finditer(r", \w+ = (\"[^\"]*\"|\[[^\]]*\]|[\w.+-]+)|(\{[^{}]*\}), |, [-\d.]+|\w+ = (\[[^\]]*\]|[-\d.]+), ", text):
        yield text[:found.start()] + text[found.end():]


def lesser(formula):
    """A formula without one of its terms, or with what stands in brackets as something short."""
    terms = split(formula)
    if len(terms) > 1:
        for k in range(len(terms)):
            yield re.sub(r"^\s*\+\s*", "", "".join(terms[:k] + terms[k + 1:]))
    factors = split(formula, "*")
    if len(factors) > 1:
        for k in range(len(factors)):
            yield re.sub(r"^\s*\*\s*", "", "".join(factors[:k] + factors[k + 1:]))
    for start, end in brackets(formula):
        call = re.search(r"\w*$", formula[:start]).start()
        inside = formula[start + 1:end]
        arguments = [a.lstrip(", ") for a in split(inside, ",")]
        for short in ("1", *sorted(arguments, key=len)):
            yield formula[:call] + (short if len(split(short)) == 1 else f"({short})") + formula[end + 1:]
        for less in lesser(inside) if len(inside) > 3 else ():
            yield formula[:start + 1] + less + formula[end:]


def split(formula, at="+"):
    """Pieces at the signs outside brackets; each sign stays with what follows it."""
    pieces, depth, start = [], 0, 0
    for k, c in enumerate(formula):
        depth += (c in "([") - (c in ")]")
        if depth == 0 and c == at and k > start:
            pieces.append(formula[start:k])
            start = k
    return [*pieces, formula[start:]]


def brackets(formula):
    """(start, end) of the outermost round brackets."""
    depth = start = 0
    for k, c in enumerate(formula):
        if c == "(":
            start, depth = (k, 1) if depth == 0 else (start, depth + 1)
        elif c == ")" and depth:
            depth -= 1
            if depth == 0:
                yield start, k
