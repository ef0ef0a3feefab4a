"""Where the cells of a sweep are computed: processes of this machine, or workers of a Dask cluster."""
from __future__ import annotations

import contextlib
import logging
import multiprocessing
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from ..errors import UsageError

CONNECT = "20s"


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
    """A Dask client connected to the scheduler; its errors are exceptions here, not lines of a log."""
    try:
        from distributed import Client
    except ImportError:
        raise UsageError("a cluster needs the package `distributed`: pip install 'smidgen[cluster]', here and where the workers run") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        return Client(cluster, timeout=CONNECT)
    except (OSError, ValueError, TypeError) as problem:
        raise UsageError(f"no Dask scheduler answers at {cluster}: {problem}") from None


def lost() -> tuple[type[Exception], ...]:
    """What a future raises whose process or worker has ended."""
    try:
        from distributed import KilledWorker
    except ImportError:
        return (BrokenProcessPool,)
    return BrokenProcessPool, KilledWorker
