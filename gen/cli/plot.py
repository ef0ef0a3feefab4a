"""`smidgen plot`: a picture of a result, or the page that turns and plays it."""
from __future__ import annotations

from ..errors import UsageError
from .options import json_option, number, open_option
from .say import opened, printed, say

EXAMPLES = """  smidgen plot chain.h5
  smidgen plot chain.h5 --kind energy --out energy.pdf
  smidgen plot free_rigid_body demo --out top.html   runs it and writes an interactive page
  smidgen plot film.h5 --part x=10:30,y=10:30        a part of a lattice
  smidgen plot film.h5 --out film.gif                a film
  smidgen plot chain.h5 --width 3.4 --out chain.pdf  the width of a column
  smidgen plot chain.h5 --open                       and show it
  smidgen plot --kinds                               what can be drawn"""


def add(commands):
    """The sub-command."""
    parser = commands.add("plot", command, "draw a result; a spec is run first", EXAMPLES)
    parser.add_argument("source", metavar="SOURCE", nargs="?",
                        help="a result file of `smidgen run`, or a SPEC")
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec (default: the first)")
    parser.add_argument("--kind", default="auto", help="kind of picture (default: one that suits the result)")
    parser.add_argument("--part", metavar="PART", help="draw only a part of a lattice: ranges x=0:20,y=5:15, or a layer z=1.5")
    parser.add_argument("--out", metavar="FILE", help="the file to write: .png, .svg or .pdf, .html (a player), .gif or .mp4 (a film)")
    parser.add_argument("--width", type=lambda text: number(text, "--width"), metavar="INCHES", help="width of the picture (default: depends on the kind)")
    open_option(parser)
    parser.add_argument("--kinds", action="store_true", help="list the kinds of pictures")
    json_option(parser)


def command(args):
    """Write the picture; its path is the data."""
    from ..packages import needed
    from ..show.plot import kinds
    if args.kinds:
        return show_kinds(args, kinds())
    if args.source is None:
        raise UsageError("give a result file or a spec to draw")
    needed("matplotlib", "a picture")
    from ..show.plot.draw import plot
    path = plot(args.source, args.run, kind=args.kind, out=args.out, part=args.part, width=args.width, chose=told)
    printed({"out": str(path)}) if args.json else print(path)
    opened(path, args.open)


def told(kind: str) -> None:
    """The kind of picture that was chosen."""
    from ..show.plot import kinds
    say(f"kind {kind}: {kinds()[kind]}; --kind chooses another")


def show_kinds(args, found: dict):
    """One line a kind."""
    if args.json:
        return printed(found)
    for name, meaning in found.items():
        print(f"{name:12} {meaning}")
