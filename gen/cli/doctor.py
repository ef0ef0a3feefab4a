"""`smidgen doctor`: what is installed, and whether a small model builds, runs and validates."""
from __future__ import annotations

import dataclasses

from ..errors import Exit
from .options import json_option
from .say import printed

EXAMPLES = """  smidgen doctor
  smidgen doctor --json"""


def add(commands):
    """The sub-command."""
    json_option(commands.add("doctor", command, "show what is installed and test it with a small model", EXAMPLES))


def command(args):
    """One line a finding; exit code 6 where something is missing that the main job needs."""
    from ..check.doctor import examined
    found = examined()
    if args.json:
        printed([{**dataclasses.asdict(f), "mark": f.mark} for f in found])
    else:
        width = max(len(f.what) for f in found)
        print("\n".join(f"{f.mark:8} {f.what:{width}}  {f.found}" for f in found))
    return Exit.OK if all(f.good or not f.needed for f in found) else Exit.TOOL
