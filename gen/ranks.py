"""The ranks of MPI that share a run: `mpirun -n 4 smidgen run SPEC` (runtime/lattice/smg_row_ranks.h).

Every rank goes the same way through the run, so that all make the same calls of C. Where something decides that way that only one of
them knows (its clock, Ctrl-C, a file), rank 0 tells the others. It alone speaks and writes. Without mpirun nothing of this is used.
"""
from __future__ import annotations

import contextlib
import io
import os
import pickle
import re
import sys
import time
from collections.abc import Callable

from .errors import SmidgenError, UsageError

SIZE = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE")      # Open MPI; MPICH, Intel MPI and Slurm; MVAPICH
RANK = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK")
NEEDED = "several ranks need the package `mpi4py`: pip install 'smidgen[mpi]'"
GRACE = 3.0         # seconds in which others that failed likewise come to their end too
PATIENCE = 20       # times as long in C: w is gathered after each call


class World:
    """The ranks, as one of them sees them."""

    def __init__(self, mpi, said):
        self.mpi, self.comm = mpi, mpi.COMM_WORLD.Dup()     # messages of C have the first to themselves
        self.rank, self.size = self.comm.rank, self.comm.size
        self.said, self.done = said, False

    def codes(self, code: int, patience: float) -> list[int] | None:
        """The exit codes of all; None where not all come to their end in time."""
        import numpy as np
        mine, found = np.array([code], np.int32), np.zeros(self.size, np.int32)
        request, begin = self.comm.Iallgather(mine, found), time.monotonic()
        while not request.Test():
            if time.monotonic() - begin > patience:
                return None
            time.sleep(0.005)
        return found.tolist()

    def speak(self) -> None:
        """Say what was kept."""
        if self.said is not None and sys.__stderr__ is not None:
            sys.__stderr__.write(f"rank {self.rank}: {self.said.getvalue()}")
            sys.__stderr__.flush()


world: World | None = None
grid: str | None = None     # AxBxC or `auto`, as --grid has it


def variable(names) -> int | None:
    """The first of these environment variables that is a number."""
    return next((int(text) for text in (os.environ.get(name, "") for name in names) if text.isdecimal()), None)


def join() -> None:
    """Under mpirun, be one of its ranks. Raises UsageError without mpi4py, or where it is that of another MPI."""
    global world
    size = variable(SIZE) or 1
    if size == 1 or world is not None:
        return
    said = hushed() if variable(RANK) else None
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as problem:
        raise UsageError(f"{NEEDED} ({problem})") from None
    if MPI.COMM_WORLD.size != size:
        raise UsageError(f"mpirun started {size} processes, but mpi4py sees {MPI.COMM_WORLD.size}: it was built for a different MPI library than that of mpirun")
    world = World(MPI, said)


def hushed() -> io.StringIO:
    """Rank 0 speaks for all: what another one says is kept, until it is the one that failed."""
    sys.stdout, sys.stderr = io.StringIO(), io.StringIO()
    return sys.stderr


def finished() -> None:
    """The command came to its end: others do too, however long they write."""
    if world is not None:
        world.done = True


def leave(code: int) -> int:
    """The exit code that all agree on; where one failed and others did not, it speaks, and ends them."""
    if world is None:
        return code
    codes = world.codes(code, float("inf") if world.done else GRACE)
    if codes is None:
        world.speak()
        world.mpi.COMM_WORLD.Abort(code)
    elif next((rank for rank, found in enumerate(codes) if found), None) == world.rank:
        world.speak()
    return max(codes)


def arrange(asked: str | None) -> None:
    """Parts of ranks will be blocks of cells: as many along each direction, or `auto`. Raises UsageError."""
    global grid
    if asked is not None and not re.fullmatch(r"auto|[1-9]\d{0,5}(x[1-9]\d{0,5}){0,3}", asked):
        raise UsageError(f"--grid {asked}: give the number of ranks along each direction, such as 1x2x2, or auto")
    grid = asked


def count() -> int:
    """How many ranks share this run."""
    return 1 if world is None else world.size


def first() -> bool:
    """Is this the rank that writes?"""
    return world is None or world.rank == 0


def on_first(work: Callable[[], object], send: bool = True):
    """What work() gives on rank 0, for all; with send=False others have None. Its exception is raised by all."""
    if world is None:
        return work()
    value, error = None, None
    if world.rank == 0:
        try:
            value = work()
        except (SmidgenError, OSError) as problem:
            error = problem
    other, error = world.comm.bcast((value if send else None, portable(error)))
    if error is not None:
        raise error
    return value if world.rank == 0 else other


def on_all(work: Callable[[], object]):
    """What work() gives on each rank. The exception of one is raised by all, and they go on together."""
    value, error = None, None
    try:
        value = work()
    except (SmidgenError, OSError) as problem:
        error = problem
    found = [error] if world is None else world.comm.allgather(portable(error))
    if (first_of := next((one for one in found if one is not None), None)) is not None:
        raise first_of
    return value


def portable(error):
    """The exception, or one of its base with the same words where it cannot be sent."""
    try:
        pickle.loads(pickle.dumps(error))
        return error
    except Exception:
        return UsageError(str(error))


def same(number: float) -> float:
    """That of rank 0."""
    return number if world is None else world.comm.bcast(number)


def anywhere(asked: Callable[[], bool]) -> Callable[[], bool]:
    """Whether one of the ranks says yes."""
    return asked if world is None else lambda: world.comm.allreduce(bool(asked()), world.mpi.LOR)


@contextlib.contextmanager
def first_first():
    """Rank 0 goes before the others, which find what it made, or fail as it did."""
    if world is not None and world.rank:
        world.comm.Barrier()
    try:
        yield
    finally:
        if world is not None and world.rank == 0:
            world.comm.Barrier()


def check(library) -> None:
    """Raises UsageError where a model was linked with another MPI than mpi4py uses."""
    import ctypes
    if world is None or not hasattr(library, "MPI_Get_library_version"):
        return
    text, size = ctypes.create_string_buffer(world.mpi.MAX_LIBRARY_VERSION_STRING), ctypes.c_int(0)
    library.MPI_Get_library_version(text, ctypes.byref(size))
    mine, other = text.value.decode(errors="replace"), world.mpi.Get_library_version()
    if mine.strip("\0 \n") != other.strip("\0 \n"):
        raise UsageError(f"mpicc links {short(mine)}, but mpi4py uses {short(other)}; both must use the MPI library of mpirun")


def short(version: str) -> str:
    return version.partition(",")[0].partition("\n")[0]
