"""`smidgen snapshot`: one state of a result, as a file for other programs and in numbers."""
from __future__ import annotations

import argparse

from ..errors import UsageError
from .options import json_option, names, number
from .say import printed, say

EXAMPLES = """  smidgen snapshot film.h5 --out last.ovf               the last state
  smidgen snapshot film.h5 --time 50 --out film.vtk --text
  smidgen snapshot film.h5 --row=-1 --what magnetisation,charge"""
TELLS = ("magnetisation", "charge")


def add(commands):
    """The sub-command."""
    parser = commands.add("snapshot", command, "write one state of a lattice as .ovf or .vtk (or all states, as .pvd), or print its magnetisation and charge", EXAMPLES)
    parser.add_argument("result", metavar="RESULT", help="a result file of `smidgen run`")
    parser.add_argument("--family", metavar="FAMILY", help="the family of vectors (default: the only one)")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=lambda text: number(text, "--time"), metavar="T", help="take the output at this time (default: the last state)")
    which.add_argument("--row", type=row, metavar="K", help="take the output with this number, counted from 0; --row=-1 is the last")
    parser.add_argument("--out", metavar="FILE", help="the file to write: .ovf, .vtk, .vtu, .vtr or .vti, or .pvd for all outputs")
    parser.add_argument("--text", action="store_true", help="write numbers as text instead of binary")
    parser.add_argument("--what", type=names, default=(), metavar="A,B", help=f"quantities to print: {', '.join(TELLS)}")
    json_option(parser)


def command(args):
    """The file, then the path and the numbers as data."""
    from ..run.files.output import load_result
    from ..run.fields.snapshot import snapshot
    if not args.out and not args.what:
        raise UsageError(f"give a file to write (--out last.ovf) or quantities to print (--what {','.join(TELLS)})")
    result = load_result(args.result)
    found = told(args, result)
    if args.out:
        found["out"] = str(snapshot(result, args.out, args.family, args.row, args.time, args.text))
    if args.json:
        return printed(found)
    for name, value in found.items():
        print(value if name == "out" else f"{name}: {value}")


def told(args, result) -> dict:
    """What --what names, of the state."""
    from ..run.fields import lattice
    from ..run.fields.grid import family_of, of, with_parameters
    from ..run.fields.snapshot import state_of
    unknown = [name for name in args.what if name not in TELLS]
    if unknown:
        raise UsageError(f"a state has no '{unknown[0]}'; it has: {', '.join(TELLS)}")
    if not args.what:
        return {}
    spec, parameters = with_parameters(result, None)
    family = family_of(spec, args.family)
    w, step, t = state_of(result, family, args.row, args.time)
    tell = {"magnetisation": lambda: lattice.magnetisation(w).tolist(), "charge": lambda: float(lattice.charge(w, of(spec, family, parameters)))}
    found = {"step": step, "t": float(t)}
    for name in args.what:
        try:
            found[name] = tell[name]()
        except UsageError as problem:
            if len(args.what) == 1:
                raise
            say(f"no {name}: {problem}")
    return found


def row(text: str) -> int:
    """The number of an output, from the end where negative."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not an integer") from None
