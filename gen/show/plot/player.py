"""One HTML file that turns and plays a trajectory; it needs no network and no library.

The states travel as 16-bit integers (a picture's worth: 3e-5 of the radius), those of many sites as directions (`coding.py`),
times and energy errors as doubles. User text enters as JSON in a data element and is shown with
textContent; nothing of it is ever markup or script.
"""
from __future__ import annotations

import html

import numpy as np

from ...errors import UsageError
from .bundle import asset, script
from .chain import thinned
from .coding import packed, vectors
from .colours import DIVERGING, SEQUENTIAL, WHEEL, of_sites, of_table
from .leaf import leaf_of, mesh
from .sphere import graticule
from .style import method_style
from .text import in_html, in_script, of_all, printable
from .units import NONE

FRAMES = 3000           # most frames of a player
NUMBERS = 1_500_000     # coordinates that travel as they are (3 MB of the file)
ENOUGH = 100            # outputs that a player of more has, as far as BYTES allow
BYTES = 27_500_000      # of their states, which base64 makes a third more
QUANTUM = 32000         # greatest coordinate, as an integer
SHADES = 64             # most colours of a family


def player_page(t, states, energy=None, title: str = "", facts: str = "", casimirs=None,
                bonds=None, autoplay: bool = False, view=(35, 22), start: float = 0.0,
                note: str = "", method: str = "", more=None) -> str:
    """The HTML text of a player: a document of its own, for a file or for `framed`.

    t (k,); states {family: (k, count, 3)}; energy (k,) or None; casimirs {family: (3, 3)}
    for families that move on other quadrics than spheres; bonds {family: (m, 2)}: numbers of
    sites that lines join; start: the first frame shown, as a share of all; method: gives the
    energy its colour; more: places of sites and other numbers (`extras.py`).
    Raises UsageError when there is nothing to play.
    """
    if not states or len(t) == 0:
        raise UsageError("there is nothing to play: the result contains no states; run with --what states")
    slots = {"title": in_html(title or "Trajectory"), "style": asset("player.css"),
             "data": in_script(describe(t, states, energy, title, facts, casimirs or {}, bonds or {},
                                        autoplay, view, start, note, method, more)),
             "script": script()}
    return filled(asset("player.html"), slots)


def framed(page: str, title: str = "Trajectory") -> str:
    """A player inside another page: an element whose document is the whole text `page`.

    Its scripts run apart from those around it, and see nothing of them.
    """
    return (f'<iframe sandbox="allow-scripts" loading="lazy" title="{in_html(title)}" width="100%" '
            f'height="640" style="border: 0" srcdoc="{html.escape(page, quote=True)}"></iframe>')


def filled(page: str, slots: dict) -> str:
    """The template `page` with its {{ slots }} filled; what fills one is not looked at again."""
    parts = page.split("{{ ")
    tails = (part.split(" }}", 1) for part in parts[1:])
    return parts[0] + "".join(slots[name] + rest for name, rest in tails)


def describe(t, states, energy, title, facts, casimirs, bonds, autoplay, view, start,
             note, method, more=None) -> dict:
    """All that the script reads, as plain data."""
    keep = frames_of(t, states, not casimirs)
    facts = ", ".join(part for part in (facts, of_all(len(keep), len(t), "outputs")) if part)
    colors = of_sites({name: w.shape[1] for name, w in states.items()})
    cut = {name: np.asarray(w, float)[keep] for name, w in states.items()}
    cut = {name: np.where(np.isfinite(w), w, 0.0) for name, w in cut.items()}
    reach = max(max(float(np.abs(w).max()), float(np.linalg.norm(w, axis=2).max()))
                for w in cut.values()) or 1.0
    ball = not casimirs
    error = None if energy is None else finite(np.asarray(energy, float)[keep] - float(energy[0]))
    low, high = strip_range(error)
    coded = written(cut, reach, ball)
    return {"title": printable(title or "Trajectory"), "facts": printable(facts), "note": printable(note),
            "unit": printable((more.units if more else NONE)["energy"]), "timeUnit": printable((more.units if more else NONE)["time"]),
            "t": packed(np.asarray(t, float)[keep], "<f8"),
            "error": None if error is None else packed(error, "<f8"), "low": low, "high": high,
            "quantum": reach / QUANTUM, "reach": reach, "ball": ball,
            "radii": radii_of(cut) if ball else [reach], "view": list(view), "start": start,
            "backdrop": [packed(line, "<f4") for line in backdrop(cut, casimirs, reach)],
            "color": method_style(method)["color"], "wheel": WHEEL, "tables": {"diverging": of_table(DIVERGING), "sequential": of_table(SEQUENTIAL)},
            "families": [{**family(name, w, colors[name], bonds.get(name, ())), **coded[name], **(more.family(name) if more else {})}
                         for name, w in cut.items()],
            "maps": more.maps(keep) if more else [], "series": more.series(keep) if more else [],
            "trail": trail_choice(sum(w.shape[1] for w in cut.values())),
            "seconds": playing_time(cut), "autoplay": bool(autoplay)}


