"""`smidgen play`: a page that turns and plays a result."""
from __future__ import annotations

from .options import json_option, open_option
from .say import opened, printed

EXAMPLES = """  smidgen play film.h5                  writes film_player.html, named after the spec
  smidgen play film.h5 --open           and opens it in the browser
  smidgen play free_rigid_body demo --out top.html"""


def add(commands):
    """The sub-command."""
    parser = commands.add("play", command, "write an HTML page that animates a result; a spec is run first", EXAMPLES)
    parser.add_argument("source", metavar="SOURCE", help="a result file of `smidgen run`, or a SPEC")
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec (default: the first)")
    parser.add_argument("--out", metavar="FILE", help="the .html file to write (default: in the current folder, named after the spec)")
    open_option(parser)
    json_option(parser)


def command(args):
    """Write the page; its path is the data."""
    from ..show.plot import plot
    path = plot(args.source, args.run, kind="player", out=args.out)
    printed({"out": str(path)}) if args.json else print(path)
    opened(path, args.open)
