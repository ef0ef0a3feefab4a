"""One self-contained page: the table of the demo, the players, all figures."""
from __future__ import annotations

import base64
from dataclasses import dataclass
from pathlib import Path

from ...errors import UsageError
from .player import asset, filled, framed
from .text import in_html

MEDIA = {".svg": "image/svg+xml", ".png": "image/png"}


@dataclass(frozen=True)
class Picture:
    """One entry of the page: a file (.svg, .png, or .html for a player) and its words."""
    name: str
    path: Path
    title: str
    caption: str = ""
    size: str = ""          # "broad": the whole width; "small": a third of it
    part: str = "figures"   # "opening" or "systems": the section of the page


@dataclass(frozen=True)
class Row:
    """One line of the table: texts under the page's columns, and whether it passed."""
    cells: tuple[str, ...]
    passed: bool


def gallery(out_dir, columns, rows, pictures, title: str, lead: str = "") -> Path:
    """Write `index.html` into `out_dir` with everything inlined, and return its path.

    columns: names; those that end in ' *' hold numbers. rows: Row; pictures: Picture.
    Raises UsageError when a file cannot be read or written.
    """
    players = [p for p in pictures if p.path.suffix == ".html"]     # in the order given
    figures = [p for p in pictures if p.path.suffix in MEDIA]
    try:
        page = filled(asset("page.html"), {
            "title": in_html(title), "lead": in_html(lead), "table": table(columns, rows),
            "opening": "\n".join(pictured(p) for p in figures if p.part == "opening"),
            "players": "\n".join(played(p) for p in players),
            "figures": "\n".join(pictured(p) for p in figures if p.part == "figures"),
            "systems": "\n".join(pictured(p) for p in figures if p.part == "systems")})
        out = Path(out_dir) / "index.html"
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(page, encoding="utf-8")
    except OSError as e:
        raise UsageError(f"cannot write the page: {e}") from None
    return out


def table(columns, rows) -> str:
    """The table as HTML."""
    kinds = ["number" if c.endswith(" *") else "" for c in columns]
    kinds[-1] = "note"
    head = "".join(f'<th class="{k}">{in_html(c.removesuffix(" *"))}</th>'
                   for c, k in zip(columns, kinds))
    lines = []
    for row in rows:
        cells = "".join(f'<td class="{k}">{in_html(c)}</td>' for c, k in zip(row.cells, kinds))
        verdict = "ok" if row.passed else "FAILED"
        lines.append(f'<tr class="{"good" if row.passed else "bad"}">{cells}'
                     f'<td class="verdict">{verdict}</td></tr>')
    return f"<table><thead><tr>{head}<th></th></tr></thead><tbody>{''.join(lines)}</tbody></table>"


def caption(p: Picture) -> str:
    """Title and caption below a picture."""
    return f"<figcaption><b>{in_html(p.title)}.</b> {in_html(p.caption)}</figcaption>"


def pictured(p: Picture) -> str:
    """A figure whose image is inlined. As an image, an svg cannot run scripts or mix names."""
    data = base64.b64encode(p.path.read_bytes()).decode("ascii")
    return (f'<figure id="{in_html(p.name)}" class="{in_html(p.size)}">'
            f'<img alt="{in_html(p.title)}" src="data:{MEDIA[p.path.suffix]};base64,{data}">'
            f"{caption(p)}</figure>")


def played(p: Picture) -> str:
    """A figure that holds a player."""
    return (f'<figure id="{in_html(p.name)}">{framed(p.path.read_text(encoding="utf-8"), p.title)}'
            f"{caption(p)}</figure>")
