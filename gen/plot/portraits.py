"""Phase portraits, compared trajectories, vortices and sections on the sphere."""
from __future__ import annotations

import numpy as np

from . import sphere
from .chain import thinned
from .style import BLUE, FAINT, GREEN, INK, PALETTE, VERMILION, new_figure, styled
from .text import shown
from .view import View

POINTS = 100_000        # most points of all paths in one picture


@styled
def phase_portrait(curves, marks=(), title: str = "", view: View = View(), colors=None):
    """Many trajectories (each (k, 3)) on one sphere, its equilibria marked.

    marks: pairs (w (3,), 'stable' | 'unstable' | 'singular').
    """
    figure = new_figure(4.6, 4.8)
    ax = figure.subplots()
    portrait(ax, curves, marks, title, view, colors)
    if marks:
        ax.legend(loc="lower center", ncols=3, bbox_to_anchor=(0.5, -0.06))
    return figure


def portrait(ax, curves, marks=(), title="", view=View(), colors=None) -> None:
    """The portrait on given axes; one colour unless `colors` names one for each curve."""
    radius = largest_radius(curves)
    sphere.ball(ax, view, radius, label=shown(title))
    for i, w in enumerate(curves):
        sphere.curve(ax, w, view, colors[i] if colors else BLUE, 0.9)
    sphere.equilibria(ax, marks, view)


def largest_radius(curves) -> float:
    """Radius of the largest sphere that the curves' first points lie on (1 without curves)."""
    return max((float(np.linalg.norm(c[0])) for c in curves if len(c)), default=1.0)


@styled
def compared(trajectories, title: str = "", view: View = View(-62, -18)):
    """Computed points of several methods from one start, on one sphere.

    trajectories: list of (label, colour, w (k, 3)); later ones are drawn on top.
    """
    figure = new_figure(4.6, 4.8)
    ax = figure.subplots()
    sphere.ball(ax, view, label=shown(title))
    for i, (label, color, w) in enumerate(trajectories):
        sphere.points(ax, w, view, color, 1.6, rasterized=True, zorder=3 + i)
        ax.plot([], [], "o", color=color, ms=4, label=shown(label))
    ax.legend(loc="lower center", ncols=2, bbox_to_anchor=(0.5, -0.06))
    return figure


@styled
def sections(panels, view: View = View(), size: float = 0.6, radius: float = 1.0, named: bool = True):
    """Poincare sections, a sphere for each panel (title, regular, chaotic).

    regular: list of orbits (k, 3), one shade each; chaotic: list of orbits, all vermilion; named: says so.
    """
    figure = new_figure(4.5 * len(panels), 4.7)
    for ax, (title, regular, chaotic) in zip(figure.subplots(1, len(panels), squeeze=False)[0],
                                             panels):
        sphere.ball(ax, view, radius, label=shown(title))
        shades = shades_of(len(regular))
        for w, shade in zip(regular, shades):
            sphere.points(ax, w, view, shade, size, rasterized=True)
        for w in chaotic:
            sphere.points(ax, w, view, VERMILION, size, rasterized=True, zorder=3.5)
        if regular and named:
            ax.plot([], [], "o", color=shades_of(1)[0], ms=4, label="regular orbits")
        if chaotic and named:
            ax.plot([], [], "o", color=VERMILION, ms=4, label="chaotic orbits")
        if named:
            ax.legend(loc="lower center", ncols=2, bbox_to_anchor=(0.5, -0.06))
    return figure


def shades_of(n: int) -> list:
    """n colours between dark blue and sea green, so that neighbouring orbits can be told apart."""
    ramp = np.linspace(0, 1, max(n, 1))[:, None]
    dark, light = np.array([0.0, 0.27, 0.55]), np.array([0.0, 0.62, 0.55])
    mixed = dark * (1 - ramp) + light * ramp
    return [tuple(c) for c in mixed[(np.arange(max(n, 1)) * 7) % max(n, 1)]]


