"""`smidgen effects`: the library of pieces, one of them, or the effects of a scene."""
from __future__ import annotations

import dataclasses

from ..errors import Exit, UsageError
from .options import json_option, library_option, model_options
from .say import printed, say

EXAMPLES = """  smidgen effects
  smidgen effects spins/uniaxial
  smidgen effects mine/pump --library ~/pieces
  smidgen effects film.toml                         what each effect of a scene costs, and what is lost
  smidgen effects --test --library ~/pieces         check the laws of pieces"""


def add(commands):
    """The sub-command."""
    parser = commands.add("effects", command, "list the library of effects, show one of its pieces, or report what each effect of a scene costs and which properties it destroys", EXAMPLES)
    parser.add_argument("word", metavar="PIECE or SPEC", nargs="?", help="a piece of the library, or a scene (default: list the library)")
    model_options(parser)
    parser.add_argument("--test", action="store_true", help="check the laws of the pieces: run the [test] of each and compare")
    parser.add_argument("--no-times", action="store_true", help="for a scene: do not measure times")
    library_option(parser)
    json_option(parser)


def command(args):
    """One line a piece, all that is known of one, or a table of a scene."""
    from ..read.catalogue import catalogue, piece
    known = catalogue(args.library)
    if args.word is not None and args.word not in known and is_spec(args.word):
        return of_scene(args)
    if args.run:
        raise UsageError("a piece has no runs; RUN requires a SPEC")
    found = [piece(name, args.library) for name in ([args.word] if args.word else known)]
    if args.test:
        return tested(found, args)
    if args.json:
        return printed([{**dataclasses.asdict(one), "kind": one.kind} for one in found])
    width = max(len(one.name) for one in found)
    print("\n".join([f"{one.name:{width}}  {one.kind:7}  {one.title}" for one in found] if args.word is None else whole(found[0])))


def is_spec(word: str) -> bool:
    from ..resources import scenes, shipped
    return word in {**shipped(), **scenes()} or word.endswith(".toml")


def of_scene(args):
    """A line for each effect."""
    from ..cost.effects import effects_table, table
    from ..read.origins import origins
    from ..read.shipped import find_spec
    from ..tables import show
    spec, places = origins(find_spec(args.word), args.library)
    rows = effects_table(spec, places, args.run, method=args.method, solver=args.solver, effects=args.effects,
                         parameters=dict(args.parameters), times=not args.no_times)
    if args.json:
        return printed([dataclasses.asdict(row) for row in rows])
    show(table(rows))


def whole(one) -> list[str]:
    """All that is known of a piece."""
    lines = [f"{one.name}: {one.title}", f"kind: {one.kind}", *(f"  {key} = {value}" for key, value in one.effect.items()), "arguments"]
    width = max(map(len, one.arguments), default=0)
    lines += [f"  {name:{width}}  {argument(says)}" for name, says in one.arguments.items()]
    return lines + [f"{key}: {text}" for key, text in (("law", one.law), ("source", one.source), ("file", one.path)) if text]


def argument(says: dict) -> str:
    """Meaning, unit, choices and default of an argument."""
    choices = f"one of {', '.join(map(str, says['one_of']))}" if "one_of" in says else ""
    default = f"default {says['default']}" if "default" in says else "needed"
    return "; ".join(part for part in (says.get("meaning", ""), says.get("unit", ""), choices, default) if part)


def tested(found, args):
    """A line a law; exit code 5 where one does not hold."""
    from ..check.laws import table, verdicts
    from ..tables import show
    laws = [law for one in found for law in verdicts(one, args.library)]
    without = [one.name for one in found if not one.test]
    if args.json:
        printed({"laws": [{**dataclasses.asdict(law), "passed": law.passed} for law in laws], "without": without})
    else:
        show(table(laws))
    if without:
        say(f"without a [test]: {', '.join(without)}")
    broken = dict.fromkeys(law.piece for law in laws if not law.passed)
    if broken:
        say(f"smidgen: these laws do not hold: {', '.join(broken)}")
    return Exit.VALIDATION if broken else Exit.OK
