"""Drawing on a shaded sphere: the front solid, the back faint."""
from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.patheffects import withStroke

from .colours import BLUE, FAINT, INK, SINGULAR
from .view import View, split, visible

LIGHT = np.array([-0.45, 0.65, 0.61])       # direction of the light in view coordinates
MIST = (0.90, 0.91, 0.93)       # what the back of the ball looks like
AXES = {"$w_x$": (1, 0, 0), "$w_y$": (0, 1, 0), "$w_z$": (0, 0, 1)}


def shading(size: int = 240) -> np.ndarray:
    """(size, size, 4) image of a matt ball that fills [-1, 1]^2, transparent outside."""
    y, x = np.mgrid[1:-1:size * 1j, -1:1:size * 1j]
    r2 = x * x + y * y
    z = np.sqrt(np.clip(1 - r2, 0, 1))
    lambert = np.clip((x * LIGHT[0] + y * LIGHT[1] + z * LIGHT[2]) / np.linalg.norm(LIGHT), 0, 1)
    tone = 0.86 + 0.13 * lambert
    alpha = np.clip((1 - np.sqrt(r2)) * size / 2, 0, 1)
    return np.stack([tone * 0.985, tone * 0.993, np.minimum(tone * 1.01, 1), alpha], axis=-1)


def graticule(step: int = 30, points: int = 121) -> list[np.ndarray]:
    """Meridians and parallels of the unit sphere every `step` degrees, each (points, 3)."""
    t = np.linspace(0, 2 * np.pi, points)
    lines = [np.stack([np.cos(a) * np.sin(t), np.sin(a) * np.sin(t), np.cos(t)], 1)
             for a in np.radians(np.arange(0, 180, step))]
    for a in np.radians(np.arange(step - 90, 90, step)):
        lines.append(np.stack([np.cos(a) * np.cos(t), np.cos(a) * np.sin(t),
                               np.full_like(t, np.sin(a))], 1))
    return lines


def ball(ax, view: View = View(), radius: float = 1.0, axes: bool = True, label: str = "") -> None:
    """An empty shaded sphere with its graticule and the ends of the coordinate axes on `ax`."""
    ax.set_aspect("equal")
    ax.axis("off")
    ax.imshow(shading(), extent=[-radius, radius, -radius, radius], zorder=0,
              interpolation="bilinear")
    for line in graticule():
        front, back = split(radius * line, view)
        lines(ax, front, FAINT, 0.45, alpha=0.40, zorder=1.2)
        lines(ax, back, FAINT, 0.4, alpha=0.13, zorder=1.1)
    if axes:
        axis_ends(ax, view, radius)
    margin = 1.3 if axes else 1.05
    ax.set_xlim(-margin * radius, margin * radius)
    ax.set_ylim(-margin * radius, margin * radius)
    ax.set_title(label)


def axis_ends(ax, view: View, radius: float = 1.0) -> None:
    """The three axes outside the ball, with their names; behind the ball where they point away."""
    for name, end in AXES.items():
        tip, start = view.project(end) * 1.2 * radius, view.project(end) * radius
        behind = start[2] < 0
        hidden = behind and np.hypot(*tip[:2]) < radius
        ax.plot([start[0], tip[0]], [start[1], tip[1]], color=INK, lw=0.8,
                alpha=0.25 if hidden else 0.8, zorder=0.5 if behind else 6)
        if not hidden:
            x, y = tip[:2] + 0.09 * radius * tip[:2] / max(np.hypot(*tip[:2]), 1e-9 * radius)
            ax.text(x, y, name, ha="center", va="center", fontsize=8.5, color=INK, zorder=7,
                    path_effects=[withStroke(linewidth=2.2, foreground="white", alpha=0.8)])


def lines(ax, pieces, color, width, alpha=1.0, zorder=3.0) -> None:
    """Projected pieces (m, 2) as one broken line, so that laps over each other do not darken."""
    if pieces:
        gap = np.full((1, 2), np.nan)
        x, y = np.concatenate([part for piece in pieces for part in (piece, gap)]).T
        ax.plot(x, y, color=color, lw=width, alpha=alpha, zorder=zorder,
                solid_capstyle="round", solid_joinstyle="round")


def curve(ax, w, view: View = View(), color=BLUE, width: float = 1.1, casimir=None,
          reach=np.inf) -> None:
    """A trajectory w (k, 3), solid where it is seen and faint behind the surface; nothing of a site that is absent."""
    front, back = split(present(w), view, casimir, reach)
    lines(ax, back, color, 0.8 * width, alpha=0.22, zorder=2.0)
    lines(ax, front, color, width, zorder=3.0)


def points(ax, w, view: View = View(), color=BLUE, size: float = 2.0, marker="o",
           rasterized: bool = False, zorder: float = 3.0, edge="none",
           label=None) -> None:
    """Points w (k, 3), solid where they are seen and faint behind; none where w = 0, of sites that are absent."""
    w = present(np.reshape(w, (-1, 3)))
    flat, seen = view.project(w), visible(w, view)
    for mask, shade, rim, level in ((~seen, misty(color), misty(edge), zorder - 1),
                                    (seen, color, edge, zorder)):
        ax.scatter(flat[mask, 0], flat[mask, 1], s=size, c=[shade], marker=marker, zorder=level,
                   edgecolors=rim, linewidths=0 if edge == "none" else 0.8,
                   rasterized=rasterized, label=label if level == zorder else None)


def present(w):
    """Those of the vectors (k, 3) that are not 0."""
    w = np.asarray(w, float)
    return w[np.any(w != 0, axis=1)]


def misty(color):
    """`color` mixed with the ball's grey: opaque, so that many hidden points stay faint."""
    if isinstance(color, str) and color == "none":
        return color
    return tuple(0.20 * np.array(to_rgb(color)) + 0.80 * np.array(MIST))


def equilibria(ax, marks, view: View = View()) -> None:
    """Mark equilibria: pairs (w (3,), kind), kind 'stable', 'unstable' or 'singular'.

    Disc: stable. Open diamond: unstable. Triangle: degenerate. Cross: the energy is singular.
    """
    looks = {"stable": ("o", 26, INK, "white"), "unstable": ("D", 24, "white", INK),
             "degenerate": ("^", 30, "white", INK),
             "singular": ("X", 40, SINGULAR, "white")}
    for kind, (marker, size, face, edge) in looks.items():
        chosen = [w for w, k in marks if k == kind]
        if chosen:
            points(ax, chosen, view, face, size, marker, edge=edge, zorder=5, label=kind)