def frames_of(t, states, ball: bool) -> np.ndarray:
    """The outputs that become frames: all, or evenly chosen ones that fit the limits."""
    sites = sum(w.shape[1] for w in states.values())
    fit = int(BYTES / (2.75 if ball else 6) / max(sites, 1))
    return thinned(len(t), max(2, min(FRAMES, max(NUMBERS // max(3 * sites, 1), min(ENOUGH, fit)))))


def written(states, reach: float, ball: bool) -> dict:
    """family -> its states as they travel."""
    small = sum(w.size for w in states.values()) <= NUMBERS
    return {name: vectors(w, reach / QUANTUM, small, ball) for name, w in states.items()}


def family(name: str, w, colors, bonds) -> dict:
    """One family's looks; site i has colour number floor(i*colors/count)."""
    return {"name": printable(name), "count": int(w.shape[1]), "bonds": packed(bonds, "<i4"),
            "colors": [colors[i] for i in thinned(len(colors), SHADES)],
            "fine": int(np.clip(largest_turn(w) / 0.06, 1, 12))}


def largest_turn(w) -> float:
    """The greatest relative change of a site between two frames (k, count, 3)."""
    if len(w) < 2:
        return 0.0
    length = np.linalg.norm(w[:-1], axis=2)
    return float(np.max(np.linalg.norm(np.diff(w, axis=0), axis=2) / np.maximum(length, 1e-12)))


def trail_choice(sites: int) -> int:
    """Which trail is drawn at first: 3 whole, 2 medium, 1 short, 0 none."""
    return 3 if sites <= 4 else 2 if sites <= 30 else 1 if sites <= 60 else 0


def playing_time(states) -> float:
    """Seconds for the whole: two radians a second of the mean site, within 8 and 120."""
    paths = [np.linalg.norm(np.diff(w, axis=0), axis=2).sum(axis=0)
             / np.maximum(np.linalg.norm(w[0], axis=1), 1e-12) for w in states.values()]
    return float(np.clip(np.mean(np.concatenate(paths)) / 2, 8, 120))


def finite(values):
    """The values with NaN and infinities replaced by zero, which a strip cannot show."""
    return np.where(np.isfinite(values), values, 0.0)


def strip_range(error) -> tuple[float, float]:
    """(low, high) of the energy strip; never empty."""
    if error is None:
        return -1.0, 1.0
    low, high = float(error.min()), float(error.max())
    return (low, high) if high > low else (low - 1e-16, high + 1e-16)


def radii_of(states) -> list[float]:
    """The radii of the spheres that the sites start on, at most six, increasing."""
    first = np.concatenate([np.linalg.norm(w[0], axis=1) for w in states.values()])
    found = sorted({float(f"{r:.6g}") for r in first if r > 0})
    return found if len(found) <= 6 else [found[-1]]


def backdrop(states, casimirs, reach) -> list[np.ndarray]:
    """Polylines behind the trajectory: a sphere's graticule, or the leaf's coordinate lines."""
    if not casimirs:
        return [radii_of(states)[-1] * line[::2] for line in graticule()]
    lines = []
    for name, A in casimirs.items():
        for site in range(min(states[name].shape[1], 4)):
            lines += sheet_lines(A, states[name][:, site])
    return lines


def sheet_lines(A, w) -> list[np.ndarray]:
    """Coordinate lines of the leaf of one site w (k, 3); none where C = 0."""
    try:
        grid = mesh(leaf_of(A, [w]), 25, 49)
    except UsageError:
        return []
    return [*grid[::4], *np.swapaxes(grid, 0, 1)[::4]]
