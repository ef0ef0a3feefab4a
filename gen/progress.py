"""Progress with the time left, on a terminal; nothing in a pipe."""
from __future__ import annotations

import contextlib
import sys


@contextlib.contextmanager
def progress(total: int, what: str, stream=None):
    """Yields a function that takes the number of steps done."""
    stream = stream or sys.stderr
    if not stream.isatty():
        yield lambda done: None
        return
    with _bar(stream) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done: bar.update(task, completed=done)


def _bar(stream):
    from rich.console import Console
    from rich.progress import (BarColumn, MofNCompleteColumn, Progress, TextColumn,
                               TimeElapsedColumn, TimeRemainingColumn)
    return Progress(TextColumn("{task.description}", markup=False), BarColumn(),
                    MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"),
                    TimeRemainingColumn(), console=Console(file=stream), transient=True)
