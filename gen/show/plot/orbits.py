"""The coadjoint orbits of so(3)* = R^3: nested spheres, cut open, with trajectories on them."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .colours import INK, ordered
from .sphere import lines
from .style import new_figure, styled
from .surfaces import faces, paint
from .view import View, parted


@dataclass(frozen=True)
class Nest:
    """Concentric spheres of increasing `radii`; all but the first lack the part above the
    equator between the two azimuths `opening` (degrees)."""
    radii: tuple
    opening: tuple

    def removed(self, w) -> np.ndarray:
        """(...,) truth: do the points lie in the direction that is cut away?"""
        turn = np.degrees(np.arctan2(w[..., 1], w[..., 0])) - self.opening[0]
        return (w[..., 2] > 0) & (np.mod(turn, 360) < self.opening[1] - self.opening[0])

    def seen(self, w, view: View) -> np.ndarray:
        """(k,) truth: no sphere lies between the points w (k, 3) and the viewer.

        The ray w + s d meets the sphere of radius r at s = -w.d +- sqrt((w.d)^2 + r^2 - w.w).
        """
        d, free = view.matrix[2], np.ones(len(w), bool)
        along, square = w @ d, np.sum(w * w, axis=1)
        for i, r in enumerate(self.radii):
            root = np.sqrt(np.maximum(along**2 + r * r - square, 0))
            touch = along**2 + r * r - square >= 0
            for s in (-along - root, -along + root):
                meeting = w + s[:, None] * d
                free &= ~(touch & (s > 1e-6) & ~((i > 0) & self.removed(meeting)))
        return free

    def sheets(self, i: int) -> list[np.ndarray]:
        """The grids (m, n, 3) that make up sphere number i."""
        r, (a, b) = self.radii[i], np.radians(self.opening)
        whole = np.linspace(0, 2 * np.pi, 97)
        upper = whole if i == 0 else np.linspace(b, a + 2 * np.pi, 73)
        return [r * patch(np.linspace(0, np.pi / 2, 25), upper),
                r * patch(np.linspace(np.pi / 2, np.pi, 25), whole)]


def patch(polar, azimuth) -> np.ndarray:
    """(m, n, 3) points of the unit sphere at polar angles (m,) and azimuths (n,)."""
    p, a = polar[:, None], azimuth[None, :]
    return np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p) + 0 * a], axis=-1)


@styled
def coadjoint_orbits(curves, radii=None, view: View = View(35, 26), opening=(-25.0, 95.0)):
    """Nested spheres S^2_lambda with the trajectories `curves` (list of (k, 3)) on them.

    radii: the spheres to draw, by default those of the curves' first points.
    opening: azimuths (degrees) between which the outer spheres' upper halves are cut away.
    """
    found = sorted({round(float(np.linalg.norm(c[0])), 9) for c in curves})
    nest = Nest(tuple(sorted(radii) if radii is not None else found), opening)
    figure = new_figure(4.8, 4.8)
    ax = figure.subplots()
    ax.set_aspect("equal")
    ax.axis("off")
    paint_nest(ax, nest, view)
    for w in curves:
        one_curve(ax, nest, np.asarray(w, float), view)
    radial_axis(ax, nest, view)
    ax.autoscale_view()
    return figure


def paint_nest(ax, nest: Nest, view: View) -> None:
    """All spheres of the nest in one painter's order, far faces first."""
    parts = [grid for i in range(len(nest.radii)) for grid in nest.sheets(i)]
    drawn = [faces(grid, grid, view, depth=True) for grid in parts]
    quads, tone, depth = (np.concatenate(x) for x in zip(*drawn))
    order = np.argsort(depth, kind="stable")
    paint(ax, quads[order], tone[order])


def one_curve(ax, nest: Nest, w, view: View) -> None:
    """A trajectory on its sphere, coloured by the sphere; faint where another covers it."""
    r = np.linalg.norm(w[0])
    color, = ordered([r / nest.radii[-1]])
    front, back = parted(view.project(w)[:, :2], nest.seen(w, view))
    lines(ax, back, color, 0.7, alpha=0.13, zorder=2)
    lines(ax, front, color, 1.2, zorder=3)


def radial_axis(ax, nest: Nest, view: View) -> None:
    """The axis of lambda = |w|, upwards out of the nest, with the radii that are drawn."""
    top = nest.radii[-1]
    foot, tip = (view.project([0, 0, z])[:2] for z in (nest.radii[0], 1.28 * top))
    ax.plot(*zip(foot, tip), color=INK, lw=0.9, zorder=4)
    ax.plot(*tip, marker="^", color=INK, ms=5, zorder=5)
    ax.text(tip[0] + 0.06 * top, tip[1], r"$\lambda=|w|$", va="center", color=INK)
    for r in nest.radii:
        x, y = view.project([0, 0, r])[:2]
        ax.plot([x], [y], marker="_", color=INK, ms=7, zorder=5)
        ax.text(x + 0.05 * top, y, f"{r:g}", va="center", fontsize=8, color=INK, zorder=5,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8})
