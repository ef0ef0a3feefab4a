"""The three spheres that move at the head of the page: what each shows, as layers of points.

A layer is {"name", "kind", "colors", "w"}: w (frames, orbits, 3), a colour for each orbit; kind "dots" leaves every point
where it fell, "trails" shows the sites with the last part of their paths.
"""
from __future__ import annotations

import numpy as np

from ...read.shipped import load_spec
from ...methods import METHODS, MIDPOINTS
from ...run.step.integrator import build
from ..plot import colours
from ..plot.portraits import on_manifold
from ..plot.style import method_style
from . import paths

PERIODS, PART = 400, 4          # periods of the section; chaotic orbits are that many times as long, in parts
START = on_manifold(0.75, 0.95)


def body_layers(classical, spherical) -> list[dict]:
    """Computed points (k, 3) of both midpoint methods."""
    return [dots(METHODS[name].label, [method_style(name)["color"]], w[:, None])
            for name, w in ((MIDPOINTS[1], classical), (MIDPOINTS[0], spherical))]


def dots(name: str, colors, w) -> dict:
    return {"name": name, "kind": "dots", "colors": list(colors), "w": w}


def section_layers(orbit, starts, is_chaotic) -> list[dict]:
    """States at the multiples of the period; orbit: (w, periods) -> (periods+1, 3)."""
    found = [(w, orbit(w, PERIODS)) for w in starts]
    regular = [points for _, points in found if not is_chaotic(orbit, points)]
    chaotic = [part for w, points in found if is_chaotic(orbit, points)
               for part in np.split(orbit(w, PART * (PERIODS + 1) - 1), PART)]
    layers = [dots("regular orbits", colours.regular(len(regular)), np.stack(regular, axis=1))]
    return layers + [dots("chaotic orbits", [colours.CHAOTIC] * len(chaotic), np.stack(chaotic, axis=1))] * bool(chaotic)


def vortices():
    """(one layer of four vortices over a period, closed curves of the first for other starts, how far they end from the start)."""
    model = build(load_spec("vortex_manifold"))
    states = paths.path(model, START, 0.02, 4000)
    away = np.linalg.norm(states - states[0], axis=2).max(axis=1)
    end = 500 + int(np.argmin(away[500:]))
    layer = {"name": "", "kind": "trails", "colors": colours.of_sites({"w": 4})["w"], "w": states[:end + 1:4]}
    return [layer], paths.covering(lambda w: around(model, w), 0.3, most=30), float(away[end])


def around(model, w):
    """The path of the first vortex from w once around, every fourth point; None beside a collision."""
    if np.max(np.abs(w)) > 0.97:
        return None
    states = paths.path(model, on_manifold(np.arccos(w[2]), np.arctan2(w[1], w[0])), 0.04, 3000)
    return paths.closed(states[:, 0], 0.025)[::4]
