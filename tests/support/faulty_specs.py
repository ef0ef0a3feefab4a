"""Faults drawn from the broken specs of tests/bad, planted together into one spec.

Each broken spec that differs from BASE in one section gives a fault: the text of that section, and
the errors it has alone, with lines counted from the section's own header.
"""
import re
from dataclasses import dataclass
from pathlib import Path

from smidgen.errors import SpecError
from smidgen.read import load_text

BAD = Path(__file__).parents[1] / "bad"
BASE = {
    "model": '[model]\nname = "m"',
    "space": '[space]\nw = { sphere = "n" }',
    "parameters": "[parameters]\nn = { default = 4 }\nJ = { default = 1.0 }",
    "effects.exchange": '[effects.exchange]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "-J*dot(w[i], w[j])"',
    "starts.s": '[starts.s]\ntheta = 1.0\nphi = "2*pi*i/n"',
    "runs.demo": '[runs.demo]\nstart = "s"\nh = 0.1\ntime = 10',
}
MANY = ("effects.exchange", "starts.s", "runs.demo")       # sections of which a spec may have several


@dataclass(frozen=True)
class Fault:
    """name: of the broken spec; section: of BASE; text: in its place; errors: (code, line, column)."""
    name: str
    section: str
    text: str
    errors: frozenset


def sections(text: str) -> list[str]:
    return [part.rstrip() for part in re.split(r"(?m)^(?=\[[a-z]+[\].])", text) if part.strip()]


def errors_of(text: str) -> list:
    """(code, line, column) of the errors of a spec; none when it is right."""
    try:
        load_text(text, str(BAD / "planted.toml"))
    except SpecError as error:
        return [(d.code, d.line, d.column) for d in error.diagnostics]
    return []


def join(parts) -> tuple[str, list[int]]:
    """(text, the line before each part)."""
    lines, at = [], []
    for part in parts:
        at.append(len(lines))
        lines += [*part.split("\n"), ""]
    return "\n".join(lines), at


def fault(path: Path) -> Fault | None:
    """What a broken spec has to plant, if it is wrong in one section of BASE alone."""
    found = sections(path.read_bytes().decode("utf-8", "replace"))
    wrong = [part for part in found if part not in BASE.values()]
    kept = [name for name, part in BASE.items() if part in found]
    if len(wrong) != 1 or len(kept) != len(BASE) - 1 or len(found) != len(BASE):
        return None
    (section,) = set(BASE) - set(kept)
    if not wrong[0].startswith(f"[{section}]\n"):
        return None
    text, at = join(wrong[0] if name == section else part for name, part in BASE.items())
    first = at[list(BASE).index(section)]
    size = len(wrong[0].split("\n"))
    errors = frozenset((code, line - first, column) for code, line, column in errors_of(text))
    inside = all(1 <= line <= size for _, line, _ in errors)
    return Fault(path.stem, section, wrong[0], errors) if errors and inside and len(errors) < 10 else None


def faults() -> list[Fault]:
    return [f for f in map(fault, sorted(BAD.glob("*.toml"))) if f]


def planted(chosen) -> tuple[str, dict]:
    """(text of BASE with these faults, {(code, line, column): fault}).

    A second fault of one section goes into another item of that kind.
    """
    parts, owners = list(BASE.values()), [None] * len(BASE)
    for number, one in enumerate(chosen):
        place = list(BASE).index(one.section)
        if owners[place] is None:
            parts[place], owners[place] = one.text, one
        else:
            parts.append(one.text.replace(f"[{one.section}]", f"[{one.section}_{number}]", 1))
            owners.append(one)
    text, at = join(parts)
    return text, {(code, first + line, column): one for one, first in zip(owners, at) if one
                  for code, line, column in one.errors}
