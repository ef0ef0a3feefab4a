"""Many systems on one sheet, a small panel each."""
from __future__ import annotations

import matplotlib
import numpy as np

from . import sphere
from .chain import great_arcs
from .leaf import leaf_of
from .pictures import MANY, labelled, smooth, states_of
from .style import PALETTE, new_figure, styled
from .surfaces import good_view, on_leaf
from .text import shown
from .view import View

TRAIL = 0.035       # share of a run that a trail shows where there are many sites


@styled
def overview(results, columns: int = 5, view: View = View(30, 26)):
    """A panel for each Result (as `plot` takes them), titled with the spec's name."""
    rows = -(-len(results) // columns)
    figure = new_figure(2.5 * columns, 2.62 * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, result in zip(axes, results):
        panel(ax, result, view)
        ax.set_title(shown(result.meta.get("spec", "")), loc="center", fontsize=9)
    for ax in axes[len(results):]:
        ax.remove()
    return figure


def panel(ax, result, view: View) -> None:
    """Leaves for Nambu factors, curves for chains, else trails on the sphere."""
    states, matrices = states_of(result), result.meta.get("casimirs") or {}
    name, w = next(iter(states.items()))
    if name in matrices:
        leaf = leaf_of(matrices[name], [w[:, 0]])
        return on_leaf(ax, leaf, [w[:, 0]], good_view(leaf, [w[:, 0]]))
    radius = max(float(np.linalg.norm(v[0], axis=1).max()) for n, v in states.items()
                 if n not in matrices)
    sphere.ball(ax, view, radius, axes=False)
    ax.grid(False)
    if w.shape[1] > MANY and smooth(w[0]) and smooth(w[-1]):
        return evolving(ax, w, view)
    trails(ax, {n: v for n, v in states.items() if n not in matrices}, view)


def evolving(ax, w, view: View, times: int = 5) -> None:
    """A closed curve of spins w (k, n, 3) at a few times of the run's first tenth."""
    picks = np.linspace(0, len(w) // 10, times).astype(int)
    for pick, color in zip(picks, matplotlib.colormaps["viridis"](np.linspace(0, 0.85, times))):
        sphere.curve(ax, great_arcs(np.concatenate([w[pick], w[pick][:1]])), view, color, 1.0)


def trails(ax, states, view: View) -> None:
    """Paths of few sites, short trails of many, a dot at the end of each."""
    paths = labelled(states)
    share = 1.0 if len(paths) <= 2 else 0.35 if len(paths) <= 8 else TRAIL
    for i, (_, w) in enumerate(paths):
        tail = w[-max(2, int(share * len(w))):]
        color = PALETTE[i % 6]
        sphere.curve(ax, tail, view, color, 0.9)
        sphere.points(ax, tail[-1:], view, color, 14 if len(paths) <= 8 else 7, edge="white"
                      if len(paths) <= 8 else "none", zorder=5)
