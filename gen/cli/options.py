"""Options that several sub-commands share, and how their text becomes values."""
from __future__ import annotations

import argparse
import math

from ..library import METHODS, SOLVERS


def spec_argument(parser, **more):
    """SPEC."""
    parser.add_argument("spec", metavar="SPEC", **more,
                        help="a .toml file, or the name of a shipped spec (`smidgen list`)")


def model_options(parser):
    """What decides the C: RUN, --method, --solver, --effects, --set."""
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec; default: its first")
    parser.add_argument("--method", choices=METHODS, help="the integrator; default: the run's")
    parser.add_argument("--solver", choices=SOLVERS, help="solver of the step equation")
    parser.add_argument("--effects", type=names, metavar="A,B", help="keep these effects only")
    parser.add_argument("--set", type=assignment, action="append", default=[], dest="values",
                        metavar="NAME=VALUE", help="a parameter; a list as 1,2,3; repeatable")


def json_option(parser):
    """--json."""
    parser.add_argument("--json", action="store_true", help="answer in JSON on stdout")


def names(text: str) -> tuple[str, ...]:
    """`a,b` -> ("a", "b")."""
    found = tuple(word.strip() for word in text.split(",") if word.strip())
    if not found:
        raise argparse.ArgumentTypeError("a list of names, such as a,b")
    return found


def assignment(text: str) -> tuple[str, object]:
    """`J=2` -> ("J", 2), `gamma=1,1,-1` -> ("gamma", [1, 1, -1])."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"'{text}' is not NAME=VALUE, such as J=2 or g=1,1,-1")
    parts = [plain_number(part) for part in value.split(",")]
    return name.strip(), parts[0] if len(parts) == 1 else parts


def plain_number(text: str):
    """An int or a finite float."""
    text = text.strip()
    try:
        value = int(text) if text.lstrip("+-").isdecimal() else float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not finite")
    return value


def length(text: str) -> float:
    """A number, or one times or over pi: `2*pi`, `pi/10`, `2*pi/20`."""
    try:
        return factors(text.replace(" ", ""))
    except (ValueError, ZeroDivisionError):
        raise argparse.ArgumentTypeError(f"'{text}' is neither a number nor like 2*pi/20") from None


def factors(text: str) -> float:
    """Products and quotients of numbers and pi, from the left."""
    value, operator, word = 1.0, "*", ""
    for c in text + "*":
        if c in "*/":
            factor = math.pi if word == "pi" else -math.pi if word == "-pi" else float(word)
            value = value * factor if operator == "*" else value / factor
            operator, word = c, ""
        else:
            word += c
    if not math.isfinite(value):
        raise ValueError("not finite")
    return value


def whole(text: str) -> int:
    """An integer from 0 up; 1e6 is one."""
    value = plain_number(text)
    if value != int(value) or value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not an integer from 0 up")
    return int(value)
