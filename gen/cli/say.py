"""Data goes to stdout, narration to stderr."""
from __future__ import annotations

import json
import math
import sys
import webbrowser
from pathlib import Path

from ..errors import SmidgenError, SpecError


def say(*words) -> None:
    """Narration."""
    print(*words, file=sys.stderr)


def printed(data) -> None:
    """Data as JSON; what JSON cannot hold (NaN, infinity) becomes null."""
    print(json.dumps(clean(data), indent=2, ensure_ascii=False))


def opened(path: Path, wanted: bool) -> None:
    """Open a file in the browser if that is wanted."""
    if wanted and not webbrowser.open(path.resolve().as_uri()):
        say(f"no browser was found to open {path}")


def clean(data):
    """`data` with NaN and infinities replaced by None, keys by strings."""
    if isinstance(data, dict):
        return {str(k): clean(v) for k, v in data.items()}
    if isinstance(data, (list, tuple)):
        return [clean(v) for v in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data


def describe(error: SmidgenError) -> dict:
    """An error as JSON has it."""
    facts = {k: v for k, v in vars(error).items() if isinstance(v, (int, float, str))}
    found = {"kind": type(error).__name__, "message": str(error),
             "exit_code": int(error.exit_code), **facts}
    if isinstance(error, SpecError):
        found["diagnostics"] = [vars(d) for d in error.diagnostics]
    return found


def notes_line(notes: dict) -> str:
    """What was chosen, in one line: the solver and why."""
    reason = notes.get("reason")
    rest = "; ".join(f"{key} {value}" for key, value in notes.items()
                     if key in ("solver",) or reason is None)
    return f"{rest} ({reason})" if reason else rest
