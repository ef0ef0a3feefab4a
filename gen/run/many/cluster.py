"""Where the cells of a sweep are computed: processes of this machine, or workers of a Dask cluster."""
from __future__ import annotations

import contextlib
import importlib.util
import multiprocessing
import os
import signal
import socket
import threading
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from ...errors import UsageError

CONNECT = 10.0      # seconds for an answer: schedulers on a network take one at most
_stop = None        # of a process of this machine: not 0 in any is not 0 in all. It has no lock: handlers of signals set it


class Workers:
    """Who computes the cells: `pool` takes them, `stop` tells all to begin no more, `end` ends those that can be ended; `token` names that
    word to the workers of a cluster ("": they are processes of this machine)."""

    def __init__(self, pool: Executor, stop: Callable, end: Callable, token: str = ""):
        self.pool, self.stop, self.end, self.token = pool, stop, end, token


@contextlib.contextmanager
def executor(processes: int, cluster: str | None) -> Iterator[Workers]:
    """That many processes of this machine, which end when it does; or those of the Dask scheduler at the address `cluster`.

    Raises UsageError where no scheduler answers; `check` tells before.
    """
    with _here(processes) if cluster is None else _elsewhere(cluster) as found:
        yield found


@contextlib.contextmanager
def _here(processes: int) -> Iterator[Workers]:
    context = multiprocessing.get_context("fork")
    told, (life, held) = context.RawValue("b", 0), os.pipe()

    def stop() -> None:
        told.value = 1

    def end() -> None:
        for process in multiprocessing.active_children():
            process.terminate()
    try:
        with ProcessPoolExecutor(processes, context, initializer=_begin, initargs=(told, life, held)) as pool:
            yield Workers(pool, stop, end)
    finally:
        os.close(held)
        os.close(life)


@contextlib.contextmanager
def _elsewhere(cluster: str) -> Iterator[Workers]:
    with client(cluster) as connected, connected.get_executor(pure=False, retries=0) as pool:
        from distributed import Event
        token = f"smidgen-{uuid.uuid4().hex}"
        yield Workers(pool, Event(token, connected).set, lambda: None, token)


def _begin(told, life: int, held: int) -> None:
    """In a new process. The end `held` of the pipe is open in the process that began the sweep alone: when that ends, by whatever, so does this one.
    Between cells, where it holds locks of the pool, an interrupt tells it to begin no more, and raises nothing."""
    global _stop
    _stop = told
    signal.signal(signal.SIGINT, lambda *_: stop())
    os.close(held)
    threading.Thread(target=_end_with, args=(life,), daemon=True).start()


def _end_with(life: int) -> None:
    while os.read(life, 1):
        pass
    os._exit(1)


def stopped(token: str) -> bool:
    """Has this worker been told to begin no more?"""
    if token:
        from distributed import Event
        return Event(token).is_set()
    return _stop is not None and _stop.value != 0


def stop() -> None:
    """All processes beside this one begin no more."""
    if _stop is not None:
        _stop.value = 1


def client(cluster: str):
    """A Dask client connected to the scheduler."""
    from distributed import Client
    try:
        return Client(cluster, timeout=CONNECT)
    except (OSError, ValueError, TypeError) as problem:
        raise UsageError(f"no Dask scheduler answers at {cluster}: {problem}") from None


def check(cluster: str) -> None:
    """Is Dask here, and does anything listen there? Asked before a client is made, which would try again for a while after it has failed.
    Raises UsageError."""
    if importlib.util.find_spec("distributed") is None:
        raise UsageError("a cluster needs the package `distributed`: pip install 'smidgen[cluster]', here and for the workers")
    scheme, _, place = cluster.rpartition("://")
    host, _, port = place.rpartition(":")
    if scheme not in ("", "tcp", "tls") or not host or not port.isdecimal():
        raise UsageError(f"'{cluster}' is not the address of a Dask scheduler, such as tcp://host:8786")
    try:
        socket.create_connection((host.strip("[]"), int(port)), CONNECT).close()
    except (OSError, OverflowError) as problem:
        raise UsageError(f"no Dask scheduler answers at {cluster}: {problem}") from None


def lost() -> tuple[type[BaseException], ...]:
    """What is raised where a process, a worker or the scheduler has ended."""
    try:
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError
        from distributed.comm import CommClosedError
    except ImportError:
        return BrokenProcessPool, CancelledError
    return BrokenProcessPool, CancelledError, KilledWorker, FutureCancelledError, CommClosedError
