"""The one style of every picture: fonts, axes, the looks of methods, and how a figure is saved."""
from __future__ import annotations

import functools
import textwrap
import warnings
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from ...errors import UsageError
from .colours import INK, STYLES, PALETTE, SOFT
from .text import PARAGRAPH, printable, shown

STYLE = {
    "figure.dpi": 110, "savefig.dpi": 160, "savefig.bbox": "tight",
    "figure.facecolor": "white", "savefig.facecolor": "white",
    "font.family": "DejaVu Sans", "font.size": 9.5, "mathtext.fontset": "dejavusans",
    "axes.titlesize": 10.5, "axes.titlelocation": "left", "axes.labelsize": 9.5,
    "axes.spines.top": False, "axes.spines.right": False,
    "axes.edgecolor": "#4A4F55", "axes.linewidth": 0.8,
    "axes.grid": True, "grid.color": "#E3E6EA", "grid.linewidth": 0.6,
    "axes.axisbelow": True, "axes.prop_cycle": matplotlib.cycler(color=PALETTE),
    "lines.linewidth": 1.2, "lines.markersize": 4.5,
    "legend.frameon": False, "legend.fontsize": 8.5,
    "xtick.labelsize": 8.5, "ytick.labelsize": 8.5,
    "svg.hashsalt": "smidgen", "svg.fonttype": "path", "pdf.fonttype": 42,
    "image.interpolation": "nearest", "image.cmap": "cividis",
}

FORMATS = ("png", "svg", "pdf")
LETTERS = 14        # of a footnote in an inch
SHORT = 24          # letters of a title that fits anywhere
WIDEST, LEAST = 40, 0.6     # inches; of the size of text in a picture that is made smaller
_UNDATED = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


def method_style(name: str) -> dict:
    """Keyword arguments of `Axes.plot` for a method: the same colours in every figure."""
    label, color, dash, _ = STYLES.get(name, (name, INK, ":", "d"))
    return {"label": label, "color": color, "linestyle": dash}


def method_marker(name: str) -> str:
    """The marker of a method."""
    return STYLES.get(name, (name, INK, ":", "d"))[3]


def footnote(figure: Figure, *words: str) -> None:
    """What a figure must say below its axes, such as "24 of 400 sites shown"; nothing of no words."""
    said = printable("; ".join(word for word in words if word), PARAGRAPH)
    if said:
        lines = textwrap.wrap(said, int(LETTERS * figure.get_figwidth()))
        figure.supxlabel("\n".join(shown(line) for line in lines), x=0.01, ha="left", fontsize=8, color=SOFT)


def fit_titles(figure: Figure) -> Figure:
    """The figure, its titles broken into lines where they would reach beyond it or into the next panel."""
    titles = [(text, ax) for ax in figure.axes for text in (ax.title, ax._left_title)] + [(text, None) for text in filter(None, [figure._suptitle])]
    titles = [(text, ax) for text, ax in titles if len(text.get_text()) > SHORT and text.get_visible()]
    if titles:
        figure.draw_without_rendering()
    for text, ax in titles:
        place = text.get_window_extent()
        room = right_edge(figure, ax) - place.x0
        if place.width > room > 0:
            letters = max(SHORT // 2, int(0.97 * room / place.width * max(map(len, text.get_text().split("\n")))))
            text.set_text("\n".join(part for line in text.get_text().split("\n") for part in textwrap.wrap(line, letters)))
    return figure


def right_edge(figure: Figure, ax) -> float:
    """Up to where a title of `ax` may reach, in pixels: to the panel on its right, or to the edge of the figure."""
    own = ax.get_window_extent() if ax is not None else figure.bbox
    beside = [other.x0 for other in (one.get_window_extent() for one in figure.axes) if other.x0 >= own.x1 and other.y0 < own.y1 and other.y1 > own.y0]
    return min([*(beside if ax is not None else ()), figure.bbox.x1])


def styled(function):
    """Decorator: draw under the one style, whatever the caller's own rc settings are."""
    @functools.wraps(function)
    def inner(*args, **kwargs):
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(STYLE)
            return function(*args, **kwargs)
    return inner


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of width x height inches that belongs to no window and no global state."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def panels(count: int, tall: float = 1.0):
    """(figure, its axes, how many stand side by side) for `count` panels of a map that is `tall` times as high as wide, at most three in a row."""
    across = min(3, count)
    rows = -(-count // across)
    figure = new_figure(3.0 * across + 0.8, rows * (0.45 + 2.55 * min(max(tall, 0.15), 2.0)) + 0.4)
    axes = figure.subplots(rows, across, squeeze=False).ravel()
    for ax in axes[count:]:
        ax.remove()
    return figure, axes[:count], across


def resized(figure: Figure, width: float | None) -> Figure:
    """The figure at this width in inches, with its proportions; None leaves it as it is. Text scales with it, down to LEAST of its size."""
    if width is None:
        return figure
    if not 1 <= width <= WIDEST:
        raise UsageError(f"a picture must be between 1 and {WIDEST} inches wide, not {width:g}")
    ratio = width / figure.get_figwidth()
    figure.set_size_inches(width, ratio * figure.get_figheight())
    scale = min(max(ratio, LEAST), 1)
    for text in figure.findobj(Text):
        text.set_fontsize(scale * text.get_fontsize())
    for ax in figure.axes:
        ax.tick_params(labelsize=scale * STYLE["xtick.labelsize"])
    for text in filter(None, (figure._suptitle, figure._supxlabel)):       # matplotlib has no other way to them
        text.set_text("\n".join(textwrap.wrap(text.get_text(), int(LETTERS * width * 8 / text.get_fontsize()))))
    return figure


@styled
def save(figure: Figure, out, exact: bool = False) -> Path:
    """Write `figure` to `out` (.png, .svg, .pdf): same figure, same bytes, no date inside. exact: keep its size, instead of cutting empty margins.

    Raises UsageError for another ending or where the file cannot be written.
    """
    fit_titles(figure)
    path = Path(out)
    kind = path.suffix.lstrip(".").lower()
    if kind not in FORMATS:
        raise UsageError(f"cannot draw into '{path.name}': the name must end in one of "
                         + ", ".join("." + f for f in FORMATS) + " (or .html for the player)")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Glyph .* missing")     # a box is drawn instead
            figure.savefig(path, format=kind, metadata=_UNDATED[kind], bbox_inches=figure.bbox_inches if exact else "tight")
    except OSError as e:
        raise UsageError(f"cannot write '{path}': {e.strerror or e}") from None
    return path
