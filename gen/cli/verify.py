"""`smidgen verify`: the certificate of a generated integrator."""
from __future__ import annotations

import argparse

from ..errors import Exit, OutputError
from .options import chosen, feature_option, model_options, run_option, spec_argument, start_of, whole
from .say import say

EXAMPLES = """  smidgen verify heisenberg_chain --set n=10
  smidgen verify top.toml demo --json top.json      and: smidgen gen top.toml --certificate top.json
  smidgen verify top.toml --quick
  smidgen verify top.toml --long 1e7                round-off over ten million steps"""


def add(commands):
    """The sub-command."""
    parser = commands.add("verify", command, "certify the generated code: order, symplecticity, "
                          "reversibility, symmetry, integrals, round-off", EXAMPLES)
    spec_argument(parser)
    model_options(parser)
    feature_option(parser)
    tier = parser.add_mutually_exclusive_group()
    tier.add_argument("--quick", action="store_true", help="use fewer states and shorter runs")
    tier.add_argument("--long", type=steps, metavar="N", help="measure the growth of round-off over N steps")
    for name in ("h", "start", "seed"):
        run_option(parser, name)
    parser.add_argument("--layouts", action="store_true", help="include threads, wavefronts and MPI ranks (compiles lattices by rows twice more)")
    parser.add_argument("--json", metavar="FILE", dest="file", help="write the certificate as JSON to FILE, or - for stdout")


def steps(text: str) -> int:
    """A number of steps from 1000 up."""
    found = whole(text)
    if found < 1000:
        raise argparse.ArgumentTypeError("at least 1000 steps are needed")
    return found


def command(args):
    """The table; exit code 5 when a row says no."""
    from ..read.shipped import load_spec
    from ..tables import show
    from ..check.verify import verify
    given = {**chosen(args, ("method", "solver", "effects", "h", "seed")), "start": None if args.start is None else start_of(args.start)}
    certificate = verify(load_spec(args.spec, args.library), args.run, tier=args.long or ("quick" if args.quick else "normal"),
                         parameters=dict(args.parameters), features=args.features, layouts=args.layouts, **given)
    if args.file != "-":
        show(certificate.table())
    if args.file:
        write(certificate.to_json(), args.file)
    if certificate.passed:
        return Exit.OK
    say(f"smidgen: not certified: {', '.join(r.name for r in certificate.rows if r.verdict == 'no')}")
    return Exit.VALIDATION


def write(text: str, file: str):
    """The JSON to a file or to stdout."""
    if file == "-":
        print(text, end="")
        return
    try:
        with open(file, "w", encoding="utf-8") as out:
            out.write(text)
    except OSError as problem:
        raise OutputError(f"cannot write {file}: {problem.strerror}") from None
