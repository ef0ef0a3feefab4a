"""`smidgen effects`: the library of pieces, or one of them."""
from __future__ import annotations

import dataclasses

from .options import json_option, library_option
from .say import printed

EXAMPLES = """  smidgen effects
  smidgen effects spins/uniaxial
  smidgen effects mine/pump --library ~/pieces"""


def add(commands):
    """The sub-command."""
    parser = commands.add("effects", command, "show the library of effects, or one of them: formula, arguments, law, source", EXAMPLES)
    parser.add_argument("piece", metavar="PIECE", nargs="?", help="a name of the library; default: all, a line each")
    library_option(parser)
    json_option(parser)


def command(args):
    """One line a piece, or all that is known of one."""
    from ..read.catalogue import catalogue, piece
    found = [piece(name, args.library) for name in ([args.piece] if args.piece else catalogue(args.library))]
    if args.json:
        return printed([dataclasses.asdict(one) for one in found])
    width = max(len(one.name) for one in found)
    print("\n".join([f"{one.name:{width}}  {one.title}" for one in found] if args.piece is None else whole(found[0])))


def whole(one) -> list[str]:
    """All that is known of a piece."""
    lines = [f"{one.name}: {one.title}", *(f"  {key} = {value}" for key, value in one.effect.items()), "arguments"]
    width = max(map(len, one.arguments), default=0)
    lines += [f"  {name:{width}}  {argument(says)}" for name, says in one.arguments.items()]
    return lines + [f"{key}: {text}" for key, text in (("law", one.law), ("source", one.source), ("file", one.path)) if text]


def argument(says: dict) -> str:
    """Meaning, unit, choices and default of an argument."""
    choices = f"one of {', '.join(map(str, says['one_of']))}" if "one_of" in says else ""
    default = f"default {says['default']}" if "default" in says else "needed"
    return "; ".join(part for part in (says.get("meaning", ""), says.get("unit", ""), choices, default) if part)
