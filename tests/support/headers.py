"""The C of runtime/ as text: its statements, and what its headers define.

    python tests/support/headers.py     the statements of each folder, and of all
"""
import re
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[2]
RUNTIME = ROOT / "runtime"
STUBS = ("smg_stub_model.h", "smg_stub_functions.h", "smg_stub_template.h", "smg_stub_abi.h")      # for editors: they compile into no program
ASIDE = re.compile(r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.DOTALL)
MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.MULTILINE)
FUNCTION = re.compile(r"(\w+)\s*\([^;{}@]*\)\s*@")
RENAMED = re.compile(r"^#define smg_(\w+) smg_(?:lane|changed)_\1$", re.MULTILINE)      # for a template (runtime/core/smg_template.h): no definition
TYPE = re.compile(r"\btypedef\b[^;]*?(\w+);|\b(?:struct|union|enum)\s+(\w+)\s*@")
TABLE = re.compile(r"^(?:SMG_\w+ )?static const [\w ]+?(\w+)\[", re.MULTILINE)


def code(text: str) -> str:
    """Without comments, strings, and the ends of lines that go on."""
    return ASIDE.sub(" ", text).replace("\\\n", " ")


def statements(text: str) -> int:
    """Semicolons outside comments and strings."""
    return code(text).count(";")


def outside(text: str) -> str:
    """What stands outside all braces, and @ for what stands in them."""
    found, depth = [], 0
    for c in text:
        depth += c == "{"
        if depth == 0:
            found.append(c)
        elif depth == 1 and c == "}":
            found.append("@")
        depth -= c == "}"
    return "".join(found)


def defined(text: str) -> set:
    """The macros, functions, types and tables that a header defines; its own guard is none of them."""
    plain = RENAMED.sub("", code(text))
    top = outside(re.sub(r"^[ \t]*#.*$", "", plain, flags=re.MULTILINE))
    names = {*MACRO.findall(plain), *FUNCTION.findall(top), *TABLE.findall(plain), *(name for pair in TYPE.findall(top) for name in pair if name)}
    return names - set(re.findall(r"^#ifndef (\w+_H)$", text, re.MULTILINE)[:1])


def headers() -> list:
    return sorted(path for path in RUNTIME.rglob("*.h") if path.name not in STUBS)


def shared() -> dict:
    """name -> the headers that define it, where there are several."""
    found = defaultdict(set)
    for path in headers():
        for name in defined(path.read_text()):
            found[name].add(path.stem)
    return {name: where for name, where in found.items() if len(where) > 1}


def counts() -> dict:
    """folder of runtime/ -> its statements."""
    found = defaultdict(int)
    for path in headers():
        found[path.parent.relative_to(RUNTIME).as_posix()] += statements(path.read_text())
    return dict(found)


if __name__ == "__main__":
    table = counts()
    sys.stdout.write("".join(f"{room:16} {number:6}\n" for room, number in (*table.items(), ("all", sum(table.values())))))
