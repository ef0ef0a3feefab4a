"""`smidgen validate`."""
from .options import json_option, spec_argument


def add(commands):
    """The sub-command."""
    parser = commands.add("validate", command, "validate", "  smidgen validate heisenberg_chain")
    spec_argument(parser)
    json_option(parser)


def command(args):
    """Not there yet."""
    from ..errors import MissingTool
    raise MissingTool("validate is not part of this build")
