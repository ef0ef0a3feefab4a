"""A certificate in the comment block of the generated header.

Only numbers and the fixed words of `row` get there. What the file says is checked first: its format,
that it is of this very code (spec, method, solver, generator), and that every verdict is what its
numbers say. Text of the file is never copied.
"""
from __future__ import annotations

import json
import math
from pathlib import Path

from ...build.binary import generator_digest
from ...errors import UsageError
from .certificate import FORMAT, VERSION
from .row import CLAIMS, LEAST, MOST, NO, NOT_APPLICABLE, VERDICTS, YES, Row, verdict
from .subject import fingerprint

BYTES = 1 << 20


def read_certificate(file, scene, method: str, solver: str, features=()) -> list[str]:
    """The lines for the header of a selected spec. Raises UsageError for a file that does not fit."""
    data = parsed(file)
    if data.get("format") != FORMAT or data.get("version") != VERSION:
        raise UsageError(f"{file} is not a {FORMAT} of version {VERSION}")
    asked = {"fingerprint": (fingerprint(scene, method, solver, features),
                             "another spec, method or solver, or for other effects, values or features"),
             "generator_digest": (generator_digest(), "another version of the generator")}
    for key, (mine, what) in asked.items():
        if data.get(key) != mine:
            raise UsageError(f"{file}: the certificate belongs to {what}; create a new one with `smidgen verify`")
    rows = [checked(file, entry) for entry in listed(file, data)]
    if data.get("passed") is not all(row.verdict != NO for row in rows):
        raise UsageError(f"{file}: its verdict contradicts its rows")
    return lines(rows, positive(file, data, "h"), positive(file, data, "sites"))


def parsed(file) -> dict:
    """The JSON object of a file of moderate size."""
    try:
        with open(file, "rb") as handle:
            text = handle.read(BYTES + 1)
        data = json.loads(text.decode("utf-8")) if len(text) <= BYTES else None
    except OSError as problem:
        raise UsageError(f"cannot read {file}: {problem.strerror}") from None
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict):
        raise UsageError(f"{file} is not a certificate: not a JSON object of at most {BYTES} bytes")
    return data


def listed(file, data) -> list:
    """The rows: each name at most once, at least one."""
    rows = data.get("rows")
    names = [r.get("name") if isinstance(r, dict) else None for r in rows] if isinstance(rows, list) else []
    if not names or not all(isinstance(n, str) and n in CLAIMS for n in names) or len(set(names)) < len(names):
        raise UsageError(f"{file}: its rows do not form a certificate")
    return rows


def checked(file, entry: dict) -> Row:
    """One row of numbers and known words, whose verdict follows from its numbers."""
    name, said, relation = entry["name"], entry.get("verdict"), entry.get("relation")
    measured, bound = (number(file, name, entry.get(key)) for key in ("measured", "bound"))
    if said not in VERDICTS or relation not in (MOST, LEAST, ""):
        raise UsageError(f"{file}: row '{name}' has an invalid verdict or relation")
    bare = (measured, bound) == (None, None) and (said != YES or name == "order")     # an exact step has no order
    if not (said == verdict(measured, relation, bound) if relation else bare):
        raise UsageError(f"{file}: the verdict of row '{name}' contradicts its numbers")
    return Row(name, measured, relation, bound, said)


def number(file, name, value) -> float | None:
    """A finite number, or None for null."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e300:
        raise UsageError(f"{file}: row '{name}' contains a value that is not a finite number")
    return float(value)


def positive(file, data, key) -> float:
    """A number of the file's head, not 0."""
    value = number(file, key, data.get(key))
    if not value or not math.isfinite(value):
        raise UsageError(f"{file}: {key} is not a number")
    return value


def lines(rows, h: float, sites: float) -> list[str]:
    """A short table."""
    passed = all(row.verdict != NO for row in rows)
    head = f"Certificate: {'yes' if passed else 'NO'}, measured at h = {h:.6g} with {sites:.0f} sites"
    return [head, *(f"  {row.name:20} {row.verdict:4} {evidence(row)}".rstrip()
                    for row in rows if row.verdict != NOT_APPLICABLE)]


def evidence(row: Row) -> str:
    return f"{row.measured:.4g} ({row.criterion})" if row.measured is not None and row.bound is not None else ""


def embedded(header: str, table: list[str]) -> str:
    """The header with the table at the end of its first comment."""
    text, end, rest = header.partition(" */")
    return text + "\n *\n" + "\n".join(f" * {line}" for line in table) + end + rest


def with_certificate(files: dict, scene, method: str, solver: str, features, file: Path | str) -> dict:
    """The generated files with the certificate in `<model>.h`."""
    name = f"{scene.name}.h"
    return {**files, name: embedded(files[name], read_certificate(file, scene, method, solver, features))}
