"""A chain of spins over site and time, and as a closed curve on the sphere at a few times."""
from __future__ import annotations

import matplotlib
import numpy as np

from . import sphere
from .style import new_figure, styled
from .text import shown
from .view import View
from .curves import TIME

CELLS = 600         # most rows and columns of an image


def thinned(count: int, most: int = CELLS) -> np.ndarray:
    """At most `most` of the numbers 0..count-1, evenly, both ends included."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))


@styled
def chain_image(t, w, title: str = ""):
    """theta (angle from z), phi (around z) and w_z of every site over time.

    t (k,), w (k, n, 3).
    """
    keep, sites = thinned(len(t)), thinned(w.shape[1])
    part = np.asarray(w, float)[keep][:, sites]
    unit = part / np.maximum(np.linalg.norm(part, axis=2, keepdims=True), 1e-300)
    height = np.clip(unit[..., 2], -1, 1)
    shown_as = [(r"$\theta$ (rad)", np.arccos(height), "cividis", None, None),
                (r"$\phi$ (rad)", np.arctan2(unit[..., 1], unit[..., 0]), "twilight", -np.pi, np.pi),
                (r"$w_z/|w|$ (dimensionless)", height, "viridis", None, None)]
    figure = new_figure(10.2, 3.6)
    for ax, (label, values, colors, low, high) in zip(figure.subplots(1, 3, sharey=True), shown_as):
        image = ax.imshow(values, origin="lower", aspect="auto", cmap=colors, vmin=low, vmax=high,
                          extent=[-0.5, w.shape[1] - 0.5, t[0], t[-1]])
        ax.grid(False)
        ax.set_xlabel("site $i$ (number)")
        figure.colorbar(image, ax=ax, label=label, pad=0.02)
        if ax.get_subplotspec().is_first_col():
            ax.set_ylabel(TIME)
    figure.suptitle(shown(title) or "Evolution of the chain", x=0.01, ha="left", fontsize=10.5)
    return figure


@styled
def chain_curves(t, w, times=None, closed: bool = True, title: str = "", view: View = View(30, 30)):
    """The chain w (k, n, 3) as a curve on the sphere at a few times (default six, evenly)."""
    picks = np.linspace(0, len(t) - 1, 6).astype(int) if times is None else \
        np.array([int(np.argmin(np.abs(np.asarray(t) - x))) for x in times])
    columns = min(3, len(picks))
    rows = -(-len(picks) // columns)
    figure = new_figure(3.1 * columns, 3.2 * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    colors = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.8, len(picks)))
    for ax, pick, color in zip(axes, picks, colors):
        sphere.ball(ax, view, label=f"$t$ = {t[pick]:g} (model units)")
        one_curve(ax, np.asarray(w[pick], float), closed, view, color)
    for ax in axes[len(picks):]:
        ax.remove()
    if title:
        figure.suptitle(shown(title), x=0.01, ha="left", fontsize=10.5)
    return figure


def one_curve(ax, spins, closed, view, color) -> None:
    """Spins (n, 3) joined by great arcs, and the spins themselves."""
    around = np.concatenate([spins, spins[:1]]) if closed else spins
    sphere.curve(ax, great_arcs(around), view, color, 1.3)
    sphere.points(ax, spins, view, color, 7, zorder=4)


def great_arcs(spins, pieces: int = 8) -> np.ndarray:
    """Points along the great arcs that join consecutive spins (m, 3)."""
    s = np.linspace(0, 1, pieces, endpoint=False)[:, None]
    mixed = np.concatenate([a * (1 - s) + b * s for a, b in zip(spins[:-1], spins[1:])])
    r = np.linalg.norm(spins[0])
    return r * mixed / np.maximum(np.linalg.norm(mixed, axis=1, keepdims=True), 1e-12)
