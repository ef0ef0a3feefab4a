"""Pictures of leaves: quadric sheets with trajectories on them."""
from __future__ import annotations

import numpy as np
from matplotlib.collections import PolyCollection

from .colours import BLUE, FAINT, INK
from .leaf import Leaf, leaf_of, mesh
from .sphere import LIGHT, lines
from .style import footnote, new_figure, styled
from .text import shown
from .view import View, parted


def faces(grid, normals, view: View, depth: bool = False):
    """Grid (m, n, 3) -> quadrilaterals (f, 4, 2) from far to near, with grey tones (f,).

    depth: also return the distance (f,) of each towards the viewer.
    """
    flat = view.project(grid)
    corner = lambda g: np.stack([g[:-1, :-1], g[1:, :-1], g[1:, 1:], g[:-1, 1:]], axis=2)
    quads = corner(flat).reshape(-1, 4, 3)
    light = LIGHT @ view.matrix / np.linalg.norm(LIGHT)
    n = corner(normals).mean(axis=2).reshape(-1, 3)
    n = n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-300)
    facing = np.where(n @ view.matrix[2] < 0, -1, 1)
    tone = 0.74 + 0.22 * np.clip((n @ light) * facing, 0, 1) - 0.05 * (facing < 0)
    near = quads[..., 2].mean(axis=1)
    order = np.argsort(near, kind="stable")
    found = quads[order, :, :2], tone[order], near[order]
    return found if depth else found[:2]


def paint(ax, quads, tone, alpha=1.0, zorder=1.0) -> None:
    """Shaded quadrilaterals on `ax`."""
    color = np.stack([tone * 0.98, tone * 0.99, np.minimum(tone * 1.015, 1),
                      np.full_like(tone, alpha)], axis=-1)
    ax.add_collection(PolyCollection(quads, facecolors=color, edgecolors=color,
                                     linewidths=0.3, zorder=zorder, rasterized=True))


def on_leaf(ax, leaf: Leaf, curves, view: View, color=BLUE) -> None:
    """The sheet and the trajectories on it: solid where seen, faint behind."""
    grid = mesh(leaf)
    paint(ax, *faces(grid, grid @ leaf.casimir, view))
    rim_lines(ax, leaf, grid, view)
    for w in curves:
        hidden_line(ax, leaf, w, view, color, 1.3)
    ax.set_aspect("equal")
    ax.axis("off")
    ax.autoscale_view()


def good_view(leaf: Leaf, curves) -> View:
    """A view that shows an open sheet's side with the trajectories, a closed one as usual."""
    if leaf.side == 0:
        return View(38, 24)
    x, y, _ = np.nanmean(np.concatenate(curves) @ leaf.casimir, axis=0)
    return View(float(np.degrees(np.arctan2(y, x))) - 32, 20)


def rim_lines(ax, leaf: Leaf, grid, view: View) -> None:
    """Thin coordinate lines of the mesh, to show its shape."""
    for w in [*grid[::6], grid[-1], *np.swapaxes(grid, 0, 1)[::8]]:
        hidden_line(ax, leaf, w, view, FAINT, 0.35, 0.5)


def hidden_line(ax, leaf: Leaf, w, view: View, color, width, strength=1.0) -> None:
    """One line on the sheet; what the sheet hides is faint."""
    w = np.asarray(w, float)
    w = w[np.all(np.isfinite(w), axis=1)]
    front, back = parted(view.project(w)[:, :2], leaf.seen(w, view))
    lines(ax, back, color, 0.8 * width, alpha=0.25 * strength, zorder=2)
    lines(ax, front, color, width, alpha=strength, zorder=3)


def cross(ax, view: View, length: float, corner=(0.0, 0.0)) -> None:
    """A small cross of axes with names, at a corner in data coordinates."""
    for name, e in zip(("$x$", "$y$", "$z$"), np.eye(3)):
        tip = view.project(e)[:2] * length
        ax.annotate("", xy=(corner[0] + tip[0], corner[1] + tip[1]), xytext=corner,
                    arrowprops={"arrowstyle": "->", "color": INK, "lw": 0.8}, zorder=8)
        ax.text(corner[0] + 1.28 * tip[0], corner[1] + 1.28 * tip[1], name, fontsize=8,
                ha="center", va="center", color=INK, zorder=8)


def add_cross(ax, view: View) -> None:
    """The cross of axes below the lower left corner of what is drawn."""
    low, high = ax.dataLim.min, ax.dataLim.max
    size = 0.11 * max(high - low)
    cross(ax, view, size, (low[0] - 0.2 * size, low[1] - 0.4 * size))
    ax.set_xlim(low[0] - 2.0 * size, high[0] + 0.4 * size)
    ax.set_ylim(low[1] - 2.0 * size, high[1] + 0.4 * size)


@styled
def leaves(cases, columns: int = 3, note: str = ""):
    """Trajectories on level sets of C, a panel for each case; `note` stands below.

    cases: mappings with `title`, `casimir` (3, 3) and `curves` (list of (k, 3)); `view` and
    `color` optional.
    """
    rows = -(-len(cases) // columns)
    columns = min(columns, len(cases))
    size = 4.6 if len(cases) == 1 else 3.3
    figure = new_figure(size * columns, (size + 0.1) * rows)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, case in zip(grid, cases):
        leaf = leaf_of(case["casimir"], case["curves"])
        sight = case.get("view") or good_view(leaf, case["curves"])
        on_leaf(ax, leaf, case["curves"], sight, case.get("color", BLUE))
        add_cross(ax, sight)
        ax.set_title(shown(case["title"]))
    for ax in grid[len(cases):]:
        ax.remove()
    footnote(figure, note)
    return figure
