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
         out: str | os.PathLike | None = None, width: float | None = None) -> Path:
    """Draw a result and return the path of the picture.

    source: a Result, the path of a result file (.csv, .npz or .h5), or a spec (a path, the name of a shipped spec, or a Spec),
    which is run first; run selects one of its runs, by default the first. kind: one of `kinds()`; "auto" chooses a suitable one.
    part: a part of a lattice, as ranges "x=0:20,y=5:15", a layer "z=1.5", or a dictionary of these. out: a path that ends in .png,
    .svg or .pdf for a picture, .html for the player, .gif or .mp4 for a film; by default a .png in the current folder, named after
    the spec and the kind. width: in inches; by default it depends on the kind.

    Raises UsageError for an unknown kind, ending or width, MissingTool if matplotlib (or, for .mp4, ffmpeg) is not installed, and the
    errors of reading and running a spec.
    """
    needed("matplotlib", "a picture")
    from .draw import plot as draw
    return draw(source, run, kind=kind, out=out, part=part, width=width)


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
