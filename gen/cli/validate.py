"""`smidgen validate`: compiled code against the independent witness."""
from __future__ import annotations

from ..errors import Exit
from .options import chosen, json_option, model_options, processor_options, run_option, spec_argument, start_of, whole
from .say import printed, say

EXAMPLES = """  smidgen validate heisenberg_chain
  smidgen validate top.toml demo --steps 200 --h 0.05
  smidgen validate top.toml --all --json          every run of the spec"""


def add(commands):
    """The sub-command."""
    parser = commands.add("validate", command,
                          "compare the compiled code with the independent witness", EXAMPLES)
    spec_argument(parser)
    model_options(parser)
    parser.add_argument("--all", action="store_true", help="validate every run of the spec")
    parser.add_argument("--steps", type=whole, help="number of steps to compare (default: 100)")
    parser.add_argument("--points", type=whole, default=5, help="number of random states (default: 5)")
    for name in ("h", "start", "seed"):
        run_option(parser, name)
    processor_options(parser)
    run_option(parser, "real")
    json_option(parser)


CHOICES = ("method", "solver", "effects", "h", "seed", "native", "real")


def command(args):
    """A table a run; exit code 5 when a line fails."""
    from ..read.shipped import load_spec
    from ..check.validate import validate
    spec = load_spec(args.spec, args.library)
    runs = [r.name for r in spec.runs] if args.all and spec.runs else [args.run]
    given = {**chosen(args, CHOICES), "start": None if args.start is None else start_of(args.start)}
    reports = [validate(spec, run, steps=args.steps, points=args.points,
                        parameters=dict(args.parameters), **given) for run in runs]
    show(args, reports)
    failed = [r for r in reports if not r.passed]
    if failed:
        say(f"smidgen: validation failed: {', '.join(f'{r.spec} {r.run}' for r in failed)}")
    return Exit.VALIDATION if failed else Exit.OK


def show(args, reports):
    """The tables, or the reports as JSON."""
    if args.json:
        return printed([r.as_dict() for r in reports])
    from ..check.validate import NOT_SEEN
    from ..tables import show as show_table
    for report in reports:
        show_table(report.table())
    say(f"smidgen: note: {NOT_SEEN}")
