"""`smidgen cost`: what accuracy costs in time."""
from __future__ import annotations

from .options import check_places, json_option, names, number, spec_argument, study_choices, study_options
from .say import printed, say

EXAMPLES = """  smidgen cost free_rigid_body --time 100
  smidgen cost point_vortices --out vortices.csv --plot vortices.png
  smidgen cost heisenberg_chain --set n=20 --seconds 20
  smidgen cost --from vortices.csv --plot again.svg   draw a table"""


def add(commands):
    """The sub-command."""
    parser = commands.add("cost", command, "measure the time that each method needs for an accuracy", EXAMPLES)
    spec_argument(parser, nargs="?")
    study_options(parser)
    parser.add_argument("--seconds", type=lambda text: number(text, "--seconds"), default=60.0,
                        help="the most seconds to spend on timed runs (default: 60)")
    parser.add_argument("--no-long", action="store_true", help="omit the long runs")
    parser.add_argument("--no-ends", action="store_true", help="do not compute errors of the final state; compare conserved quantities only")
    parser.add_argument("--peers", type=names, nargs="?", const=True, default=False, metavar="A,B",
                        help="include general-purpose integrators, either those named or all that are installed: GSL, SUNDIALS, SciPy, heyoka, hand-written C")
    parser.add_argument("--mean", metavar="NUMBER", help="at a temperature: the quantity, energy or an observable, whose mean is compared (default: the energy)")
    parser.add_argument("--out", metavar="FILE", help="write the table to this .csv file")
    parser.add_argument("--plot", metavar="FILE", help="write a figure to this .png, .svg or .pdf file")
    parser.add_argument("--from", metavar="FILE", dest="table", help="read this table instead of measuring")
    json_option(parser)


def command(args):
    """Measure, or read; then the file, the figure and the words."""
    from ..cost import Cost, load_cost
    from ..errors import UsageError
    check_places(args.out, args.plot)
    table = load_cost(args.table) if args.table else measured(args)
    if args.out:
        say(f"wrote {table.save(args.out)}")
    if args.plot and not isinstance(table, Cost):
        raise UsageError("scenes at a temperature have no figure; use --out to write the table")
    if args.plot:
        from ..show.plot.cost import draw_cost
        say(f"wrote {draw_cost(table, args.plot)}")
    if args.json:
        return printed({"facts": table.facts, "rows": [vars(row) for row in table.rows]})
    print(table)


def measured(args):
    """The table of a spec."""
    from ..cost import cost
    from ..errors import UsageError
    from ..progress import progress
    from ..read.shipped import load_spec
    if args.spec is None:
        raise UsageError("give a spec to measure, or --from FILE")
    with progress(1000, "cost") as tick:
        return cost(load_spec(args.spec, args.library), args.run, **study_choices(args), seconds=args.seconds, long=not args.no_long,
                    ends=not args.no_ends, peers=args.peers, mean=args.mean, progress=lambda what, done: tick(int(1000 * done)))
