"""S(q, omega) as a heat map, along a path of wave vectors; over it the lines of linear spin waves, and the resolution."""
from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm

from ...errors import UsageError
from .style import footnote, new_figure, save, styled
from .text import shown

DEPTH = 1e-6        # of the brightest wave: what is below has the darkest colour
SHOWN = 1e-4        # of the brightest: up to the highest frequency with so much the picture reaches
LINE = "#ff3b30"    # of linear spin waves: a red that no colour of the map is near
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
    omega, values = upper(spectrum)
    top = brightest(omega, values)
    image = ax.pcolormesh(edges(x), edges(omega), np.maximum(values, DEPTH * top).T, norm=LogNorm(DEPTH * top, top), rasterized=True)
    what = "mean of the components" if spectrum.neutron is None else "as neutrons see it"
    figure.colorbar(image, ax=ax, label=f"S(q, omega), {what}", extend="both")
    at = turns(spectrum.q)
    ax.set_xticks(x[at], [spectrum.names[k] or label(spectrum.q[k]) for k in at])
    ax.set(xlabel="q, in units of the reciprocal lattice", ylabel=f"omega (rad/{unit})" if unit else "omega",
           xlim=edges(x)[[0, -1]], ylim=(0, height(spectrum, omega, values, top)))
    ax.grid(False)
    ax.set_title(shown(f"{meta['spec']} {meta['run']}: waves of {meta['family']}"))
    draw_resolution(ax, spectrum, x)
    if spectrum.theory is not None:
        draw_lines(ax, spectrum.theory, x)
    footnote(figure, *notes(spectrum))
    return figure


def notes(spectrum):
    """What stands below the picture."""
    meta = spectrum.meta
    yield f"window: {meta['window']}"
    if meta["parts"] > 1:
        yield f"{meta['parts']} parts"
    yield f"h = {meta['h']:.6g}, output every {meta['every']}"
    yield "cross: resolution"
    if spectrum.theory is not None:
        hidden = bool(np.any(~spectrum.theory.seen & ~np.isnan(spectrum.theory.omega)))
        yield "lines: linear spin waves" + ", dotted where S has no weight" * hidden
        yield from spectrum.theory.meta["notes"]


def upper(spectrum) -> tuple:
    """(omega, values) from omega = 0 up: what is below is that of -q."""
    up = spectrum.omega > -spectrum.resolution / 2
    return spectrum.omega[up], (spectrum.mean if spectrum.neutron is None else spectrum.neutron)[:, up]


def height(spectrum, omega, values, top) -> float:
    """Where the picture ends: above all that has a colour, and above the lines."""
    bright = np.flatnonzero((values > SHOWN * top).any(axis=0))
    lines = [] if spectrum.theory is None else [1.1 * np.nanmax(spectrum.theory.omega)]
    return min(edges(omega)[-1], max([1.25 * omega[bright[-1]] if len(bright) else 0, *lines, 10 * spectrum.resolution]))


def draw_resolution(ax, spectrum, x) -> None:
    """A cross at the upper left: from one wave and one frequency to the next; with the window hann 1.5 times as high."""
    tall = spectrum.resolution * (1.5 if spectrum.meta["window"] == "hann" else 1)
    wide = np.median(np.diff(x))
    ax.errorbar([x[0] + wide], [0.94 * ax.get_ylim()[1]], xerr=wide / 2, yerr=tall / 2, color="white", capsize=3, lw=1.5)


def draw_lines(ax, theory, x) -> None:
    """The lines of linear spin waves; x: of the waves of the lattice."""
    at = np.interp(np.arange(len(theory.q)) / theory.meta["between"], np.arange(len(x)), x)
    for look, there in ((dict(ls="-", lw=1.2, alpha=0.9), theory.seen), (dict(ls=":", lw=0.8, alpha=0.5), ~theory.seen)):
        for line in np.where(there, theory.omega, np.nan).T:
            ax.plot(at, line, color=LINE, **look)


def brightest(omega, values) -> float:
    """The largest value of what moves; of all, where nothing does."""
    moving = omega > (STATIC + 0.5) * (omega[1] - omega[0])
    return max(values[:, moving].max(initial=0.0) or values.max(), np.finfo(float).tiny / DEPTH)


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