@styled
def several(paths, title: str = "", view: View = View(), radii=None):
    """The paths of several particles on one sphere: list of (label, w (k, 3)); ends are marked.

    Bodies of different radius are drawn on their own sphere, seen through the larger ones.
    """
    figure = new_figure(4.6, 4.8)
    ax = figure.subplots()
    radii = radii or sorted({round(float(np.linalg.norm(w[0])), 6) for _, w in paths})
    sphere.ball(ax, view, radii[-1], label=shown(title))
    for r in radii[:-1]:
        t = np.linspace(0, 2 * np.pi, 121)
        ax.plot(r * np.cos(t), r * np.sin(t), color=FAINT, lw=0.7, ls=":", zorder=1.5)
    most = max(2, POINTS // len(paths))
    for i, (label, w) in enumerate(paths):
        color = PALETTE[i % len(PALETTE)]
        sphere.curve(ax, w[thinned(len(w), most)], view, color, 0.9)
        sphere.points(ax, w[-1:], view, color, 22, edge="white", zorder=5)
        if len(paths) <= 8:
            ax.plot([], [], "-", color=color, label=shown(label))
    if len(paths) <= 8:
        ax.legend(loc="lower center", ncols=4, bbox_to_anchor=(0.5, -0.08))
    return figure


def on_manifold(theta, phi) -> np.ndarray:
    """The four vortices C(theta, phi) (4, 3) of the invariant manifold.

    c(theta, phi), c(theta, phi+pi), c(pi-theta, -phi), c(pi-theta, pi-phi) with
    c = (cos phi sin theta, sin phi sin theta, cos theta): McLachlan, Modin, Verdier,
    A minimal-variable symplectic integrator on spheres, section 4.4.
    """
    c = lambda a, b: [np.cos(b) * np.sin(a), np.sin(b) * np.sin(a), np.cos(a)]
    return np.array([c(theta, phi), c(theta, phi + np.pi),
                     c(np.pi - theta, -phi), c(np.pi - theta, np.pi - phi)])


@styled
def manifold_illustration(theta: float = 0.75, phi: float = 0.95, view: View = View(12, 13)):
    """The four points C(theta, phi): two chords, half-opened by theta, turned by phi apart."""
    w = on_manifold(theta, phi)
    figure = new_figure(4.6, 4.8)
    ax = figure.subplots()
    sphere.ball(ax, view, axes=False)
    for pair, color in (((0, 1), BLUE), ((2, 3), GREEN)):
        draw_pair(ax, w[list(pair)], view, color)
    for i, point in enumerate(w):
        sphere.points(ax, point[None], view, BLUE if i < 2 else GREEN, 40, edge="white", zorder=6)
        x, y, _ = 1.12 * view.project(point)
        ax.text(x, y, f"$x_{i + 1}$", ha="center", va="center", fontsize=11, zorder=7)
    draw_angle(ax, w, view)
    ax.set_title("Invariant manifold of four equal vortices")
    ax.set_xlim(-1.2, 1.2)
    ax.set_ylim(-1.2, 1.2)
    return figure


def draw_pair(ax, pair, view: View, color) -> None:
    """The arc of 2 theta over the pole between two points, and their dashed radii."""
    a, b = pair
    pole = np.array([0, 0, np.sign(a[2])])
    s = np.linspace(0, 1, 40)[:, None]
    for end in (a, b):
        arc = end * (1 - s) + pole * s
        sphere.curve(ax, arc / np.linalg.norm(arc, axis=1, keepdims=True), view, color, 1.6)
        line = view.project(np.array([[0, 0, 0], end]))
        ax.plot(line[:, 0], line[:, 1], color=color, lw=0.9, ls=(0, (4, 3)), zorder=2.5)
    x, y, _ = view.project(0.84 * pole)
    ax.text(x - 0.05, y, r"$2\theta$", color=color, ha="right", va="center", fontsize=11, zorder=7)


def draw_angle(ax, w, view: View) -> None:
    """The angle of 2 phi between the two half-planes, drawn on the equator."""
    turn = np.arctan2(w[0, 1], w[0, 0])
    t = np.linspace(-turn, turn, 60)
    arc = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    sphere.curve(ax, arc, view, VERMILION, 1.6)
    for end in (w[0], w[2]):
        s = np.linspace(0, 1, 30)[:, None]
        flat = np.array([end[0], end[1], 0]) / np.hypot(end[0], end[1])
        drop = end * (1 - s) + flat * s
        sphere.curve(ax, drop / np.linalg.norm(drop, axis=1, keepdims=True), view, INK, 0.7)
    x, y, _ = view.project(1.0 * arc[30])
    ax.text(x, y - 0.09, r"$2\phi$", color=VERMILION, ha="center", va="center", fontsize=11, zorder=7)
