"""Tables of rich as text: on a terminal fitted to it, elsewhere a row is a line, however long."""
from __future__ import annotations

import sys

UNBROKEN = 10_000       # columns: more than any row needs


def text_of(table) -> str:
    """The table without colours."""
    console = _console(UNBROKEN, no_color=True)
    with console.capture() as capture:
        console.print(table)
    return capture.get()


def show(table) -> None:
    """The table on stdout."""
    _console(None if sys.stdout.isatty() else UNBROKEN).print(table)


def _console(width, **more):
    from rich.console import Console
    return Console(width=width, highlight=False, **more)
