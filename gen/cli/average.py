"""`smidgen average`: means over time and members, with their errors."""
from __future__ import annotations

from .options import chosen, json_option, model_options, processor_options, run_option, spec_argument, start_of, whole
from .say import printed, say

EXAMPLES = """  smidgen average hot.toml --after 50 --out hot.json
  smidgen average hot.toml --what mz,energy --time 20 --after 10 --members 1000 --out hot.json
  smidgen average hot.toml --what mz,energy --time 20 --after 10 --members 1000 --out hot.json   continues where it stopped"""
CHOICES = ("method", "solver", "h", "steps", "time", "every", "period", "what", "effects", "seed", "native", "tolerance")


def add(commands):
    """The sub-command."""
    parser = commands.add("average", command, "average observables over time and over members: mean, variance, standard error, histogram", EXAMPLES)
    spec_argument(parser)
    model_options(parser)
    for name in ("h", "start", "seed", "tolerance"):
        run_option(parser, name)
    run_option(parser, "what", help="quantities to average: energy, energy.EFFECT, momentum.FAMILY.x, or names of observables (default: the energy and all observables)")
    for pair in (("steps", "time"), ("every", "period")):
        one = parser.add_mutually_exclusive_group()
        for name in pair:
            run_option(one, name)
    processor_options(parser)
    parser.add_argument("--after", default=None, metavar="TIME", help="time of the first sample (default: that of the run's averages, otherwise 0)")
    parser.add_argument("--members", type=whole, default=1, metavar="N", help="number of trajectories, each with its own noise (default: 1)")
    parser.add_argument("--bins", type=whole, default=None, metavar="N", help="largest number of bins in a histogram (default: that of the run's averages, otherwise 64)")
    parser.add_argument("--out", metavar="FILE", help="the .json file to write; if an interrupted run left FILE.part, it is continued")
    json_option(parser)


def command(args):
    """A line a number, or all of it as JSON."""
    import json
    from ..progress import progress
    from ..read.shipped import load_spec
    from ..run.many.average import average
    from ..tables import show
    spec = load_spec(args.spec, args.library)
    with progress(args.members, "members") as tick:
        found = average(spec, args.run, **chosen(args, CHOICES), start=None if args.start is None else start_of(args.start),
                        parameters=dict(args.parameters), after=args.after, members=args.members, bins=args.bins, out=args.out, progress=tick)
    if args.out:
        say(f"wrote {args.out}")
    if args.json:
        return printed(json.loads(found.text()))
    show(table(found, spec))


def table(found, spec):
    """A rich Table; with a column of units, where numbers have some."""
    from rich.table import Table
    from ..language.units import TIME
    from ..run.record.units import of_column
    time, many = f" {spec.units.spelt(TIME)}" if spec.units else "", found.meta["members"]
    shown = Table(title=f"{found.meta['spec']}: {found.meta['samples']} samples of {many} member{'s' * (many != 1)}{', each' * (many != 1)} to t = "
                        f"{found.meta['steps'] * found.meta['h']:g}{time}, from t = {found.meta['after']:g}{time} on")
    for column in ("", "mean", "standard error", *["unit"] * bool(spec.units), "variance", f"correlation time{f' ({time[1:]})' * bool(time)}"):
        shown.add_column(column, justify="right" if column not in ("", "unit") else "left")
    for name, one in found.of.items():
        unit = [of_column(spec, spec.units, name)] if spec.units else []
        error, variance, correlation = ("" if x is None else f"{x:.3g}" for x in (one.error, one.variance, one.correlation))
        shown.add_row(name, f"{one.mean:.8g}", error, *unit, variance, correlation)
    return shown
