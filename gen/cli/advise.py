"""`smidgen advise`: the largest safe step for a run."""
from __future__ import annotations

from .options import json_option, model_options, run_option, spec_argument, whole
from .run import start_of
from .say import printed

EXAMPLES = """  smidgen advise point_vortices
  smidgen advise heisenberg_chain random --seed 5 --set n=20
  smidgen advise top.toml demo --h 0.5 --json"""


def add(commands):
    """The sub-command."""
    parser = commands.add("advise", command, "estimate the largest safe step of a run and explain what limits it", EXAMPLES)
    spec_argument(parser)
    model_options(parser)
    parser.add_argument("--h", help="the step to compare with the advice; if negative, the advice is for a backward run")
    for name in ("start", "seed"):
        run_option(parser, name)
    long = parser.add_mutually_exclusive_group()
    long.add_argument("--steps", type=whole, help="length of the run to examine, in steps of h")
    long.add_argument("--time", help="length of the run to examine, as a time")
    json_option(parser)


def command(args):
    """The advice in sentences."""
    from ..analyse.advice import advise
    from ..read.shipped import load_spec
    given = {w: getattr(args, w) for w in ("method", "solver", "effects", "h", "seed", "steps", "time")
             if getattr(args, w) is not None}
    if args.start is not None:
        given["start"] = start_of(args.start)
    advice = advise(load_spec(args.spec, args.library), args.run, parameters=dict(args.parameters), **given)
    if args.json:
        return printed(advice.as_dict())
    print(f"{advice.spec} {advice.run}, {advice.method}:".replace(" ,", ","))
    for sentence in advice.words():
        print(sentence)
