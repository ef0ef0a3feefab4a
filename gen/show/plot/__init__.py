"""Pictures: `plot` draws a result; `figures` holds those of the paper and the demo.

    smidgen.plot("chain.h5", kind="chain", out="chain.pdf")

matplotlib is imported with the first picture. After `import smidgen`, `smidgen.plot` is the
function, and `from smidgen.show.plot import ...` finds this package.
"""
from __future__ import annotations

import os
from pathlib import Path

from ...language.spec import Spec
from ...packages import needed
from ...public import public
from ...run.files.output import Result

__all__ = ["kinds", "page", "plot"]


@public
def plot(source: Result | Spec | str | os.PathLike, run: str | None = None, *, kind: str = "auto", part: str | dict | None = None,
         out: str | os.PathLike | None = None) -> Path:
    """Draw `source` and return the path of the picture.

    source: a Result, the path of a file that a run wrote (.csv, .npz, .h5), or a spec (its
    path, the name of one that comes with smidgen, or a Spec), of which `run` (by default
    the first) is run. kind: one of `kinds()`. part: of a lattice, "x=0:20,y=5:15" (ranges) or "z=1.5"
    (a layer), or a dictionary of these. out: a path that ends in .png, .svg, .pdf,
    .html for the player, .gif or .mp4 for a film; by default the spec's name and the kind, here.
    Raises MissingTool for .mp4 without ffmpeg, UsageError for a wrong kind or ending, and what reading and running raise.
    """
    needed("matplotlib", "a picture")
    from .draw import plot as draw
    return draw(source, run, kind=kind, out=out, part=part)


def kinds() -> dict[str, str]:
    """name -> one line, of every kind that `plot` draws."""
    from .pictures import kinds as known
    return known()


def page(result) -> str:
    """The HTML page that turns and plays a result. Raises UsageError for one that cannot be drawn."""
    needed("matplotlib", "the player")
    from .draw import page as drawn
    return drawn(result)


def drawn(result: Result, kind: str = "auto"):
    """The matplotlib figure of a result. Raises UsageError for one that cannot be drawn, and for the player, which is a page."""
    needed("matplotlib", "a picture")
    from .draw import figure
    return figure(result, kind)
