"""What reading a spec may do, whatever its text: give a Spec, or a SpecError that says where and why."""
import time

from smidgen.errors import SmidgenError, SpecError, columns, plain
from smidgen.language.limits import ERRORS
from smidgen.read import load_text
from smidgen.read.load import decoded
from smidgen.language.spec import Spec

SECONDS = 5         # of processor time for one text of at most FILE_BYTES; well below one is usual


def judge(text: str, seconds: float = SECONDS):
    """The Spec or the SpecError of a text; anything else that happens is a failure of the reader."""
    begin = time.process_time()
    try:
        found = load_text(text)
        assert isinstance(found, Spec)
    except SpecError as error:
        check_error(error, text)
        found = error
    assert time.process_time() - begin < seconds
    return found


def judge_bytes(data: bytes, seconds: float = SECONDS):
    """The same for the content of a file."""
    try:
        text = decoded(data, "spec.toml")
    except SpecError as error:
        assert [d.code for d in error.diagnostics] == ["E102"]
        return error
    return judge(text, seconds)


def check_error(error: SpecError, text: str) -> None:
    """Up to ten diagnostics in order, each at a place of the text, fit to print."""
    lines = text.removeprefix("\ufeff").replace("\r\n", "\n").split("\n")
    assert 1 <= len(error.diagnostics) <= ERRORS
    places = [(d.line, d.column) for d in error.diagnostics]
    assert places == sorted(places)
    for d in error.diagnostics:
        assert 1 <= d.line <= len(lines) and 1 <= d.column <= len(lines[d.line - 1]) + 1
        assert d.text == lines[d.line - 1] and d.length >= 1
        assert d.code[0] == "E" and d.code[1:].isdigit() and d.cause
    check_print(str(error))


def check_print(message: str) -> None:
    """Nothing that a terminal would take for a command or hide; every caret below its line."""
    message.encode("utf-8")
    assert all(plain(c) or c == "\n" for c in message)
    rows = message.split("\n")
    for above, row in zip(rows, rows[1:]):
        if row.strip(" |").startswith("^") and set(row.strip(" |")) <= {"^", "~"}:
            assert columns(row) <= columns(above) + 2


def judge_further(spec: Spec) -> None:
    """What loads can be compiled, or is refused in words."""
    from smidgen.compile.emit.emit import generate
    from smidgen.compile.select import select
    try:
        generate(select(spec))
    except SmidgenError as refusal:
        assert str(refusal)
