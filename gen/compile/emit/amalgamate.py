"""The single-file form: the runtime inside the two files of a model."""
from __future__ import annotations

import re

from ...resources import runtime_header
from .includes import active_lines, macros_of

# A model calls some of the runtime's functions only; in a header no compiler minds.
UNUSED_PUSH = """#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif"""
UNUSED_POP = """#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif"""


def inline_runtime(files, name: str):
    """Runtime headers put in the place of their #include, each once, but those without a guard, which serve several kinds of numbers."""
    seen: set = set()
    macros = macros_of(files[f"{name}.c"])

    def expand(text: str, outermost: bool = True) -> str:
        lines = []
        for line, active in active_lines(text, macros):
            included = line.removeprefix('#include "').removesuffix('"') if line.startswith('#include "smg') or \
                line.startswith('#include "smidgen') else None
            if included is None:
                lines.append(line)
            elif active and included not in seen:
                header = read_runtime(included)
                if guarded(header):
                    seen.add(included)
                inside = expand(header, False)
                lines += [UNUSED_PUSH, inside, UNUSED_POP] if outermost else [inside]
        return "\n".join(lines)

    out = type(files)()
    for kept, value in getattr(files, "__dict__", {}).items():
        setattr(out, kept, value)
    for key in (f"{name}.h", f"{name}.c"):
        out[key] = expand(files[key]) + "\n"
    out[f"{name}_abi.c"] = files[f"{name}_abi.c"]
    return out


def guarded(header: str) -> bool:
    """Is a header compiled once, however often it is included?"""
    return re.match(r"\s*/\*.*?\*/\s*#ifndef ", header, re.DOTALL) is not None


def read_runtime(name: str) -> str:
    return runtime_header(name).read_text()
