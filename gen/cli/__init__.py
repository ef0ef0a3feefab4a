"""The command `smidgen`: parse, call, and turn every error into words and an exit code."""
from __future__ import annotations

import os
import sys
import tempfile
import traceback

from .. import ranks
from ..errors import Exit, SmidgenError, SpecError
from .parser import make_parser
from .say import describe, printed
from .streams import silence, streams

UNEXPECTED = 1      # a defect of smidgen itself


def main(argv=None) -> int:
    """Run the command; returns its exit code, never raises for what a user wrote."""
    with streams():
        return ranks.leave(done(argv))


def done(argv) -> int:
    """The same of one rank."""
    try:
        code = guarded(parsed(argv))
        sys.stdout.flush()
        return code
    except SmidgenError as error:       # of stdout itself
        return told(error)
    except BrokenPipeError:             # the reader of a pipe has gone: nothing is left to say
        silence(sys.stdout)
        return int(Exit.PIPE)
    except Exception:
        return unexpected()


def parsed(argv):
    """The arguments; --help and wrong ones end the program here."""
    try:
        return make_parser().parse_args(argv)
    finally:
        sys.stdout.flush()


def guarded(args) -> int:
    """The sub-command, with known errors said on stderr (and as JSON on stdout)."""
    try:
        return int(args.command(args) or Exit.OK)
    except SmidgenError as error:
        return told(error, getattr(args, "json", False))
    except MemoryError:
        print("smidgen: not enough memory: use fewer sites, a smaller array or fewer outputs", file=sys.stderr)
        return int(Exit.USAGE)
    except KeyboardInterrupt:
        print("smidgen: interrupted", file=sys.stderr)
        return int(Exit.INTERRUPTED)


def told(error: SmidgenError, as_json: bool = False) -> int:
    """Say what went wrong; the exit code."""
    said = str(error)
    print(said if isinstance(error, SpecError) else f"smidgen: {said}", file=sys.stderr)
    if as_json:
        printed({"error": describe(error)})
    return int(error.exit_code)


def unexpected() -> int:
    """A defect: one line and a log, or the traceback when SMIDGEN_DEBUG is set."""
    text = traceback.format_exc()
    if os.environ.get("SMIDGEN_DEBUG"):
        print(text, file=sys.stderr)
        return UNEXPECTED
    handle, log = tempfile.mkstemp(prefix="smidgen-", suffix=".log")
    with os.fdopen(handle, "w") as out:
        out.write(text)
    print(f"smidgen: this is a bug in smidgen, sorry: {text.strip().splitlines()[-1]}\n"
          f"the details are in {log}", file=sys.stderr)
    return UNEXPECTED
