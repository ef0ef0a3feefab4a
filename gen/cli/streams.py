"""stdin, stdout and stderr as a shell may leave them: closed, full, a pipe without a reader."""
from __future__ import annotations

import contextlib
import errno
import os
import sys

from ..errors import OutputError


@contextlib.contextmanager
def streams():
    """All three are there; what fails on stdout is an OutputError, narration that nobody can hear is lost."""
    fill()
    before = sys.stdin, sys.stdout, sys.stderr
    sys.stdin = sys.stdin or open(0, closefd=False)
    sys.stdout = Stdout(sys.stdout or open(1, "w", closefd=False))
    sys.stderr = Stderr(sys.stderr or open(2, "w", closefd=False))
    try:
        yield
    finally:
        sys.stdin, sys.stdout, sys.stderr = before


def fill() -> None:
    """No file of a run may get the number of a stream that was closed. stdout is then read-only: what
    is written there fails, as it should."""
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)       # takes the lowest free number: this one


class Stdout:
    """Data. Raises OutputError, and BrokenPipeError when the reader of a pipe has gone; a character that
    the stream does not have is written as an escape."""

    def __init__(self, stream):
        self.stream, self.gone = stream, False
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")

    def write(self, text: str) -> int:
        with self.failing():
            return self.stream.write(text)

    def flush(self) -> None:
        with self.failing():
            self.stream.flush()

    def __getattr__(self, name):
        return getattr(self.stream, name)

    @contextlib.contextmanager
    def failing(self):
        if self.gone:           # argparse keeps the first one to itself
            raise BrokenPipeError
        try:
            yield
        except BrokenPipeError:
            self.gone = True
            raise
        except OSError as problem:
            silence(self.stream)
            said = "it is closed" if problem.errno == errno.EBADF else problem.strerror
            raise OutputError(f"cannot write to stdout: {said}") from None


class Stderr(Stdout):
    """Narration: a run goes on without it."""

    @contextlib.contextmanager
    def failing(self):
        try:
            yield
        except OSError:
            silence(self.stream)


def silence(stream) -> None:
    """What `stream` still holds, and what comes, goes nowhere."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
