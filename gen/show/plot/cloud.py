"""Thousands of points on the sphere at a few times: tracers that a flow stirs."""
from __future__ import annotations

import numpy as np

from . import sphere
from .colours import ordered
from .style import footnote, new_figure
from .text import shown
from .units import at_time, plain
from .view import View

TIMES, SHADES = 6, 5


def cloud(t, w, title: str = "", view: View = View(30, 40), note: str = "", told=plain):
    """Sites w (k, n, 3) at six times, evenly; a shade for each fifth of them, by number, shows what mixes."""
    picks = np.unique(np.linspace(0, len(t) - 1, TIMES).astype(int))
    columns = min(3, len(picks))
    figure = new_figure(3.1 * columns, 3.2 * -(-len(picks) // columns))
    axes = figure.subplots(-(-len(picks) // columns), columns, squeeze=False).ravel()
    for ax, pick in zip(axes, picks):
        radius = float(np.linalg.norm(w[pick], axis=1).max())
        sphere.ball(ax, view, radius, label=at_time(t[pick], told("t")))
        for part, color in zip(np.array_split(np.asarray(w[pick], float), SHADES), ordered(np.linspace(0, 1, SHADES))):
            sphere.points(ax, part, view, color, 1.5, rasterized=True)
    for ax in axes[len(picks):]:
        ax.remove()
    if title:
        figure.suptitle(shown(title), x=0.01, ha="left", fontsize=10.5)
    footnote(figure, note)
    return figure
