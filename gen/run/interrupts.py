"""Ctrl-C while others compute: counted, and raised between two results only. An exception from within what a pool does with its locks could
leave one of them held, and the pool would wait for it."""
from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait

POLL = 0.2      # seconds after which an interrupt is seen, at most


class Interrupts:
    """How many have come, and how many of them have been raised."""

    def __init__(self) -> None:
        self.count = self.raised = 0

    def check(self) -> None:
        """Raises KeyboardInterrupt where one has come since the last."""
        if self.count > self.raised:
            self.raised += 1
            raise KeyboardInterrupt

    def completed(self, futures: Iterable[Future]) -> Iterator[Future]:
        """Each when it is done, as concurrent.futures.as_completed has it. Raises KeyboardInterrupt between two of them."""
        left = set(futures)
        while left:
            done, left = wait(left, POLL, FIRST_COMPLETED)
            for future in done:
                self.check()
                yield future
            self.check()


@contextlib.contextmanager
def counted() -> Iterator[Interrupts]:
    """Within, Ctrl-C is counted; where nobody has raised the last of them, it is raised at the end. Other handlers than Python's own stay."""
    found = Interrupts()

    def count(number_, frame) -> None:
        found.count += 1

    with _handled(count, signal.default_int_handler):
        yield found
    found.check()


_noted = threading.Event()      # an interrupt came within `raised`


@contextlib.contextmanager
def raised() -> Iterator[None]:
    """Within, Ctrl-C raises KeyboardInterrupt, whatever it does outside. It is noted first: Python drops an exception that comes to a callback of its imports
    or of its garbage collector. One that was dropped is raised at the end, and ends a run before its next steps (`noted`)."""
    def note(number_, frame) -> None:
        _noted.set()
        raise KeyboardInterrupt

    try:
        with _handled(note):
            yield
        if noted():
            raise KeyboardInterrupt
    finally:
        _noted.clear()


def noted() -> bool:
    return _noted.is_set()


@contextlib.contextmanager
def _handled(handler, only=None) -> Iterator[None]:
    """SIGINT goes to `handler`; only: where it went to this one before. Signals reach the main thread alone."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None or only not in (None, before):
        yield
        return
    signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
