"""`smidgen new`: a spec to start from."""
from __future__ import annotations

import re
from pathlib import Path

from ..errors import OutputError, UsageError
from .options import json_option
from .say import printed, say

EXAMPLES = """  smidgen new my_top                        a commented spec, my_top.toml
  smidgen new my_chain --from heisenberg_chain"""


def add(commands):
    """The sub-command."""
    parser = commands.add("new", command, "write a new spec to edit", EXAMPLES)
    parser.add_argument("name", metavar="NAME", help="name of the model, which is also the prefix of its C functions")
    parser.add_argument("--from", dest="source", metavar="SPEC", help="start from a copy of this shipped spec")
    parser.add_argument("--out", metavar="FILE", help="file to write (default: NAME.toml)")
    json_option(parser)


def command(args):
    """Write the file; an existing one is never overwritten."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", args.name):
        raise UsageError(f"'{args.name}' is not a valid name: use letters, digits and _, and start with a letter")
    from ..read import load_text
    path = Path(args.out or f"{args.name}.toml")
    text = renamed(source_text(args.source), args.name)
    if args.source is None:
        load_text(text)                 # a reserved word as a name is refused here
    try:
        with open(path, "x", encoding="utf-8") as out:
            out.write(text)
    except FileExistsError:
        raise UsageError(f"{path} already exists") from None
    except OSError as problem:
        raise OutputError(f"cannot write {path}: {problem.strerror}") from None
    say(f"next: smidgen check {path}, then smidgen run {path}")
    printed({"spec": str(path)}) if args.json else print(path)


def source_text(word) -> str:
    """The text to copy."""
    from ..read.shipped import find_spec
    path = find_spec(word) if word else Path(__file__).with_name("new.toml")
    try:
        return path.read_text(encoding="utf-8")
    except OSError as problem:
        raise UsageError(f"cannot read {path}: {problem.strerror}") from None


def renamed(text: str, name: str) -> str:
    """`text` with the name of its model replaced."""
    return re.sub(r'^(\s*name\s*=\s*)"[^"]*"', rf'\1"{name}"', text, count=1, flags=re.MULTILINE)
