"""Where the cells of a sweep are computed: processes of this machine, or workers of a Dask cluster."""
from __future__ import annotations

import contextlib
import multiprocessing
import socket
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from ..errors import UsageError

CONNECT = 10.0      # seconds for an answer: schedulers on a network take one at most


@contextlib.contextmanager
def executor(processes: int, cluster: str | None) -> Iterator[Executor]:
    """An executor of that many processes, or that of the Dask scheduler at the address `cluster`.

    Raises UsageError where Dask is not installed, or no scheduler answers.
    """
    if cluster is None:
        with ProcessPoolExecutor(processes, multiprocessing.get_context("fork")) as pool:
            yield pool
        return
    with client(cluster) as connected, connected.get_executor(pure=False, retries=0) as pool:
        yield pool


def client(cluster: str):
    """A Dask client connected to the scheduler."""
    try:
        from distributed import Client
    except ImportError:
        raise UsageError("a cluster needs the package `distributed`: pip install 'smidgen[cluster]', here and where the workers run") from None
    answers(cluster)
    try:
        return Client(cluster, timeout=CONNECT)
    except (OSError, ValueError, TypeError) as problem:
        raise UsageError(f"no Dask scheduler answers at {cluster}: {problem}") from None


def answers(cluster: str) -> None:
    """Does anything listen there? Asked before Dask, whose clients try again for a while after they have failed. Raises UsageError."""
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
