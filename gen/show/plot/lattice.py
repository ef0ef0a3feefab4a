"""A lattice from above at a few times: w_z as colour, w_x and w_y as arrows."""
from __future__ import annotations

import numpy as np

from .chain import CELLS, thinned
from .style import footnote, new_figure, styled
from .text import of_all, shown

ARROWS = 32         # most rows and columns of arrows
TIMES = 6           # most outputs


@styled
def lattice_images(t, w, title: str = "", note: str = ""):
    """Unit vectors along w (k, rows, columns, 3) at up to six outputs, evenly chosen; `note` stands below.

    Rows follow the second direction of the lattice, upwards. Of many cells some are left out.
    """
    keep, rows, columns = thinned(len(t), TIMES), thinned(w.shape[1], CELLS), thinned(w.shape[2], CELLS)
    part = np.asarray(w, float)[keep][:, rows][:, :, columns]
    unit = part / np.maximum(np.linalg.norm(part, axis=-1, keepdims=True), 1e-300)
    across = min(3, len(keep))
    down = -(-len(keep) // across)
    figure = new_figure(3.0 * across + 0.8, 3.0 * down + 0.4)
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).ravel()
    for ax, time, state in zip(axes, np.asarray(t)[keep], unit):
        image = one_image(ax, state, columns, rows)
        ax.set_title(f"$t$ = {time:g} (model units)", fontsize=9)
    for ax in axes[len(keep):]:
        ax.remove()
    for ax in axes[:len(keep)]:
        ax.label_outer()
    figure.colorbar(image, ax=list(axes[:len(keep)]), label=r"$w_z/|w|$ (dimensionless)", pad=0.02)
    figure.suptitle(shown(title) or "Evolution of the lattice", x=0.01, ha="left", fontsize=10.5)
    footnote(figure, note, of_all(len(rows) * len(columns), w.shape[1] * w.shape[2]), of_all(len(keep), len(t), "outputs"))
    return figure


def one_image(ax, unit, columns, rows):
    """Unit vectors (rows, columns, 3) of the cells with these numbers."""
    image = ax.imshow(unit[..., 2], origin="lower", cmap="coolwarm", vmin=-1, vmax=1, aspect="equal",
                      extent=[columns[0] - 0.5, columns[-1] + 0.5, rows[0] - 0.5, rows[-1] + 0.5])
    down, across = thinned(len(rows), ARROWS), thinned(len(columns), ARROWS)
    some = unit[down][:, across]
    ax.quiver(columns[across], rows[down], some[..., 0], some[..., 1], pivot="mid", angles="xy", color="black", width=0.004)
    ax.set(xlabel="cell of direction 0 (number)", ylabel="cell of direction 1 (number)")
    ax.grid(False)
    return image
