"""`smidgen plot`."""
from .options import json_option, spec_argument


def add(commands):
    """The sub-command."""
    parser = commands.add("plot", command, "plot", "  smidgen plot heisenberg_chain")
    spec_argument(parser)
    json_option(parser)


def command(args):
    """Not there yet."""
    from ..errors import MissingTool
    raise MissingTool("plot is not part of this build")
