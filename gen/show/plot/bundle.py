"""ES modules as one script: each in a function of its own, after those that it imports."""
from __future__ import annotations

import re
from pathlib import Path

FOLDER = Path(__file__).with_name("web")
IMPORT = re.compile(r'^import \{([^}]*)\} from "\./(\w+)\.mjs";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async )?(?:function|const) (\w+))", re.MULTILINE)


def asset(name: str) -> str:
    """A file of a page, as text."""
    return (FOLDER / name).read_text(encoding="utf-8")


def script(main: str = "main") -> str:
    """`main` and all modules that it needs, which read no file."""
    order: list[str] = []
    visit(main, order)
    return '"use strict";\n(() => {\n' + "".join(wrapped(name) for name in order) + "})();\n"


def visit(name: str, order: list[str]) -> None:
    """Append the modules that `name` imports, then itself."""
    for _, other in IMPORT.findall(asset(f"{name}.mjs")):
        if other not in order:
            visit(other, order)
    order.append(name)


def wrapped(name: str) -> str:
    """A module as a function that returns what it exports."""
    text = asset(f"{name}.mjs")
    inner = IMPORT.sub(lambda m: f"const {{{m[1].replace(' as ', ': ')}}} = ${m[2]};\n", text)
    return f"const ${name} = (() => {{\n{EXPORT.sub('', inner)}return {{ {', '.join(EXPORT.findall(text))} }};\n}})();\n"
