"""`smidgen completion SHELL`: the script with which a shell completes commands and options."""
from __future__ import annotations

from functools import partial

from ..packages import needed

EXAMPLES = """  smidgen completion bash > ~/.local/share/bash-completion/completions/smidgen
  smidgen completion zsh > ~/.zfunc/_smidgen"""
SHELLS = ("bash", "zsh", "tcsh")


def add(commands):
    """The sub-command."""
    parser = commands.add("completion", partial(command, commands.parser), "print a completion script for a shell", EXAMPLES)
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=" or ".join(SHELLS))


def command(whole, args):
    """The script, made from the parser of the whole command line."""
    print(needed("shtab", "completion").complete(whole, args.shell))
