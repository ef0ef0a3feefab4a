"""`smidgen explain`: what is conserved, from the spec alone."""
from __future__ import annotations

from .options import json_option, model_options, spec_argument
from .say import printed

EXAMPLES = """  smidgen explain heisenberg_chain
  smidgen explain free_rigid_body classical
  smidgen explain top.toml --set I2=1 --effects rotation --json"""


def add(commands):
    """The sub-command."""
    parser = commands.add("explain", command, "report what is conserved and what the method preserves", EXAMPLES)
    spec_argument(parser)
    model_options(parser)
    json_option(parser)


def command(args):
    """One sentence a line."""
    from ..read.shipped import load_spec
    from ..analyse.symmetry import explain
    report = explain(load_spec(args.spec, args.library), args.run, method=args.method, effects=args.effects, parameters=dict(args.parameters))
    if args.json:
        return printed(report.as_dict())
    print(f"{report.spec}, {report.method}:")
    for sentence in report.words():
        print(sentence)
