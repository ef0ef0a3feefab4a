"""The page of the demo: what was shown, three spheres that move, the table, all figures; pictures are files beside it."""
from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import numpy as np

from ...errors import UsageError
from .colours import FAINT
from .bundle import asset
from .coding import packed
from .player import QUANTUM, filled
from .text import in_html, in_script, printable, prose

SMALL = 4096            # bytes at the head of a picture that tell its size
SCRIPTS = ("spheres.js", "page.js")


@dataclass(frozen=True)
class Picture:
    """One entry of the page: a file (.svg, .png) and its words."""
    name: str
    path: Path
    title: str
    caption: str = ""
    size: str = ""              # "broad": the whole width; "small": a third of it
    part: str = "figures"       # "opening", "cost" or "systems": the section of the page
    number: str = ""            # of the figure in the paper
    player: Path | None = None  # a page that plays it
    moving: dict | None = None  # of the opening: layers, backdrop and view of a sphere that moves, and seconds of a round


@dataclass(frozen=True)
class Row:
    """One line of the table: texts under the page's columns, and whether it passed."""
    cells: tuple[str, ...]
    passed: bool


@dataclass(frozen=True)
class Words:
    """What the page says beside its pictures. paper: (text, address) of parts, an empty address where it is no link;
    verdict: (what stands out, the rest)."""
    title: str
    headline: str = ""
    sentence: str = ""
    paper: tuple[tuple[str, str], ...] = ()
    verdict: tuple[str, str] = ("", "")
    lead: str = ""
    made: str = ""


def gallery(out_dir, columns, rows, pictures, words: Words) -> Path:
    """Write `index.html` into `out_dir`, and return its path.

    columns: (name, criterion); names that end in ' *' are those of numbers. Raises UsageError when a file cannot be read or written.
    """
    out = Path(out_dir) / "index.html"
    moving = [p for p in pictures if p.moving]
    part = lambda name: "\n".join(pictured(p, out.parent) for p in pictures if p.part == name and not p.moving)
    try:
        page = filled(asset("page.html"), {
            "style": asset("page.css"), "script": "\n".join(asset(name) for name in SCRIPTS),
            "title": in_html(words.title), "headline": in_html(words.headline), "sentence": in_html(words.sentence),
            "paper": "".join(linked(*piece) for piece in words.paper), "lead": in_html(words.lead), "made": in_html(words.made),
            "verdict": f"<b>{in_html(words.verdict[0])}</b> {in_html(words.verdict[1])}", "table": table(columns, rows),
            "spheres": "\n".join(sphere(p, out.parent) for p in moving), "data": in_script([numbers(p) for p in moving]),
            "figures": part("figures"), "cost": part("cost"), "systems": part("systems")})
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(page, encoding="utf-8")
    except OSError as e:
        raise UsageError(f"cannot write the page: {e}") from None
    return out


def linked(text: str, address: str) -> str:
    """Text, as a link where it has an address."""
    return f'<a href="{in_html(address)}">{in_html(text)}</a>' if address else in_html(text)


def table(columns, rows) -> str:
    """The table as HTML, with a line of criteria below the names."""
    kinds = ["number" if name.endswith(" *") else "" for name, _ in columns]
    kinds[-1] = "note"
    head = "".join(f'<th scope="col" class="{k}">{in_html(name.removesuffix(" *"))}</th>' for (name, _), k in zip(columns, kinds))
    criteria = "".join(f'<th class="{k}">{in_html(criterion)}</th>' for (_, criterion), k in zip(columns, kinds))
    lines = []
    for row in rows:
        cells = "".join(f'<td class="{k}">{in_html(c)}</td>' for c, k in zip(row.cells, kinds))
        lines.append(f'<tr class="{"good" if row.passed else "bad"}">{cells}<td class="verdict">{"ok" if row.passed else "FAILED"}</td></tr>')
    return (f'<table><thead><tr>{head}<th scope="col">verdict</th></tr><tr class="criteria">{criteria}<th></th></tr></thead>'
            f"<tbody>{''.join(lines)}</tbody></table>")


def caption(p: Picture, folder: Path, keys: str = "") -> str:
    """The figure's number in the paper, title, keys of colours, words, and the way to its player."""
    number = f'<span class="number">{in_html(p.number)}</span> ' if p.number else ""
    play = f' <a class="play" href="{address(p.player, folder)}">Open the player</a>' if p.player else ""
    return f"<figcaption>{number}<b>{in_html(p.title)}</b><p>{keys}{prose(p.caption)}</p>{play}</figcaption>"


def pictured(p: Picture, folder: Path) -> str:
    """A figure."""
    shown = image(p, folder, ' loading="lazy"')
    return f'<figure id="{in_html(p.name)}" class="{in_html(p.size)}">{shown}{caption(p, folder)}</figure>'


def image(p: Picture, folder: Path, more: str = "") -> str:
    """The picture, described by its title and words; as an image, an svg cannot run scripts or mix names."""
    size = "".join(f' {name}="{n}"' for name, n in zip(("width", "height"), size_of(p.path)))
    return f'<img alt="{in_html(f"{p.title}. {p.caption}")}" src="{address(p.path, folder)}"{size}{more}>'


def address(path: Path, folder: Path) -> str:
    """Of a file, from the folder of the page."""
    return quote(Path(os.path.relpath(path, folder)).as_posix())


def size_of(path: Path) -> tuple:
    """(width, height) of an svg or png, so that the page keeps its place; nothing where it does not say."""
    with open(path, "rb") as file:
        head = file.read(SMALL)
    if head.startswith(b"\x89PNG"):
        return tuple(int.from_bytes(head[k:k + 4], "big") for k in (16, 20))
    found = re.search(rb'<svg[^>]*? height="([\d.]+)pt"[^>]*? width="([\d.]+)pt"|<svg[^>]*? width="([\d.]+)pt"[^>]*? height="([\d.]+)pt"', head)
    sizes = [round(float(x)) for x in found.groups() if x] if found else []
    return tuple(reversed(sizes)) if found and found.group(1) else tuple(sizes)


# -- spheres that move -----------------------------------------------------------------------

def sphere(p: Picture, folder: Path) -> str:
    """A figure whose picture is for paper, and for readers without scripts; on screens a canvas moves in its place."""
    keys = "".join(f'<span class="key"><i style="background: {layer["colors"][0]}"></i>{in_html(layer["name"])}</span>'
                   for layer in p.moving["layers"] if layer["name"])
    return (f'<figure id="{in_html(p.name)}" class="moving"><div class="ball">{image(p, folder)}'
            f'<canvas id="canvas-{in_html(p.name)}" role="img" aria-label="{in_html(f"{p.title}. {p.caption}")}"></canvas></div>'
            f"{caption(p, folder, keys + '<br>' * bool(keys))}</figure>")


def numbers(p: Picture) -> dict:
    """What the script reads of a sphere: coordinates as 16-bit integers."""
    m = p.moving
    return {"name": printable(p.name), "view": list(m["view"]), "seconds": m["seconds"], "quantum": QUANTUM, "guide": FAINT,
            "backdrop": [whole(w) for w in m["backdrop"]],
            "layers": [{"kind": x["kind"], "colors": list(x["colors"]), "frames": len(x["w"]), "count": x["w"].shape[1], "w": whole(x["w"])}
                       for x in m["layers"]]}


def whole(w) -> str:
    """Points of the unit sphere, packed."""
    return packed(np.rint(np.asarray(w, float) * QUANTUM), "<i2")
