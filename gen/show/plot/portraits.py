"""Phase portraits, compared trajectories, vortices and sections on the sphere."""
from __future__ import annotations

import numpy as np
from matplotlib.legend_handler import HandlerTuple

from . import sphere
from . import colours
from .chain import thinned
from .colours import BLUE, CHAOTIC, FAINT, INK
from .style import footnote, method_style, new_figure, styled
from .text import shown
from .view import View

POINTS = 100_000        # most points of all paths in one picture
STARTS = 24             # most paths whose starts are marked


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

    trajectories: list of (method, w (k, 3)); later ones are drawn on top.
    """
    figure = new_figure(4.6, 4.8)
    ax = figure.subplots()
    sphere.ball(ax, view, label=shown(title))
    for i, (method, w) in enumerate(trajectories):
        look = method_style(method)
        sphere.points(ax, w, view, look["color"], 1.6, rasterized=True, zorder=3 + i)
        ax.plot([], [], "o", color=look["color"], ms=4, label=look["label"])
    ax.legend(loc="lower center", ncols=2, bbox_to_anchor=(0.5, -0.06))
    return figure


@styled
def sections(panels, view: View = View(), size: float = 0.6):
    """Poincare sections, a sphere for each panel (title, regular, chaotic).

    regular: list of orbits (k, 3), one shade each; chaotic: list of orbits, all of one colour.
    """
    figure = new_figure(4.5 * len(panels), 4.7)
    for ax, (title, regular, chaotic) in zip(figure.subplots(1, len(panels), squeeze=False)[0],
                                             panels):
        sphere.ball(ax, view, label=shown(title))
        shades = colours.regular(len(regular))
        for w, shade in zip(regular, shades):
            sphere.points(ax, w, view, shade, size, rasterized=True)
        for w in chaotic:
            sphere.points(ax, w, view, CHAOTIC, size, rasterized=True, zorder=3.5)
        keys = {"regular orbits": shades[:3],
                "chaotic orbits": [CHAOTIC] if chaotic else []}
        legend(ax, {name: shades for name, shades in keys.items() if shades})
    return figure


@styled
def layered(layers, backdrop=(), view: View = View(), **_):
    """A sphere that moves on the page, for paper: all dots of its layers, trails of its sites from their first to their last state.

    layers: {"name", "kind": "dots" or "trails", "colors", "w" (frames, orbits, 3)}; backdrop: curves (k, 3) behind them.
    """
    figure = new_figure(4.0, 4.0)
    ax = figure.subplots()
    sphere.ball(ax, view, axes=False)
    for w in backdrop:
        sphere.curve(ax, w, view, FAINT, 0.7)
    for layer in layers:
        for w, color in zip(np.moveaxis(layer["w"], 1, 0), layer["colors"]):
            if layer["kind"] == "dots":
                sphere.points(ax, w, view, color, 0.8, rasterized=True)
            else:
                trace_all(ax, [(w, color)], view)
    return figure


def legend(ax, keys: dict, marker: str = "o") -> None:
    """A legend below `ax`: name -> the colours, all shown, of what has that name."""
    rows = [tuple(ax.plot([], [], marker, color=color, ms=4)[0] for color in shades)
            for shades in keys.values()]
    ax.legend(rows, [shown(name) for name in keys], loc="lower center", ncols=4,
              bbox_to_anchor=(0.5, -0.08), handler_map={tuple: HandlerTuple(None, 0.6)})


def site_keys(colors: dict) -> dict:
    """Entries of `legend` for families of sites: a name each, or five shades of the family."""
    keys = {}
    for name, shades in colors.items():
        if len(shades) > 8:
            keys[f"{name}[0] to {name}[{len(shades) - 1}]"] = shades[::(len(shades) - 1) // 4][:5]
        else:
            keys.update({site_name(name, i, len(shades)): [c] for i, c in enumerate(shades)})
    return keys


def site_name(family: str, number: int, count: int) -> str:
    """w[3], or w where the family has one site."""
    return family if count == 1 else f"{family}[{number}]"


@styled
def several(states, title: str = "", view: View = View(), points: bool = False):
    """The paths of all sites on one sphere, of states {family: (k, count, 3)}; ends are marked, and starts where they are few.

    Bodies of different radius are drawn on their own sphere, seen through the larger ones.
    points: draw the outputs alone, as in a Poincare section.
    """
    figure = new_figure(4.6, 4.8)
    ax = figure.subplots()
    radii = sorted({float(f"{r:.6g}") for w in states.values() for r in np.linalg.norm(w[0], axis=1) if r > 0})
    sphere.ball(ax, view, radii[-1], label=shown(title))
    for r in radii[:-1]:
        t = np.linspace(0, 2 * np.pi, 121)
        ax.plot(r * np.cos(t), r * np.sin(t), color=FAINT, lw=0.7, ls=":", zorder=1.5)
    colors = colours.of_sites({name: w.shape[1] for name, w in states.items()})
    every = [(w[:, i], c) for name, w in states.items() for i, c in enumerate(colors[name])]
    few = len(every) <= STARTS and not points
    if points:
        scatter_all(ax, every, view)
    else:
        trace_all(ax, every, view, few)
    legend(ax, site_keys(colors), "o" if points else "-o")
    footnote(figure, "rings: start" * few, "discs: end" * (not points), "pale: behind the sphere")
    return figure


def trace_all(ax, paths, view: View, starts: bool = False) -> None:
    """Paths [(w (k, 3), colour)] with a disc at the end of each, and a ring at its start."""
    most = max(2, POINTS // len(paths))
    for w, color in paths:
        sphere.curve(ax, w[thinned(len(w), most)], view, color, 0.9)
        if starts:
            sphere.points(ax, w[:1], view, "white", 22, edge=color, zorder=5)
        sphere.points(ax, w[-1:], view, color, 22, edge="white", zorder=5)


def scatter_all(ax, orbits, view: View) -> None:
    """The points of orbits [(w (k, 3), colour)]."""
    size = 0.6 if sum(len(w) for w, _ in orbits) > 5000 else 4.0
    for w, color in orbits:
        sphere.points(ax, w, view, color, size, rasterized=True)


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
    for pair in ((0, 1), (2, 3)):
        draw_pair(ax, w[list(pair)], view)
    for i, (point, color) in enumerate(zip(w, colours.of_sites({"w": 4})["w"])):
        sphere.points(ax, point[None], view, color, 40, edge="white", zorder=6)
        x, y, _ = 1.12 * view.project(point)
        ax.text(x, y, f"$x_{i + 1}$", ha="center", va="center", fontsize=11, zorder=7)
    draw_angle(ax, w, view)
    ax.set_title("Invariant manifold of four equal vortices")
    ax.set_xlim(-1.2, 1.2)
    ax.set_ylim(-1.2, 1.2)
    return figure


def draw_pair(ax, pair, view: View) -> None:
    """The arc of 2 theta over the pole between two points, and their dashed radii."""
    a, b = pair
    pole = np.array([0, 0, np.sign(a[2])])
    s = np.linspace(0, 1, 40)[:, None]
    for end in (a, b):
        arc = end * (1 - s) + pole * s
        sphere.curve(ax, arc / np.linalg.norm(arc, axis=1, keepdims=True), view, INK, 1.6)
        line = view.project(np.array([[0, 0, 0], end]))
        ax.plot(line[:, 0], line[:, 1], color=INK, lw=0.9, ls=(0, (4, 3)), zorder=2.5)
    x, y, _ = view.project(0.84 * pole)
    ax.text(x - 0.05, y, r"$2\theta$", color=INK, ha="right", va="center", fontsize=11, zorder=7)


def draw_angle(ax, w, view: View) -> None:
    """The angle of 2 phi between the two half-planes, drawn on the equator."""
    turn = np.arctan2(w[0, 1], w[0, 0])
    t = np.linspace(-turn, turn, 60)
    arc = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    sphere.curve(ax, arc, view, INK, 1.6)
    for end in (w[0], w[2]):
        s = np.linspace(0, 1, 30)[:, None]
        flat = np.array([end[0], end[1], 0]) / np.hypot(end[0], end[1])
        drop = end * (1 - s) + flat * s
        sphere.curve(ax, drop / np.linalg.norm(drop, axis=1, keepdims=True), view, INK, 0.7)
    x, y, _ = view.project(arc[46])
    ax.text(x, y - 0.09, r"$2\phi$", color=INK, ha="center", va="center", fontsize=11, zorder=7)
