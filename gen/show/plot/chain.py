"""A chain of spins over site and time, and as a closed curve on the sphere at a few times."""
from __future__ import annotations

import numpy as np

from . import sphere
from .colours import ordered
from .curves import TIME
from .style import footnote, new_figure, styled
from .text import of_all, shown
from .units import at_time, plain
from .view import View, split

CELLS = 600         # most rows and columns of an image


def directions(w) -> np.ndarray:
    """Unit vectors along w (.., 3); NaN, which has no colour, where a site is absent."""
    length = np.linalg.norm(w, axis=-1, keepdims=True)
    return w / np.where(length > 0, length, np.nan)


def thinned(count: int, most: int = CELLS) -> np.ndarray:
    """At most `most` of the numbers 0..count-1, evenly, both ends included."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))


@styled
def chain_image(t, w, title: str = "", note: str = "", told=plain):
    """theta (angle from z), phi (around z) and w_z of every site over time.

    t (k,), w (k, n, 3); `note` stands below.
    """
    keep, sites = thinned(len(t)), thinned(w.shape[1])
    unit = directions(np.asarray(w, float)[keep][:, sites])
    half = (t[-1] - t[0]) / (len(keep) - 1) / 2     # an output is in the middle of its row
    height = np.clip(unit[..., 2], -1, 1)
    shown_as = [(r"$\theta$ (rad)", np.arccos(height), "cividis", None, None),
                (r"$\phi$ (rad)", np.arctan2(unit[..., 1], unit[..., 0]), "twilight", -np.pi, np.pi),
                (r"$w_z/|w|$", height, "viridis", None, None)]
    figure = new_figure(10.2, 3.6)
    for ax, (label, values, colors, low, high) in zip(figure.subplots(1, 3, sharey=True), shown_as):
        image = ax.imshow(values, origin="lower", aspect="auto", cmap=colors, vmin=low, vmax=high,
                          extent=[-0.5, w.shape[1] - 0.5, t[0] - half, t[-1] + half])
        ax.grid(False)
        ax.set_xlabel("site $i$")
        figure.colorbar(image, ax=ax, label=label, pad=0.02)
        if ax.get_subplotspec().is_first_col():
            ax.set_ylabel(TIME.format(told("t")))
    figure.suptitle(shown(title) or "Evolution of the chain", x=0.01, ha="left", fontsize=10.5)
    footnote(figure, note, of_all(len(sites), w.shape[1]), of_all(len(keep), len(t), "outputs"))
    return figure


@styled
def chain_curves(t, w, times=None, bonds=None, title: str = "", view: View = View(30, 30), note: str = "", told=plain):
    """Spins w (k, n, 3) on the sphere at a few times (default six, evenly), joined by great arcs.

    bonds (m, 2): numbers of the spins that are joined; by default all, as a ring.
    """
    picks = np.linspace(0, len(t) - 1, 6).astype(int) if times is None else \
        np.array([int(np.argmin(np.abs(np.asarray(t) - x))) for x in times])
    columns = min(3, len(picks))
    rows = -(-len(picks) // columns)
    figure = new_figure(3.1 * columns, 3.2 * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    joined = ring(w.shape[1]) if bonds is None else np.asarray(bonds, int)
    span = np.asarray(t, float)[picks] - t[picks[0]]
    colors = ordered(span / (span[-1] or 1))
    radius = float(np.linalg.norm(w[0], axis=1).max())
    for ax, pick, color in zip(axes, picks, colors):
        sphere.ball(ax, view, radius, label=at_time(t[pick], told("t")))
        one_curve(ax, np.asarray(w[pick], float), joined, view, color)
    for ax in axes[len(picks):]:
        ax.remove()
    if title:
        figure.suptitle(shown(title), x=0.01, ha="left", fontsize=10.5)
    footnote(figure, note)
    return figure


def ring(count: int) -> np.ndarray:
    """(count, 2): each of the numbers 0..count-1 with the next, the last with the first."""
    return np.stack([np.arange(count), np.roll(np.arange(count), -1)], axis=1)


def one_curve(ax, spins, bonds, view, color) -> None:
    """Spins (n, 3), and great arcs along their bonds (m, 2)."""
    arcs(ax, spins, bonds, view, color, 1.3)
    sphere.points(ax, spins, view, color, 7, zorder=4)


def arcs(ax, spins, bonds, view, color, width: float) -> None:
    """The great arcs between joined spins: solid where they are seen, faint behind."""
    parts = [split(arc, view) for arc in great_arcs(spins, bonds)]
    front, back = ([piece for part in parts for piece in part[side]] for side in (0, 1))
    sphere.lines(ax, back, color, 0.8 * width, alpha=0.22, zorder=2.0)
    sphere.lines(ax, front, color, width, zorder=3.0)


def great_arcs(spins, bonds, pieces: int = 9) -> np.ndarray:
    """(m, pieces, 3) points along the great arcs between the spins that bonds (m, 2) join."""
    s = np.linspace(0, 1, pieces)[:, None]
    a, b = (spins[bonds[:, end], None] for end in (0, 1))
    mixed = a * (1 - s) + b * s
    r = np.linalg.norm(a, axis=2, keepdims=True)
    return r * mixed / np.maximum(np.linalg.norm(mixed, axis=2, keepdims=True), 1e-12)
