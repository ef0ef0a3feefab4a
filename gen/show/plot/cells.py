"""A lattice with its sites at their places: a cell for each, coloured by the component towards the viewer, and arrows.

The cell of a site is its Voronoi cell: what lies nearer to it than to its neighbours. Those of one sublattice are alike, so each is found
once, about a site in the middle. Sites that belong to no lattice, and thousands, are markers.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from .chain import thinned
from .colours import DIVERGING, INK, SOFT
from .part import Seen, seen
from .style import footnote, panels
from .text import of_all, shown
from .units import NONE, at_time, with_unit

TIMES = 6           # most outputs
ARROWS = 32         # most rows and columns of arrows
CELLS = 40_000      # most cells; more are markers
DASHES = ["-", (0, (4, 3)), (0, (1, 3))]      # of bonds, by their lengths
BONDS = 1500        # most bonds drawn
SAME = 1e-9         # of their distances: closer sites stand at one place
FAR = 1.1           # how far a cell may reach where there is no neighbour, in distances of the nearest


@dataclass(frozen=True)
class Stage:
    """Where sites stand on the paper.

    flat: (m, 2) of the sites seen; space: between neighbours; outlines: of their cells, (m, corners, 2), or None; bonds: (m, 2) numbers
    among them; arrows: numbers of those that have one, long at most.
    """
    seen: Seen
    flat: np.ndarray
    space: float
    outlines: np.ndarray | None
    bonds: np.ndarray
    arrows: np.ndarray
    long: float


def stage_of(where, links, part: dict, sites: int = 1) -> Stage:
    """Of a lattice with `sites` in a cell (0: of no lattice)."""
    found = seen(where, part)
    flat = where[found.sites][:, list(found.axes)]
    space = spacing(flat)
    kinds = found.sites % sites if sites else None
    outlines = None if kinds is None or len(flat) > CELLS else cells(flat, kinds, space)
    arrows, long = sparse(flat, space)
    return Stage(found, flat, space, outlines, bonds_of(found.sites, links, where), arrows, long)


def spacing(flat) -> float:
    """The distance between neighbours in two or three dimensions; of sites that belong to no lattice the median."""
    some = flat[thinned(len(flat), 30)]
    far = np.linalg.norm(flat[None] - some[:, None], axis=2)
    nearest = np.where(far > SAME * far.max(), far, np.inf).min(axis=1)
    return float(np.median(nearest)) if np.isfinite(nearest).all() else 1.0


def bonds_of(sites, links, where):
    """(m, 2) numbers among `sites` of the bonds that join two of them; none where there are too many."""
    number = np.full(len(where), -1)
    number[sites] = np.arange(len(sites))
    both = number[links] if len(links) else np.zeros((0, 2), int)
    kept = both[(both >= 0).all(axis=1)]
    return kept if len(kept) <= BONDS else kept[:0]


def shells(stage: Stage):
    """0 of the shortest bonds, 1 of the next longer ones, 2 of all others."""
    long = np.linalg.norm(stage.flat[stage.bonds[:, 1]] - stage.flat[stage.bonds[:, 0]], axis=1)
    rising = np.sort(long)
    firsts = rising[np.flatnonzero(np.diff(rising, prepend=-np.inf) > 1e-3 * stage.space)]
    return np.minimum(np.searchsorted(firsts, long, side="right") - 1, len(DASHES) - 1)


# -- cells ---------------------------------------------------------------------------------

def cells(flat, kinds, space: float):
    """(m, corners, 2): the outline of every cell; of one kind all are alike."""
    shapes = {kind: outline(flat, kinds, kind, space) for kind in np.unique(kinds)}
    most = max(len(shape) for shape in shapes.values())
    padded = {kind: np.concatenate([shape, np.repeat(shape[-1:], most - len(shape), axis=0)]) for kind, shape in shapes.items()}
    return flat[:, None] + np.stack([padded[kind] for kind in kinds])


def outline(flat, kinds, kind, space: float):
    """The Voronoi cell about the site of this kind that is nearest to the middle, relative to it."""
    own = flat[kinds == kind]
    site = own[np.argmin(np.linalg.norm(own - flat.mean(axis=0), axis=1))]
    around = flat - site
    far = np.linalg.norm(around, axis=1)
    angle = 2 * np.pi * np.arange(32) / 32
    shape = FAR * space * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for neighbour in around[np.argsort(far)][:60]:
        if SAME * space < np.hypot(*neighbour) < 2.01 * FAR * space:
            shape = clipped(shape, neighbour)
    return shape


def clipped(shape, neighbour):
    """The part of a convex outline that lies nearer to 0 than to `neighbour`."""
    beyond = shape @ neighbour - neighbour @ neighbour / 2
    kept = []
    for p, q, a, b in zip(shape, np.roll(shape, -1, axis=0), beyond, np.roll(beyond, -1)):
        if a <= 0:
            kept.append(p)
        if (a < 0 < b) or (b < 0 < a):
            kept.append(p + (q - p) * a / (a - b))
    return np.array(kept)


def sparse(flat, space: float):
    """(numbers of the sites that have an arrow, its greatest length): all, or one of each square, the nearest to its middle."""
    extent = max(np.ptp(flat, axis=0).max(), space)
    wide = space * np.ceil(extent / ARROWS / space)
    if wide <= space:
        return np.arange(len(flat)), 0.9 * space
    at = (flat - flat.min(axis=0)) / wide
    square = np.floor(at)
    order = np.argsort(np.linalg.norm(at - square - 0.5, axis=1), kind="stable")
    _, first = np.unique(square[order], axis=0, return_index=True)
    return np.sort(order[first]), 0.9 * wide


# -- drawing -------------------------------------------------------------------------------

def place_images(t, w, stage: Stage, title: str = "", note: str = "", units=NONE):
    """Unit vectors along w (k, n, 3) at up to six outputs, evenly chosen; `note` stands below."""
    keep = thinned(len(t), TIMES)
    wide, high = np.ptp(stage.flat, axis=0) + 1.6 * stage.space
    figure, axes, across = panels(len(keep), high / wide)
    for k, (ax, pick) in enumerate(zip(axes, keep)):
        image, _ = one_time(ax, directions(w[pick], stage), stage)
        ax.set_title(at_time(t[pick], units["time"]), fontsize=9)
        named(ax, stage, units["length"], below=k + across < len(keep), beside=k % across > 0)
    bar(figure, image, axes, stage)
    figure.suptitle(shown(title) or "Evolution of the lattice", x=0.01, ha="left", fontsize=10.5)
    footnote(figure, stage.seen.said, note, arrows_of(stage), bonds_said(stage), of_all(len(keep), len(t), "outputs"))
    return figure


def directions(w, stage: Stage):
    """Unit vectors of the sites seen, (m, 3): across, up, towards the viewer; 0 where a site is absent."""
    some = np.asarray(w, float)[stage.seen.sites][:, [*stage.seen.axes, stage.seen.towards]]
    return some / np.maximum(np.linalg.norm(some, axis=1, keepdims=True), 1e-300)


def one_time(ax, u, stage: Stage):
    """(cells, arrows) of one output on `ax`; `renewed` shows another on them."""
    if stage.outlines is not None:
        cells_ = PolyCollection(stage.outlines, cmap=DIVERGING, clim=(-1, 1), lw=0.2, edgecolors="face")
        ax.add_collection(cells_)
    else:
        points = max(200 * stage.space / max(np.ptp(stage.flat, axis=0).max(), stage.space), 0.7)
        cells_ = ax.scatter(*stage.flat.T, c=np.zeros(len(u)), s=points ** 2, marker="s" if len(u) > CELLS else "o", cmap=DIVERGING,
                            vmin=-1, vmax=1, lw=0)
    if len(stage.bonds):
        ax.add_collection(LineCollection(stage.flat[stage.bonds], color=SOFT, lw=0.6, zorder=1.5, linestyles=[DASHES[k] for k in shells(stage)]))
    some = stage.arrows
    arrows = ax.quiver(*stage.flat[some].T, u[some, 0], u[some, 1], pivot="mid", angles="xy", scale_units="xy", scale=1 / stage.long,
                       color=INK, width=0.004, zorder=2)
    renewed((cells_, arrows), u, stage)
    low, high = stage.flat.min(axis=0) - 0.8 * stage.space, stage.flat.max(axis=0) + 0.8 * stage.space
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    ax.grid(False)
    return cells_, arrows


def renewed(drawn, u, stage: Stage) -> None:
    """Another output on what `one_time` has drawn; sites that are absent have no colour."""
    cells_, arrows = drawn
    cells_.set_array(np.where(np.any(u != 0, axis=1), u[:, 2], np.nan))
    arrows.set_UVC(u[stage.arrows, 0], u[stage.arrows, 1])


def named(ax, stage: Stage, unit: str, below: bool = False, beside: bool = False) -> None:
    """Names of the axes, where no panel stands below or to the left."""
    names = [with_unit("xyz"[d], shown(unit)) for d in stage.seen.axes]
    ax.tick_params(labelbottom=not below, labelleft=not beside)
    ax.set(xlabel="" if below else names[0], ylabel="" if beside else names[1])


def bar(figure, image, axes, stage: Stage) -> None:
    figure.colorbar(image, ax=list(axes), label=rf"$w_{'xyz'[stage.seen.towards]}/|w|$", pad=0.02)


def bonds_said(stage: Stage) -> str:
    """What to say of bonds of several lengths."""
    return ", ".join(["bonds: the shortest solid", "the next dashed", "longer ones dotted"][:1 + shells(stage).max(initial=0)]) if len(stage.bonds) and shells(stage).any() else ""


def arrows_of(stage: Stage) -> str:
    """What to say of arrows that are left out."""
    return of_all(len(stage.arrows), len(stage.flat), "arrows")
