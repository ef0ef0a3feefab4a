"""`smidgen list`: the specs that come with it, or its methods."""
from __future__ import annotations

from .options import json_option
from .say import printed

EXAMPLES = """  smidgen list
  smidgen list --methods
  smidgen list --json"""


def add(commands):
    """The sub-command."""
    parser = commands.add("list", command, "list the specs that come with smidgen, or the methods", EXAMPLES)
    parser.add_argument("--methods", action="store_true", help="list the methods and what each preserves")
    json_option(parser)


def command(args):
    """One line a spec: name, title, runs; or one a method."""
    if args.methods:
        return list_methods(args)
    from ..read import load
    from ..resources import scenes, shipped
    found = [facts(name, path, load(str(path))) for name, path in {**shipped(), **scenes()}.items()]
    if args.json:
        return printed(found)
    width = max((len(f["name"]) for f in found), default=0)
    for one in found:
        print(f"{one['name']:{width}}  {one['title']}\n{'':{width}}  runs: "
              f"{', '.join(one['runs']) or 'none'}")


def facts(name, path, spec) -> dict:
    """What the list says of a spec."""
    return {"name": name, "title": spec.title, "runs": [r.name for r in spec.runs],
            "effects": list(spec.effect_names), "path": str(path)}


def list_methods(args):
    """One line a method: its name, and what the registry says of it in a line."""
    from ..methods import METHODS
    if args.json:
        return printed([{"name": m.name, "order": m.order, "symplectic": m.symplectic, "summary": m.summary} for m in METHODS.values()])
    width = max(map(len, METHODS))
    for name, method in METHODS.items():
        print(f"{name:{width}}  {method.summary}")
