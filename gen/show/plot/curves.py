"""Curves against time and against the step: energy, momenta, Casimirs, observables, errors."""
from __future__ import annotations

import numpy as np

from .colours import COMPONENTS, FAINT, INK
from .style import footnote, method_marker, method_style, new_figure, styled
from .text import shown
from .units import plain, with_unit

TIME = "time $t$ ({})"
POINTS = 3000        # most points of one curve in a picture


def envelope(t, y, bins: int = POINTS // 2):
    """Least and greatest y in each of `bins` stretches of time, in order of appearance.

    A curve of any length then keeps its extremes. t, y (k,) -> two arrays of at most 2*bins.
    """
    t, y = np.asarray(t, float), np.asarray(y, float)
    if len(t) <= 2 * bins:
        return t, y
    cuts = np.linspace(0, len(t), bins + 1).astype(int)
    keep = []
    for a, b in zip(cuts[:-1], cuts[1:]):
        part = np.where(np.isnan(y[a:b]), 0.0, y[a:b])
        keep += sorted({a + int(np.argmin(part)), a + int(np.argmax(part))})
    return t[keep], y[keep]


def smallest_scale(values) -> float:
    """Threshold below which a symlog axis is linear: the decade below half the smallest extent."""
    sizes = [np.abs(v)[np.isfinite(v)].max(initial=0) for v in values]
    extents = [size for size in sizes if size > 0]
    return max(1e-17, 10.0 ** np.floor(np.log10(0.5 * min(extents)))) if extents else 1e-16


@styled
def energy_errors(series, title: str = "", unit=plain, conserved: bool = True):
    """Energy errors H(t) - H(0) of several methods: linear above, symmetric logarithm below.

    series: list of (method, t (k,), error (k,)); unit: column -> its unit, as below; conserved: where the energy is not, these are no errors, and
    the logarithm, in which a curve bends where it crosses the linear part, is left out.
    """
    figure = new_figure(6.4, 4.8 if conserved else 3.0)
    axes = figure.subplots(1 + conserved, 1, sharex=True, squeeze=False)[:, 0]
    for ax in axes:
        draw_series(ax, series)
        ax.set_ylabel(f"$H - H_0$ ({unit('energy')})")
    if conserved:
        axes[1].set_ylabel(f"$H - H_0$ ({unit('energy')}),\nsymmetric logarithm")
        axes[1].set_yscale("symlog", linthresh=smallest_scale([e for _, _, e in series]))
        axes[1].axhline(0, color=FAINT, lw=0.6)
    axes[-1].set_xlabel(TIME.format(unit("t")))
    axes[0].legend(loc="best")
    axes[0].set_title(shown(title) or "Energy error")
    return figure


def draw_series(ax, series) -> None:
    """Curves (method, t, y) on `ax`."""
    for name, t, y in series:
        look = method_style(name)
        ax.plot(*envelope(t, y), lw=0.9, **{**look, "label": shown(look["label"])})


@styled
def error_against_step(panels, order: int = 2):
    """Largest errors against the step length, log-log, with a triangle of the slope `order`.

    panels: list of (title, {method: (h (k,), error (k,))}).
    """
    figure = new_figure(4.4 * len(panels), 3.9)
    for ax, (title, methods) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels):
        for name, (h, error) in methods.items():
            ax.plot(h, error, marker=method_marker(name), **method_style(name))
        ax.set_xscale("log", base=2)
        ax.set_yscale("log")
        ax.set_xlabel("step length $h$ (model units)")
        ax.set_ylabel(r"$\max_k\,|w_k - w(hk)|$")
        ax.set_title(shown(title))
        slope_triangle(ax, methods, order)
        ax.legend(loc="upper left")
    return figure


def slope_triangle(ax, methods, order: int) -> None:
    """A right triangle of slope `order` below the lowest curve, with its legs named."""
    h, error = min(methods.values(), key=lambda m: np.min(np.asarray(m[1]) / np.asarray(m[0])**order))
    h, error = np.sort(np.asarray(h, float)), np.sort(np.asarray(error, float))
    a, b = h[-1] / 8, h[-1] / 2
    low = 0.25 * np.exp(np.interp(np.log(a), np.log(h), np.log(error)))
    high = low * (b / a) ** order
    ax.plot([a, b, b, a], [low, low, high, low], color=INK, lw=0.9, zorder=4)
    ax.text(np.sqrt(a * b), low * 0.7, "1", ha="center", va="top", fontsize=8)
    ax.text(b * 1.12, np.sqrt(low * high), f"{order}", ha="left", va="center", fontsize=8)


@styled
def invariant_errors(t, energy=None, momenta=None, casimirs=None, title: str = "", unit=plain):
    """Errors of energy (k,), momenta {family: (k, 3)} and Casimirs (k, m) over time.

    Every value is the difference from its start; of the Casimirs the largest error is drawn.
    """
    rows = invariant_rows(energy, momenta or {}, casimirs, unit)
    figure = new_figure(6.4, 1.55 * max(len(rows), 1) + 0.9)
    axes = figure.subplots(max(len(rows), 1), 1, sharex=True, squeeze=False)[:, 0]
    for ax, (label, curves) in zip(axes, rows):
        for name, y in curves:
            ax.plot(*envelope(t, y), lw=0.8, color=COMPONENTS.get(name, INK), label=f"${name}$")
        ax.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3), useMathText=True)
        ax.set_ylabel(label)
        if len(curves) > 1:
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes[-1].set_xlabel(TIME.format(unit("t")))
    axes[0].set_title(shown(title) or "Errors of the invariants")
    return figure


def invariant_rows(energy, momenta, casimirs, unit):
    """[(axis label, [(name, error (k,))])]: one row for each kind of invariant."""
    rows = []
    if energy is not None:
        rows.append((with_unit("$H - H_0$", unit("energy"), "\n"), [("energy", np.asarray(energy) - energy[0])]))
    for family, m in momenta.items():
        change = np.asarray(m, float) - np.asarray(m, float)[0]
        rows.append((with_unit(f"momentum of {shown(family)}\nminus its start", unit(f"momentum.{family}"), "\n"),
                     [(x, change[:, i]) for i, x in enumerate("xyz")]))
    if casimirs is not None:
        change = np.asarray(casimirs, float) - np.asarray(casimirs, float)[:1]
        worst = np.take_along_axis(change, np.abs(change).argmax(1)[:, None], 1)[:, 0]
        rows.append((with_unit("largest change\nof a Casimir", unit("casimirs"), "\n"), [("largest error", worst)]))
    return rows


@styled
def against_time(t, panels, title: str = "", note: str = "", unit=plain):
    """Panels {name: curves (k,) or {label: (colour, curve (k,))}} over time; `note` stands below; unit: of t and of each name."""
    figure = new_figure(6.4, 1.6 * len(panels) + 0.7)
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, (name, curves) in zip(axes, panels.items()):
        curves = curves if isinstance(curves, dict) else {name: (INK, curves)}
        for label, (color, y) in curves.items():
            ax.plot(*envelope(t, y), lw=0.9, color=color, label=shown(label))
        ax.set_ylabel(with_unit(shown(name), unit(name), "\n"))
    if len(curves) > 1:
        axes[0].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axes[-1].set_xlabel(TIME.format(unit("t")))
    axes[0].set_title(shown(title))
    footnote(figure, note)
    return figure
