"""The errors that a user can meet, and the exit code of each.

    SmidgenError        base; `exit_code` is what the command returns
      UsageError        2    a wrong option, name or value on the command line or in a call
        KeywordError         a keyword that a function has not (a TypeError too)
        ColumnError          a column that a result has not (a KeyError too)
        ReadOnlyError        an attribute that cannot be assigned to (an AttributeError too)
      SpecError         3    a spec that cannot be read: a list of `Diagnostic`
      RunError          4    a step that failed; carries the runtime's status
      ValidationError   5    two computations that should agree do not
      MissingTool       6    no compiler, no library
      BuildError        7    the compiler refused the generated C
      OutputError       8    a file cannot be written
"""
from __future__ import annotations

import enum
import unicodedata
from dataclasses import dataclass


class Exit(enum.IntEnum):
    """Exit codes of the command `smidgen`."""
    OK = 0
    USAGE = 2
    SPEC = 3
    STEP = 4
    VALIDATION = 5
    TOOL = 6
    BUILD = 7
    OUTPUT = 8
    INTERRUPTED = 130
    PIPE = 141          # 128 + SIGPIPE, as a shell says it


class SmidgenError(Exception):
    """The base class of all errors that are reported without a traceback."""
    exit_code = Exit.USAGE


class UsageError(SmidgenError):
    """A wrong name, option or value in a command or a call."""
    exit_code = Exit.USAGE


class KeywordError(UsageError, TypeError):
    """A public function was called with an unknown keyword."""


class ColumnError(UsageError, KeyError):
    """A column that a result has not."""
    __str__ = Exception.__str__     # a KeyError puts its message into quotes


class ReadOnlyError(UsageError, AttributeError):
    """An assignment to an attribute that is read-only or does not exist."""


class OutputError(SmidgenError):
    """A result cannot be written, for example for lack of space or permission. An existing file is unchanged."""
    exit_code = Exit.OUTPUT


class BuildError(SmidgenError):
    """The C compiler failed; `log` contains its output."""
    exit_code = Exit.BUILD

    def __init__(self, message: str, log: str = ""):
        super().__init__(message)
        self.log = log


class RunError(SmidgenError):
    """A step failed.

    :ivar status: the `smg_status` of the runtime, an int.
    :ivar step: the number of steps that succeeded before.
    :ivar iterations: the number of iterations. `residual`: the residual.
    :ivar site: the site at which it failed, and `partner`, a second site that contributed; -1 if there is none.
    :ivar reached: the fraction of h up to which there is a solution.
    :ivar rate: |h b|, the angle by which the field turns the site in a step.
    """
    exit_code = Exit.STEP

    def __init__(self, message: str, status: int = 0, step: int = 0,
                 iterations: int = 0, residual: float = 0.0, site: int = -1,
                 partner: int = -1, reached: float = 0.0, rate: float = 0.0):
        super().__init__(message)
        self.status, self.step = status, step
        self.iterations, self.residual = iterations, residual
        self.site, self.partner, self.reached, self.rate = site, partner, reached, rate

    def with_more(self, text: str) -> RunError:
        """The same error, with `text` at the end of its message."""
        self.args = (str(self) + text,)
        return self


class ValidationError(SmidgenError):
    """The generated code and the witness differ by more than the tolerance."""
    exit_code = Exit.VALIDATION


class MissingTool(SmidgenError):
    """A compiler or library that is needed is not installed."""
    exit_code = Exit.TOOL


WINDOW = 100        # characters of a source line that a message shows at most


@dataclass(frozen=True)
class Diagnostic:
    """One error in a spec.

    line and column count from 1 in code points, line 0 means the file as a whole; text is
    the source line, length the number of characters that the caret underlines, cause what
    is wrong, hint what to write instead.
    """
    code: str
    file: str
    line: int
    column: int
    text: str
    cause: str
    hint: str
    length: int = 1

    def render(self) -> str:
        """`file:line:column: error[CODE]: cause`, the line, a caret, the hint; the line only where there is one."""
        place = f":{self.line}:{self.column}" if self.line else ""
        head = f"{printable(self.file)}{place}: error[{self.code}]: {printable(self.cause)}"
        gutter = " " * len(str(self.line))
        return "\n".join([head, *self.marked(gutter)] + [f" {gutter} = {printable(self.hint)}"] * bool(self.hint))

    def marked(self, gutter: str) -> list[str]:
        """The source line and the caret below it; nothing of an empty line."""
        if not self.text:
            return []
        shown, pad, width = excerpt(self.text, self.column - 1, self.length)
        return [f" {self.line} | {shown}", f" {gutter} | {' ' * pad}^{'~' * (width - 1)}"]


class SpecError(SmidgenError):
    """A spec has errors; `diagnostics` contains at most `limits.ERRORS` of them."""
    exit_code = Exit.SPEC

    def __init__(self, diagnostics, more: bool = False):
        self.diagnostics = tuple(diagnostics)
        self.more = more
        super().__init__(self.__str__())

    def __str__(self) -> str:
        tail = ["there are more errors; correct these first"] if self.more else []
        return "\n\n".join([d.render() for d in self.diagnostics] + tail)


def printable(text: str) -> str:
    """`text` with what a terminal would not show as written replaced by `\\u{...}`."""
    return "".join(c if plain(c) else f"\\u{{{ord(c):x}}}" for c in text)


def plain(c: str) -> bool:
    """Is `c` safe to print: no control, format (bidi, zero width), surrogate, private."""
    return unicodedata.category(c) not in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")


def columns(text: str) -> int:
    """Terminal cells that `text` takes: wide characters two, combining ones none."""
    return sum(0 if unicodedata.combining(c) else
               2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def excerpt(line: str, at: int, length: int) -> tuple[str, int, int]:
    """(what to show of `line`, cells before the caret, cells underlined)."""
    line = line.replace("\t", " ")
    first = max(0, at - WINDOW // 2) if len(line) > WINDOW else 0
    last = first + WINDOW
    before = ("... " if first else "") + printable(line[first:at])
    marked = printable(line[at:min(at + length, last)])
    after = printable(line[at + length:last]) + (" ..." if last < len(line) else "")
    return before + marked + after, columns(before), max(1, columns(marked))
