"""The sub-commands and their help; each lives in a module of its own."""
from __future__ import annotations

import argparse
import difflib

from ..public import by_its_end
from ..renamed import OPTIONS, now
from ..resources import HERE
from ..version import __version__
from . import advise, average, check, choose, completion, cost, doctor, effects, explain, gen, list as list_, new, play, plot, run, show, snapshot, spectrum, sweep, validate, verify

CODES = """exit codes: 0 success, 1 a bug in smidgen, 2 wrong usage, 3 an invalid spec, 4 a step failed,
5 validation failed, 6 a tool is missing, 7 the C compiler failed, 8 a file cannot be written,
130 interrupted, 141 the reader of stdout has closed the pipe"""

SHOWN = 16      # choices that an error names


class Parser(argparse.ArgumentParser):
    """Says which word was probably meant: a command, a choice or an option."""

    def _check_value(self, action, value):
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            more = [*action.choices][SHOWN:]
            message = f"invalid choice: {value!r} (choose from {', '.join([*action.choices][:SHOWN])} and {len(more)} more)" if more else error.message
            error.message = guessed(message, value, action.choices)
            raise

    def parse_known_args(self, args=None, namespace=None):
        found, rest = super().parse_known_args(args, namespace)
        if rest:
            known = [name for name in self._option_string_actions if name.startswith("--")]
            message, word = f"unrecognized arguments: {' '.join(rest)}", rest[0].partition("=")[0]
            new = now(word, OPTIONS, known)
            self.error(f"{message}; '{word}' is now called '{new}'" if new else guessed(message, word, known))
        return found, rest

    def error(self, message):
        """What is wrong, and where all options are told; they themselves would hide it."""
        self.exit(2, f"{self.prog}: error: {message}; see `{self.prog} --help`\n")


def guessed(message: str, word: str, known) -> str:
    """`message` with the known word nearest to `word`, if there is one."""
    names = [str(k) for k in known]
    close = by_its_end(str(word), names) or next(iter(difflib.get_close_matches(str(word), names, 1)), None)
    return f"{message}; did you mean '{close}'?" if close else message


def make_parser() -> argparse.ArgumentParser:
    """The whole command line."""
    parser = Parser(
        prog="smidgen", epilog=CODES, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Compiles Hamiltonians written as formulas to structure-preserving "
                    "integrators in C and runs them.")
    parser.add_argument("--version", action="version", version=f"smidgen {__version__}")
    parser.add_argument("--cmake-dir", action="version", version=str(HERE / "cmake"), help="print the folder for CMake's smidgen_DIR and exit")
    commands = Commands(parser)
    for module in (new, check, show, effects, explain, advise, gen, run, average, sweep, cost, choose, validate, verify, plot, play, snapshot, spectrum, list_, doctor, completion):
        module.add(commands)
    return parser


class Commands:
    """Adds sub-commands with a one-line summary, a description and examples."""

    def __init__(self, parser):
        self.parser, self.commands = parser, parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def add(self, name: str, command, summary: str, examples: str, **more):
        """A sub-parser that calls `command(args)`."""
        parser = self.commands.add_parser(
            name, help=summary, description=summary[0].upper() + summary[1:] + ".",
            epilog="examples:\n" + examples, allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter, **more)
        parser.set_defaults(command=command)
        return parser
