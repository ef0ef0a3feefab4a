"""A lattice from above at a few times: w_z as colour, w_x and w_y as arrows.

Cells of several sites are drawn as a schematic: the sites of a cell side by side, each over its part of the cell. `cells.py` draws sites where
they stand.
"""
from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from .chain import CELLS, directions as directions_of, thinned
from .colours import INK
from .style import footnote, panels, styled
from .text import of_all, shown
from .units import at_time, plain

ARROWS = 32         # most rows and columns of arrows
TIMES = 6           # most outputs
LONG = 4            # times as many cells one way as the other, beyond which they are drawn as no squares, and without arrows


@styled
def lattice_images(t, w, title: str = "", note: str = "", directions=(0, 1), told=plain, placed: bool = False, names=()):
    """Unit vectors along w (k, rows, columns, sites of a cell, 3) at up to six outputs, evenly chosen; `note` stands below.

    directions: of the lattice, along columns and along rows, which go upwards. Of many cells some are left out. told: the unit of a column;
    placed: can the sites be drawn where they stand? names: of those of a cell.
    """
    keep, rows, columns = thinned(len(t), TIMES), thinned(w.shape[1], CELLS), thinned(w.shape[2], CELLS)
    unit = directions_of(np.asarray(w, float)[keep][:, rows][:, :, columns])
    figure, axes, across = panels(len(keep), len(rows) / len(columns) if squares(unit[0]) else 1.0)
    for k, (ax, time, state) in enumerate(zip(axes, np.asarray(t)[keep], unit)):
        image = one_image(ax, state, columns, rows)
        ax.set_title(at_time(time, told("t")), fontsize=9)
        label(ax, directions, below=k + across < len(keep), beside=k % across > 0)
    figure.colorbar(image, ax=list(axes), label=r"$w_z/|w|$", pad=0.02)
    figure.suptitle(shown(title) or "Evolution of the lattice", x=0.01, ha="left", fontsize=10.5)
    footnote(figure, schematic(w.shape[3], placed, names), note, of_all(len(rows) * len(columns), w.shape[1] * w.shape[2], "cells"), of_all(len(keep), len(t), "outputs"))
    return figure


def schematic(sites: int, placed: bool, names=()) -> str:
    """What to say of a picture of cells of several sites."""
    rest = "; --kind places draws them where they stand" if placed else ", for this spec does not say where they stand"
    which = f"{sites} sites {', '.join(names)}" if names else f"{sites} sites"
    return f"schematic: the {which} of a cell side by side{rest}" if sites > 1 else ""


def squares(unit) -> bool:
    """Are cells (rows, columns, ..) drawn as squares?"""
    return max(unit.shape[:2]) <= LONG * min(unit.shape[:2])


def one_image(ax, unit, columns, rows):
    """Unit vectors (rows, columns, sites of a cell, 3) of the cells with these numbers."""
    even, sites = squares(unit), unit.shape[2]
    image = ax.imshow(unit[..., 2].reshape(len(rows), -1), origin="lower", cmap="coolwarm", vmin=-1, vmax=1, aspect="equal" if even else "auto",
                      extent=[columns[0] - 0.5, columns[-1] + 0.5, rows[0] - 0.5, rows[-1] + 0.5])
    if even:
        arrows(ax, unit, columns, rows)
    if sites > 1 and len(columns) <= ARROWS:
        for edge in columns[:-1] + 0.5:
            ax.axvline(edge, color=INK, lw=1.2)
    ax.grid(False)
    return image


def arrows(ax, unit, columns, rows) -> None:
    """Of some cells, at each of their sites; one that lies in the plane is as long as nine tenths of the space between two."""
    sites = unit.shape[2]
    down, along = thinned(len(rows), ARROWS), thinned(len(columns), max(1, ARROWS // sites))
    space = min(len(rows) / len(down), len(columns) / len(along) / sites)
    some = unit[down][:, along].reshape(len(down), -1, 3)
    places = (columns[along][:, None] + (np.arange(sites) + 0.5) / sites - 0.5).ravel()
    ax.quiver(places, rows[down], some[..., 0], some[..., 1], pivot="mid", angles="xy", scale_units="xy", scale=1 / (0.9 * space), color="black", width=0.004)


def label(ax, directions, below: bool, beside: bool) -> None:
    """Names of the axes, where no panel stands below or to the left."""
    ax.tick_params(labelbottom=not below, labelleft=not beside)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator("auto", integer=True))
    ax.set(xlabel="" if below else f"cell of direction {directions[0]}", ylabel="" if beside else f"cell of direction {directions[1]}")
