"""User text in pictures and pages: shown as written, never interpreted."""
from __future__ import annotations

import html
import json
import re
import unicodedata

LONGEST = 200       # characters of a title or name that a picture shows
PARAGRAPH = 4000    # characters of a text on a page


def printable(text, longest: int = LONGEST) -> str:
    """`text` on one line, without control and invisible characters, at most `longest` long."""
    clean = "".join(" " if c.isspace() else c for c in str(text)
                    if c.isspace() or unicodedata.category(c) not in ("Cc", "Cf", "Cs", "Co", "Cn"))
    return clean if len(clean) <= longest else clean[:longest - 1] + "\u2026"


def shown(text) -> str:
    """`text` for matplotlib: a dollar sign stays a dollar sign and starts no formula."""
    return printable(text).replace("$", r"\$")


def in_html(text) -> str:
    """`text` for HTML, in an element or in a quoted attribute."""
    return html.escape(printable(text, PARAGRAPH), quote=True)


def prose(text) -> str:
    """`text` as HTML, with 3e-04 as a power of ten that no line is broken in."""
    powers = re.sub(r"(?<![\w.])([\d.]*\d)e([+-]?)0*(\d+)\b", '<span class="power">\\1\u00d710<sup>\\2\\3</sup></span>', in_html(text))
    return powers.replace("<sup>-", "<sup>\u2212").replace("<sup>+", "<sup>")


def in_script(value) -> str:
    """`value` as JSON that cannot end the <script> element which holds it.

    Raises ValueError for NaN and infinities, which JSON does not have.
    """
    text = json.dumps(value, allow_nan=False, ensure_ascii=True, separators=(",", ":"))
    return text.replace("<", r"\u003c").replace(">", r"\u003e").replace("&", r"\u0026")


def of_all(drawn: int, every: int, what: str = "sites") -> str:
    """"24 of 400 sites shown", or "" where all are."""
    return "" if drawn >= every else f"{drawn} of {every} {what} shown"
