"""A film of a result: .gif, or .mp4 where ffmpeg is found; no window is opened."""
from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, writers

from ...errors import MissingTool, OutputError
from . import cells, sphere
from .chain import thinned
from .colours import of_sites
from .style import footnote, new_figure, styled
from .text import of_all, shown
from .units import NONE, at_time
from .view import View

FORMATS = {".gif": "pillow", ".mp4": "ffmpeg"}
FRAMES, RATE, DOTS = 240, 24, 110       # most frames, frames a second, dots an inch
POINTS = 4000       # most sites on a sphere


def is_film(path) -> bool:
    return path is not None and Path(path).suffix.lower() in FORMATS


def writer_for(path: Path):
    """What writes this ending. Raises MissingTool for .mp4 without ffmpeg."""
    name = FORMATS[path.suffix.lower()]
    if not writers.is_available(name):
        raise MissingTool(f"an {path.suffix} needs the program {name}, which was not found: install it, or write {path.stem}.gif")
    return writers[name](fps=RATE)


@styled
def write_film(figure, draw_frame, count: int, path: Path) -> Path:
    """Frame by frame: draw_frame(k) changes the figure. Raises OutputError where it cannot be written."""
    writer = writer_for(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        FuncAnimation(figure, draw_frame, frames=count, blit=False, cache_frame_data=False).save(path, writer=writer, dpi=DOTS)
    except OSError as e:
        raise OutputError(f"cannot write '{path}': {e.strerror or e}") from None
    return path


def lattice_film(t, w, stage, title: str = "", note: str = "", units=NONE):
    """(figure, draw_frame, frames) of w (k, n, 3) at its places."""
    keep = thinned(len(t), FRAMES)
    figure = new_figure(6.4, 5.6)
    ax = figure.subplots()
    drawn = cells.one_time(ax, cells.directions(w[0], stage), stage)
    cells.named(ax, stage, units["length"])
    cells.bar(figure, drawn[0], [ax], stage)
    figure.suptitle(shown(title), x=0.01, ha="left", fontsize=10.5)
    footnote(figure, stage.seen.said, note, cells.arrows_of(stage), of_all(len(keep), len(t), "outputs"))

    def draw_frame(k):
        cells.renewed(drawn, cells.directions(w[keep[k]], stage), stage)
        ax.set_title(at_time(t[keep[k]], units["time"]), fontsize=9)
    return figure, draw_frame, len(keep)


def sphere_film(t, states: dict, title: str = "", note: str = "", units=NONE):
    """(figure, draw_frame, frames) of sites on spheres, each with the path that it has just come."""
    keep, view = thinned(len(t), FRAMES), View()
    figure = new_figure(5.6, 5.8)
    ax = figure.subplots()
    sphere.ball(ax, view, max(float(np.linalg.norm(w[0], axis=1).max()) for w in states.values()))
    sites = [(w[:, i], color) for (_, w), colors in zip(states.items(), of_sites({n: w.shape[1] for n, w in states.items()}).values())
             for i, color in enumerate(colors) if w[0, i].any()]      # the others are absent
    every = len(sites)
    sites = [sites[i] for i in thinned(every, POINTS)]
    trail = len(keep) // 12 if len(sites) <= 60 else 0
    lines = [ax.plot([], [], color=color, lw=1.2, alpha=0.7, zorder=3)[0] for _, color in sites] if trail else []
    dots = ax.scatter(np.zeros(len(sites)), np.zeros(len(sites)), c=[color for _, color in sites], s=26 if len(sites) <= 60 else 4, zorder=4, lw=0)
    figure.suptitle(shown(title), x=0.01, ha="left", fontsize=10.5)
    footnote(figure, note, of_all(len(sites), every), of_all(len(keep), len(t), "outputs"), "faint: on the far side")

    def draw_frame(k):
        here = view.project(np.array([w[keep[k]] for w, _ in sites]))
        dots.set_offsets(here[:, :2])
        dots.set_alpha(np.where(here[:, 2] >= 0, 1.0, 0.2))
        for line, (w, _) in zip(lines, sites):
            path = view.project(w[keep[max(0, k - trail)]:keep[k] + 1])
            line.set_data(*np.where(path[:, 2:] >= 0, path[:, :2], np.nan).T)
        ax.set_title(at_time(t[keep[k]], units["time"]), fontsize=9)
    return figure, draw_frame, len(keep)
