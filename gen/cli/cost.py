"""`smidgen cost`: what accuracy costs in time."""
from __future__ import annotations

from .options import assignment, json_option, names, number, spec_argument, whole
from .run import start_of
from .say import printed, say

EXAMPLES = """  smidgen cost free_rigid_body --time 100
  smidgen cost point_vortices --out vortices.csv --plot vortices.png
  smidgen cost heisenberg_chain --set n=20 --seconds 20
  smidgen cost --from vortices.csv --plot again.svg   the figure of a table"""


def add(commands):
    """The sub-command."""
    parser = commands.add("cost", command, "measure which method gives which accuracy in the least time", EXAMPLES)
    spec_argument(parser, nargs="?")
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec; default: its first")
    parser.add_argument("--time", help="how long: a number or a formula; default: as long as the run")
    parser.add_argument("--methods", type=names, metavar="A,B", help="of these only; default: all that serve")
    parser.add_argument("--effects", type=names, metavar="A,B", help="keep these effects only")
    parser.add_argument("--set", type=assignment, action="append", default=[], dest="values", metavar="NAME=VALUE",
                        help="a parameter; a list as 1,2,3; repeatable")
    parser.add_argument("--start", help="a start of the spec, or a .csv or .npy of rows x,y,z")
    parser.add_argument("--seed", type=whole, help="seed of a random start")
    parser.add_argument("--seconds", type=lambda text: number(text, "--seconds"), default=60.0,
                        help="what the timed runs may take together (60)")
    parser.add_argument("--no-long", action="store_true", help="leave the long runs out")
    parser.add_argument("--native", action="store_true", help="compile for this processor")
    parser.add_argument("--out", metavar="FILE", help="the table as .csv")
    parser.add_argument("--plot", metavar="FILE", help="the figure: .png, .svg or .pdf")
    parser.add_argument("--from", metavar="FILE", dest="table", help="a table that was written before, instead of measuring")
    json_option(parser)


def command(args):
    """Measure, or read; then the file, the figure and the words."""
    from ..cost import load_cost
    table = load_cost(args.table) if args.table else measured(args)
    if args.out:
        say(f"wrote {table.save(args.out)}")
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
        raise UsageError("a spec to measure, or --from FILE")
    with progress(1000, "cost") as tick:
        return cost(load_spec(args.spec), args.run, time=args.time, methods=args.methods, effects=args.effects, values=dict(args.values),
                    start=None if args.start is None else start_of(args.start), seed=args.seed, seconds=args.seconds,
                    long=not args.no_long, native=args.native, progress=lambda what, done: tick(int(1000 * done)))
