"""docs/files.md: every source file with the first sentence of its comment.

    make files                                  # the page, written anew
    python tests/support/file_index.py          # the same page, printed
"""
from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/files.md"
PLACES, ENDINGS = ("gen", "templates", "runtime"), (".py", ".h", ".c", ".j2", ".mjs", ".js")
HEAD = """# Source files

This page is written by `make files`: every Python, C and JavaScript file and every template, with the first sentence of its comment. [architecture.md](architecture.md)
explains how the folders depend on each other, and which files a change concerns.
"""
COMMENT = re.compile(r"/\*(?P<c>.*?)\*/|\{#-?(?P<jinja>.*?)-?#\}|(?P<lines>(?://[^\n]*\n?)+)", re.DOTALL)
SENTENCE = re.compile(r"(?:\((?:[^()]|\([^()]*\))*\)|[^()])*?[.?!](?=\s+[A-Z`<]|$)")       # ends outside of parentheses
KIND = re.compile(r"^(smidgen [\w ]+: |<model>\S* -- )")


def comment_of(path: Path) -> str:
    """The comment, or the docstring, at the head of a file; "" where there is none."""
    text = path.read_text()
    if path.suffix == ".py":
        return text.split('"""')[1] if text.startswith('"""') else ""
    found = COMMENT.match(text.lstrip())
    return re.sub(r"(?m)^\s*(\*|//) ?", "", next(t for t in found.groups() if t is not None)).strip() if found else ""


def sentence_of(path: Path) -> str:
    """The first sentence in one line, without the words `smidgen runtime:` of headers."""
    paragraph = KIND.sub("", " ".join(comment_of(path).replace("{{ M }}", "<model>").partition("\n\n")[0].split()))
    found = SENTENCE.match(paragraph)
    return re.sub(r"^[a-z]{2,}\b|^a ", lambda word: word[0].capitalize(), (found[0] if found else paragraph).removesuffix(":").removesuffix("."))


def sources(root: Path = ROOT) -> dict:
    """folder -> its files in the order of their names; packages without a word of their own are left out."""
    found = {}
    for path in sorted(p for place in PLACES for p in (root / place).rglob("*")):
        if path.suffix in ENDINGS and (path.name != "__init__.py" or comment_of(path)):
            found.setdefault(path.parent.relative_to(root).as_posix(), []).append(path)
    return dict(sorted(found.items()))


def without_comment() -> list[str]:
    return [p.relative_to(ROOT).as_posix() for files in sources().values() for p in files if not sentence_of(p)]


def page() -> str:
    def row(path: Path) -> str:
        return f"| `{path.name}` | {sentence_of(path).replace('|', chr(92) + '|').replace('<', '&lt;')} |"
    tables = ["\n".join([f"\n## {folder}\n", "| file | contents |", "|---|---|", *map(row, files)]) for folder, files in sources().items()]
    return "\n".join([HEAD.rstrip(), *tables, ""])


if __name__ == "__main__":
    PAGE.write_text(page()) if "--write" in sys.argv[1:] else print(page(), end="")
