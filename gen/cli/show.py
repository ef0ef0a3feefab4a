"""`smidgen show`: a scene and all that it builds on, as one spec."""
from __future__ import annotations

from .options import spec_argument

EXAMPLES = """  smidgen show film_300K.toml
  smidgen show racetrack.toml --library ~/pieces > flat.toml"""


def add(commands):
    """The sub-command."""
    spec_argument(commands.add("show", command, "write a scene as a single spec that gives the file and line of every value", EXAMPLES))


def command(args):
    """The flat spec, which is a spec itself."""
    from ..read.shipped import flat
    print(flat(args.spec, args.library), end="")
