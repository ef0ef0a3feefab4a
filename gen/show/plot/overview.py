"""Many systems on one sheet, a small panel each."""
from __future__ import annotations

import numpy as np

from . import sphere
from .chain import arcs
from .colours import ordered
from .leaf import leaf_of
from .pictures import MANY, bonds_of, labelled, smooth, states_of
from .style import new_figure, styled
from .surfaces import good_view, on_leaf
from .text import of_all, shown
from .view import View

TRAIL = 0.035       # share of a run that a trail shows where there are many sites


@styled
def overview(results, columns: int = 5, view: View = View(30, 26)):
    """A panel for each Result (as `plot` takes them), titled with the spec's name."""
    rows = -(-len(results) // columns)
    figure = new_figure(2.5 * columns, 2.62 * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, result in zip(axes, results):
        drawn = panel(ax, result, view)
        said = of_all(drawn, sum(w.shape[1] for w in result.w.values()))
        ax.set_title(shown(result.meta.get("spec", "")) + f"\n{said}" * bool(said), loc="center", fontsize=9)
    for ax in axes[len(results):]:
        ax.remove()
    return figure


def panel(ax, result, view: View) -> int:
    """A leaf for Nambu factors alone, arcs for chains, else trails on the sphere; how many sites that shows."""
    states, matrices = states_of(result), result.meta.get("casimirs") or {}
    name, w = next(iter(states.items()))
    if all(n in matrices for n in states):
        leaf = leaf_of(matrices[name], [w[:, 0]])
        on_leaf(ax, leaf, [w[:, 0]], good_view(leaf, [w[:, 0]]))
        return 1
    spheres = {n: v for n, v in states.items() if n not in matrices}
    sphere.ball(ax, view, max(float(np.linalg.norm(v[0], axis=1).max()) for v in spheres.values()), axes=False)
    ax.grid(False)
    bonds = bonds_of(result, name)
    if name in spheres and w.shape[1] > MANY and len(bonds) and smooth(w[0], bonds) and smooth(w[-1], bonds):
        evolving(ax, w, bonds, view)
        return w.shape[1]
    trails(ax, [site for site in labelled(states) if site[0].split("[")[0] in spheres], view)
    return sum(v.shape[1] for v in spheres.values())


def evolving(ax, w, bonds, view: View, times: int = 5) -> None:
    """Spins w (k, n, 3), as arcs along their bonds, at a few times of the run's first tenth."""
    shares = np.linspace(0, 1, times)
    for share, color in zip(shares, ordered(shares)):
        arcs(ax, w[int(share * (len(w) // 10))], bonds, view, color, 1.0)


def trails(ax, paths, view: View) -> None:
    """Whole paths of few sites, short trails of many, a disc at the end of each."""
    share = 1.0 if len(paths) <= 2 else 0.35 if len(paths) <= 8 else TRAIL
    for _, color, w in paths:
        tail = w[-max(2, int(share * len(w))):]
        sphere.curve(ax, tail, view, color, 0.9)
        sphere.points(ax, tail[-1:], view, color, 14 if len(paths) <= 8 else 7, edge="white"
                      if len(paths) <= 8 else "none", zorder=5)
