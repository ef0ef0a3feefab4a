"""Where the cells of a sweep are computed: processes of this machine, or workers of a Dask cluster."""
from __future__ import annotations

import contextlib
import importlib.util
import multiprocessing
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from ..errors import UsageError

CONNECT = 10.0      # seconds for an answer: schedulers on a network take one at most
_stop = None        # of a process of this machine: the event that all of them share


@contextlib.contextmanager
def executor(processes: int, cluster: str | None) -> Iterator[tuple[Executor, Callable | None]]:
    """An executor of that many processes, and what tells them to begin no more; or that of the Dask scheduler at the address `cluster`, and None.

    Raises UsageError where no scheduler answers; `check` tells before.
    """
    if cluster is None:
        context = multiprocessing.get_context("fork")
        event = context.Event()
        with ProcessPoolExecutor(processes, context, initializer=_begin, initargs=(event,)) as pool:
            yield pool, event.set
        return
    with client(cluster) as connected, connected.get_executor(pure=False, retries=0) as pool:
        yield pool, None


def _begin(event) -> None:
    global _stop
    _stop = event


def stopped() -> bool:
    """Has this process been told to begin no more?"""
    return _stop is not None and _stop.is_set()


def stop() -> None:
    """All processes beside this one begin no more."""
    if _stop is not None:
        _stop.set()


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
        raise UsageError("a cluster needs the package `distributed`: pip install 'smidgen[cluster]', here and where the workers run")
    scheme, _, place = cluster.rpartition("://")
    host, _, port = place.rpartition(":")
    if scheme not in ("", "tcp", "tls") or not host or not port.isdecimal():
        raise UsageError(f"'{cluster}' is no address of a Dask scheduler, such as tcp://host:8786")
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
