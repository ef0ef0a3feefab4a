"""`smidgen play`: a page that turns and plays a result."""
from __future__ import annotations

import webbrowser

from .options import json_option
from .say import printed

EXAMPLES = """  smidgen play film.h5                  writes film_player.html, named after the spec
  smidgen play film.h5 --open           and opens it in the browser
  smidgen play free_rigid_body demo --out top.html"""


def add(commands):
    """The sub-command."""
    parser = commands.add("play", command, "write a page that plays a result, or a spec that is run for it", EXAMPLES)
    parser.add_argument("source", metavar="SOURCE", help="a file that `smidgen run` wrote, or a SPEC")
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec; default: its first")
    parser.add_argument("--out", metavar="FILE", help="the page (.html); default: the spec's name, here")
    parser.add_argument("--open", action="store_true", help="open it in the browser")
    json_option(parser)


def command(args):
    """Write the page; its path is the data."""
    from ..show.plot import plot
    path = plot(args.source, args.run, kind="player", out=args.out)
    printed({"out": str(path)}) if args.json else print(path)
    if args.open:
        webbrowser.open(path.resolve().as_uri())
