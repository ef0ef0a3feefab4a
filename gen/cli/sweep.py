"""`smidgen sweep`: a run over values of parameters and random starts, into a folder."""
from __future__ import annotations

import argparse
import math
from pathlib import Path

from ..errors import Exit
from ..language import limits
from .options import chosen, json_option, number, processor_options, run_option, spec_argument, start_of, whole
from .say import printed, say

EXAMPLES = """  smidgen sweep free_rigid_body --set I3=3:4:11 --out bodies
  smidgen sweep spins.toml demo --set J=0:2:50 --set B=0.5 --starts 20 --out spins
  smidgen sweep spins.toml demo --set J=0:2:50 --set B=0.5 --starts 20 --out spins   continues where it stopped"""


def add(commands):
    """The sub-command."""
    parser = commands.add("sweep", command, "repeat a run for many parameter values and random starts", EXAMPLES)
    spec_argument(parser)
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec (default: the first)")
    parser.add_argument("--set", type=axis, action="append", default=[], dest="axes", metavar="NAME=FIRST:LAST:COUNT",
                        help="COUNT evenly spaced values of a parameter from FIRST to LAST, or a single value, or a list as 1,2,3; may be repeated")
    parser.add_argument("--starts", type=whole, metavar="N", help="N random starts for each combination of values, with consecutive seeds from --seed on")
    parser.add_argument("--seed", type=whole, help="the first seed (default: 0); without --starts, the seed of all cells")
    parser.add_argument("--out", required=True, metavar="FOLDER", help="folder for the results; repeat the same command to continue an interrupted sweep")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--processes", type=whole, metavar="N", help="number of cells to compute at the same time (default: one per processor)")
    where.add_argument("--cluster", metavar="ADDRESS", help="compute on the workers of this Dask scheduler, such as tcp://host:8786")
    for name in ("method", "solver"):
        run_option(parser, name, choices=None)
    for name in ("effects", "start", "h"):
        run_option(parser, name)
    for pair in (("steps", "time"), ("every", "period")):
        one = parser.add_mutually_exclusive_group()
        for name in pair:
            run_option(one, name)
    for name in ("what", "tolerance", "substeps"):
        run_option(parser, name)
    processor_options(parser)
    for name in ("fast", "threads", "real"):
        run_option(parser, name)
    parser.add_argument("--estimate", action="store_const", const=True, help="repeat each cell with larger and smaller steps to estimate its error")
    json_option(parser)


CHOICES = ("method", "solver", "effects", "h", "steps", "time", "every", "period", "what", "tolerance", "substeps", "fast", "threads", "real", "estimate")


def axis(text: str):
    """`J=0:2:50` -> ("J", [0, .., 2], True); `J=1` and `g=1,2,3`: one value, for all cells -> (.., .., False)."""
    from .options import assignment
    name, equals, value = text.partition("=")
    ends = value.split(":")
    if not equals or len(ends) == 1:
        return (*assignment(text), False)
    if len(ends) != 3:
        raise argparse.ArgumentTypeError(f"'{text}' does not have the form NAME=FIRST:LAST:COUNT, such as J=0:2:50")
    what, name = f"--set {name.strip()}", assignment(f"{name}=0")[0]
    (first, unit), (last, other), count = end(ends[0], what), end(ends[1], what), whole(ends[2])
    if unit != other:
        raise argparse.ArgumentTypeError(f"'{text}': give both ends in the same unit, such as J=0 meV:2 meV:50")
    if not 1 <= count <= limits.CELLS:
        raise argparse.ArgumentTypeError(f"a sweep must have from 1 to {limits.CELLS} cells, not {count}")
    values = [between(first, last, k, count) for k in range(count)]
    return name, [f"{value!r} {unit}" for value in values] if unit else values, True


def end(text: str, what: str) -> tuple:
    """(a number, its unit) of an end of a range."""
    from ..read.given import parts_of
    value, unit = parts_of(text) or (text, "")
    return number(value, what), unit


def between(first, last, k: int, count: int):
    """The k-th of `count` values; both ends are exact, and integers where they are."""
    if k == 0 or count == 1:
        return first
    if k == count - 1:
        return last
    step = (last - first) * k
    return first + step // (count - 1) if isinstance(step, int) and step % (count - 1) == 0 else first + step / (count - 1)


def command(args):
    """Run what is left of the sweep; the exit code tells of failed cells."""
    from ..progress import progress
    from ..read.shipped import load_spec
    from ..run.many.sweep import sweep
    given = chosen(args, CHOICES)
    given |= {"parameters": {name: value for name, value, swept in args.axes if not swept}, "native": args.native,
              "start": None if args.start is None else start_of(args.start)}
    axes = {name: value for name, value, swept in args.axes if swept}
    ended, total = [], math.prod(map(len, axes.values()), start=args.starts or 1)
    try:
        with progress(total, "cells") as tick:
            found = sweep(load_spec(args.spec, args.library), args.run, axes=axes, out=args.out, starts=args.starts, seed=args.seed, processes=args.processes, cluster=args.cluster,
                          tell=lambda outcome: (ended.append(outcome), tick(len(ended)), said(outcome)), **given)
    except KeyboardInterrupt:
        say(f"smidgen: interrupted after {len(ended)} cells; repeat the same command to compute the others in {Path(args.out)}")
        return Exit.INTERRUPTED
    failed = [outcome for outcome in found if outcome["status"] != "complete"]
    if args.json:
        printed({"folder": args.out, "cells": found})
    else:
        print(f"{len(found)} cells in {Path(args.out)}, {len(failed)} of them failed")
        for outcome in failed:
            print(named(outcome))
    return Exit.STEP if failed else Exit.OK


def said(outcome: dict) -> None:
    """A cell that has failed, as soon as it has."""
    if outcome["error"]:
        say(named(outcome))


def named(outcome: dict) -> str:
    from ..run.many.sweep import Cell
    return f"{Cell(outcome['cell'], outcome['parameters'], outcome['seed'])}: {outcome['error'] or outcome['status']}"
