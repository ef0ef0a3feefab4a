"""Options that several sub-commands share, and how their text becomes values."""
from __future__ import annotations

import argparse
import math
from pathlib import Path

from ..compile.features import FEATURES
from ..errors import UsageError
from ..run.files.options import OPTIONS
from ..methods import NAMES as METHODS, SOLVERS


def spec_argument(parser, **more):
    """SPEC, --library."""
    parser.add_argument("spec", metavar="SPEC", **more,
                        help="a .toml file, or the name of a shipped spec (`smidgen list`)")
    library_option(parser)


def library_option(parser):
    """--library DIR."""
    parser.add_argument("--library", action="append", default=[], metavar="DIR", help="an additional folder to search for files named in a spec; may be repeated")


def model_options(parser):
    """What decides the C: RUN, --method, --solver, --effects, --set."""
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec (default: the first)")
    for name in ("method", "solver", "effects"):
        run_option(parser, name)
    parser.add_argument("--set", type=assignment, action="append", default=[], dest="parameters",
                        metavar="NAME=VALUE", help="set a parameter; write a list as 1,2,3; may be repeated")


def run_option(parser, name: str, **other):
    """--NAME of the choices of a run; other: what is otherwise in this command."""
    option = next(option for option in OPTIONS if option.name == name)
    more = {"help": option.help or None, **READS[option.reads], **other}
    parser.add_argument(f"--{name}", **more, **({"metavar": option.metavar} if option.metavar else {}))


def chosen(args, names_) -> dict:
    """Of these choices those that the command line makes."""
    return {name: getattr(args, name) for name in names_ if getattr(args, name) is not None}


def processor_options(parser):
    """--native, --portable: for which processors to compile."""
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--native", action="store_true", default=None, help="compile for this processor (default: only if the code is then "
                       "faster and gives the same bits)")
    which.add_argument("--portable", action="store_false", dest="native", default=None, help="compile code that runs on every processor of this family")


def study_options(parser):
    """What a study of many methods looks at: RUN, --time, --methods, --effects, --set, --start, --seed, --native, --portable."""
    parser.add_argument("run", metavar="RUN", nargs="?", help="a run of the spec (default: the first)")
    parser.add_argument("--time", help="duration, as a number or a formula (default: that of the run)")
    parser.add_argument("--methods", type=names, metavar="A,B", help="consider these methods only (default: all that apply)")
    parser.add_argument("--set", type=assignment, action="append", default=[], dest="parameters", metavar="NAME=VALUE",
                        help="set a parameter; write a list as 1,2,3; may be repeated")
    for name in ("effects", "start", "seed"):
        run_option(parser, name)
    processor_options(parser)


def study_choices(args) -> dict:
    """The same as keywords of `cost` and `choose`."""
    return {"time": args.time, "methods": args.methods, "effects": args.effects, "parameters": dict(args.parameters),
            "start": None if args.start is None else start_of(args.start), "seed": args.seed, "native": args.native}


def start_of(word: str):
    """A name, or the rows of a file."""
    from ..run.fields.field import FORMATS, load_field
    from ..run.step.start import state_table
    if word.endswith(tuple(FORMATS)):
        return load_field(word)
    return state_table(Path(word), word) if word.endswith((".csv", ".npy")) else word


def feature_option(parser):
    """--features: what the C shall have beyond the step."""
    parser.add_argument("--features", type=names, default=(), metavar="A,B",
                        help=f"additions to the C code: {', '.join(FEATURES)}")


def json_option(parser):
    """--json."""
    parser.add_argument("--json", action="store_true", help="print the result as JSON on stdout")


def check_places(*files) -> None:
    """Raises OutputError where one of the files that are given cannot be: before the work, not after it."""
    from ..run.files.durable import check_place
    for file in files:
        if file not in (None, "-"):
            check_place(Path(file))


def open_option(parser):
    """--open."""
    parser.add_argument("--open", action="store_true", help="open the file in the browser")


def names(text: str) -> tuple[str, ...]:
    """`a,b` -> ("a", "b")."""
    found = tuple(word.strip() for word in text.split(",") if word.strip())
    if not found:
        raise argparse.ArgumentTypeError("a list of names is expected, such as a,b")
    return found


def assignment(text: str) -> tuple[str, object]:
    """`J=2` -> ("J", 2), `B=pi/4` -> ("B", 0.78...), `g=1,1,-1` -> ("g", [1, 1, -1])."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"'{text}' does not have the form NAME=VALUE, such as J=2 or g=1,1,-1")
    if "=" in value:
        raise argparse.ArgumentTypeError(f"'{text}' sets more than one parameter: use a separate --set for each")
    parts = [entry(part, f"--set {name.strip()}") for part in value.split(",")]
    return name.strip(), parts[0] if len(parts) == 1 else parts


def entry(text: str, what: str):
    """A number, or a text with its unit: which one it may have is known to the spec."""
    from ..read.given import Bare, BareInteger, parts_of
    if parts_of(text):
        return text.strip()
    value = number(text, what)
    return BareInteger(value) if isinstance(value, int) else Bare(value)


def number(text: str, what: str):
    """The value of a formula of numbers and pi."""
    from ..read.given import constant
    try:
        value = constant(text, what)
    except UsageError as error:
        raise argparse.ArgumentTypeError(f"\n{error}") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{what} is not finite")
    return value


def whole(text: str) -> int:
    """An integer from 0 up; 1e6 is one."""
    value = number(text, "a count")
    if value != int(value) or value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a non-negative integer")
    return int(value)


# how argparse reads the text of a choice
READS = {"start": {}, "formula": {}, "whole": {"type": whole}, "names": {"type": names}, "flag": {"action": "store_true", "default": None},
         "method": {"choices": METHODS}, "solver": {"choices": SOLVERS}, "real": {"choices": ("double", "long double"), "default": "double"},
         "number": {"type": lambda text: number(text, "--tolerance")}}
