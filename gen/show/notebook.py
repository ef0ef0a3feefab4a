"""What notebooks show of a spec, of reports and of tables: some words, and a picture where there is one.

The classes stand in earlier stages, which draw nothing; here they are told how.
"""
from __future__ import annotations

import base64
import html
import io

from ..analyse.spectrum import Spectrum
from ..cost.report import Cost
from ..errors import MissingTool, UsageError
from ..language.spec import Spec
from ..public import html_of
from ..run.files.output import Result
from ..run.many.average import Averages

TYPESET = 1400      # characters of equations
DOTS = 80           # of a picture, to the inch


def of_spec(spec: Spec) -> str:
    """Markdown: the title, the equations typeset, and what else the spec holds."""
    from .equations import equations
    lines = equations(spec)
    kept = next(n for n in range(len(lines), -1, -1) if len(r" \\ ".join(lines[:n])) <= TYPESET)
    more = [r"\dots"] if kept < len(lines) else []
    typeset = r" \\ ".join([*lines[:kept], *more])
    shown = rf"$$\begin{{gathered}} {typeset} \end{{gathered}}$$"
    named = "; ".join(f"{what}: {few(x.name for x in held)}" for what, held in (("parameters", spec.parameters), ("starts", spec.starts), ("runs", spec.runs)) if held)
    return f"**{escaped(spec.title or spec.name)}**\n\n{shown}\n\n{escaped(named)}"


def few(names, most: int = 12) -> str:
    names = list(names)
    return ", ".join(names[:most]) + f", .. ({len(names)})" * (len(names) > most)


def escaped(words: str) -> str:
    """Markdown's own signs taken literally."""
    return "".join("\\" + c if c in r"\`*_{}[]<>#$|~" else c for c in words)


def with_picture(words: str, figure) -> str:
    """The same below a picture; without it where none can be drawn."""
    try:
        return f'<img alt="{html.escape(words.splitlines()[0], quote=True)}" src="data:image/png;base64,{png(figure())}">{html_of(words)}'
    except (MissingTool, UsageError):
        return html_of(words)


def png(figure) -> str:
    """A matplotlib figure as base64."""
    image = io.BytesIO()
    figure.savefig(image, format="png", dpi=DOTS)
    return base64.b64encode(image.getvalue()).decode()


def of_cost(cost: Cost) -> str:
    def figure():
        from .plot.cost import cost_figure
        return cost_figure(cost)
    return with_picture(repr(cost), figure)


def of_spectrum(spectrum: Spectrum) -> str:
    def figure():
        from .plot.spectrum import spectrum_figure
        return spectrum_figure(spectrum)
    return with_picture(repr(spectrum), figure)


def of_averages(averages: Averages) -> str:
    """A table: name, mean, standard error."""
    rows = "".join(f"<tr><td>{html.escape(name)}</td><td>{one.mean:.6g}</td><td>{'' if one.error is None else format(one.error, '.2g')}</td></tr>" for name, one in [*averages.of.items()][:16])
    return f"{html_of(repr(averages))}<table><tr><th>quantity</th><th>mean</th><th>standard error</th></tr>{rows}</table>"


class Shown:
    """What a notebook shows of one call."""

    def __init__(self, words: str, html: str):
        self.words, self.html = words, html

    def __repr__(self) -> str:
        return self.words

    def _repr_html_(self) -> str:
        return self.html


class Results:
    """What `Result` shows, by its own methods."""

    @staticmethod
    def plot(result: Result, kind: str) -> Shown:
        from .plot import drawn
        return Shown(f"<picture of {result!r}>", f'<img src="data:image/png;base64,{png(drawn(result, kind))}">')

    @staticmethod
    def play(result: Result) -> Shown:
        from .plot import page
        from .plot.player import framed
        return Shown(f"<player of {result!r}>", framed(page(result)))

    @staticmethod
    def html(result: Result) -> str:
        from .plot import drawn
        return with_picture(repr(result), lambda: drawn(result, "auto"))


Result._shows = Results
Spec._repr_markdown_ = of_spec
Cost._repr_html_ = of_cost
Spectrum._repr_html_ = of_spectrum
Averages._repr_html_ = of_averages
