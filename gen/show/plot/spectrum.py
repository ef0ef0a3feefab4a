"""S(q, omega) as a heat map, along a path of wave vectors."""
from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm

from ...errors import UsageError
from .style import footnote, new_figure, save, styled
from .text import shown

DEPTH = 1e-6        # of the brightest wave: what is below has the darkest colour
STATIC = 2          # frequencies on either side of 0 that the line of what does not move takes, with the window hann
NO_PATH = "a picture needs a path of wave vectors, such as --q \"0,0 1/2,0 1/2,1/2\""


def draw_spectrum(spectrum, path) -> Path:
    """Draw a Spectrum into a .png, .svg or .pdf; returns its path. Raises UsageError for waves that are no path, and for another ending."""
    return save(spectrum_figure(spectrum), path)


@styled
def spectrum_figure(spectrum):
    """S(q, omega) along a path of waves. Raises UsageError for waves that are none."""
    meta = spectrum.meta
    unit = shown((meta.get("units") or {}).get("time", ""))
    if meta["waves"] == "all" and spectrum.q.shape[1] > 1:
        raise UsageError(NO_PATH)
    x = positions(spectrum.q if spectrum.wave_vectors is None else spectrum.wave_vectors)
    figure = new_figure(8, 5)
    ax = figure.subplots()
    top = brightest(spectrum)
    image = ax.pcolormesh(edges(x), edges(spectrum.omega), np.maximum(spectrum.mean, DEPTH * top).T, norm=LogNorm(DEPTH * top, top), rasterized=True)
    figure.colorbar(image, ax=ax, label="S(q, omega), mean of the components", extend="both")
    at = turns(spectrum.q)
    ax.set_xticks(x[at], [spectrum.names[k] or label(spectrum.q[k]) for k in at])
    ax.set(xlabel="q, in units of the reciprocal lattice", ylabel=f"omega (rad/{unit})" if unit else "omega")
    ax.grid(False)
    ax.set_title(shown(f"{meta['spec']} {meta['run']}: waves of {meta['family']}"))
    footnote(figure, f"window: {meta['window']}", f"{meta['parts']} parts" * (meta["parts"] > 1), f"h = {meta['h']:.6g}, output every {meta['every']}")
    return figure


def brightest(spectrum) -> float:
    """The largest value of what moves; of all, where nothing does."""
    width = spectrum.omega[1] - spectrum.omega[0]
    moving = np.abs(spectrum.omega) > (STATIC + 0.5) * width
    return max(spectrum.mean[:, moving].max(initial=0.0) or spectrum.mean.max(), np.finfo(float).tiny / DEPTH)


def positions(q) -> np.ndarray:
    """How far along the path each wave is. Raises UsageError for one wave, or one that is there twice on end."""
    steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
    if len(q) < 2 or not np.all(steps > 0):
        raise UsageError(NO_PATH)
    return np.concatenate([[0.0], np.cumsum(steps)])


def turns(q) -> list[int]:
    """The waves where the path begins, turns and ends."""
    steps = np.diff(q, axis=0)
    bent = np.linalg.norm(np.diff(steps, axis=0), axis=1) > 1e-9
    return [0, *(np.flatnonzero(bent) + 1).tolist(), len(q) - 1]


def edges(centres) -> np.ndarray:
    """Of cells around rising centres."""
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def label(q) -> str:
    """`1/2, 0`."""
    return ", ".join(str(Fraction(float(x)).limit_denominator(10 ** 6)) for x in q)
