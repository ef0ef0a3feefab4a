"""A compiled model of which every rank of MPI stores its own part alone (runtime/lattice/smg_row_parts.h)."""
from __future__ import annotations

import ctypes
import math
import mmap

import numpy as np

from ... import ranks
from ...build.binary import build_library
from ...errors import RunError, UsageError
from .grid import grid_flags
from .integrator import Integrator
from .noise import noise_of
from .prepared import Prepared, checked_tolerance
from .saved import Saved
from .start import part_of_state
from .status import NO_MEMORY, STATUS, Status

FEATURE = "distributed"
WINDOW = 1 << 18        # sites whose vectors are found, or saved, at a time


def divided(prepared: Prepared, real: str, native: bool | None, fast: bool, threads: int | None) -> Divided:
    """Compile it, or find it in the cache. Raises UsageError for a model that cannot be divided."""
    with ranks.first_first():
        built = build_library(prepared.scene, prepared.method, prepared.solver, real, native, (FEATURE,), fast=fast,
                              threads=threads is not None, ranks=ranks.count() > 1, grid=grid_flags(prepared), plan=prepared.plan)
    model = Divided(prepared, built, threads)
    ranks.check(model._library)
    return model


class Numbers:
    """An array of zeros that takes no memory where it is not touched."""

    def __init__(self, size: int, kind: np.dtype):
        lazy = getattr(mmap, "MAP_NORESERVE", 0)
        self.pages = mmap.mmap(-1, max(1, size * kind.itemsize), flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | lazy)
        self.array = np.frombuffer(self.pages, kind, size)

    def forget(self) -> None:
        """All numbers are 0 again, and take no memory."""
        self.pages.madvise(mmap.MADV_DONTNEED)


class Divided(Integrator):
    """An Integrator whose `w` is None: this rank has the sites from `first` to `end` - 1, as `part` shows them.

    All ranks make the same calls."""
    first: int
    end: int

    def start(self, w=None, t0: float = 0.0, h: float | None = None, seed: int | None = None, tolerance: float | None = None,
              member: int = 0) -> Divided:
        """Start a trajectory from a start of the spec, by its name, as `Integrator.start` does."""
        noise = noise_of(self.scene, h, seed, member)
        self.close()
        self._now(h=float(h), t0=float(t0), count=0)
        part = np.zeros(2, np.int64)
        self._c.part_of(self._passed[0].ctypes.data, self._passed[2], part.ctypes.data)
        self._now(first=int(part[0]), end=int(part[1]))
        if ranks.count() > 1 and self.end - self.first == self.sites:
            raise UsageError(f"the lattice is too small to be divided among {ranks.count()} ranks, or its shape does not allow it: "
                             "use fewer, or run without --distributed")
        self._begin(w, seed, checked_tolerance(tolerance))
        if noise:
            self._c.set_seed(self._state, *noise)
        return self

    def _begin(self, start, seed, tolerance: float) -> None:
        """The vectors of this rank's sites, window by window."""
        given = Numbers(3 * self.sites, self.real)
        w = given.array.reshape(-1, 3)
        for first, count in self.windows():
            w[first:first + count] = part_of_state(self.prepared.numbers, start, seed, first, count)
        status = ctypes.c_int(0)
        self._state = self._c.new(self._passed[0].ctypes.data, self._passed[2], w.ctypes.data, self.t0, self.h, ctypes.byref(status))
        self._status = status.value
        if not self._state:
            name, meaning = STATUS.get(status.value, NO_MEMORY)
            hint = "; is h too large for steps by rows?" if status.value == Status.BAD_PARAMETER else ""
            raise RunError(f"{self.name} cannot start: {name}: {meaning}{hint}", status.value)
        self._c.set_tolerance(self._state, tolerance)

    def windows(self):
        """(first, count) of this rank's sites, some at a time."""
        for first in range(self.first, self.end, WINDOW):
            yield first, min(WINDOW, self.end - first)

    @property
    def part(self) -> np.ndarray:
        """The vectors of this rank's sites, shape (end - first, 3), as they stand in the memory of C until the next call; read-only."""
        self._started()
        size = 3 * (self.end - self.first)
        at = self._c.part_w(self._state) + 3 * self.first * self.real.itemsize
        found = np.frombuffer((ctypes.c_char * (size * self.real.itemsize)).from_address(at), self.real) if size else np.empty(0, self.real)
        found.flags.writeable = False
        return found.reshape(-1, 3)

    def advance(self, count: int) -> int:
        """Take up to `count` steps; return the number of steps that succeeded."""
        self._started()
        self._gather_threads()
        done = ctypes.c_int64(0)
        self._status = self._c.steps(self._state, count, ctypes.byref(done))
        self._now(count=self.count + done.value)
        return done.value

    def save_parts(self):
        """(position, numbers) of this rank's part of what `Integrator.save` gives, window by window; the first rank has the head.

        All ranks call it together; that no other rank waits for one that fails later, all messages are exchanged before it returns.
        """
        if ranks.grid is not None and ranks.count() > 1:
            self._c.part_save(self._state, self.first, self.first, None)    # from blocks to layers
        return self._saved_parts()

    def _saved_parts(self):
        size, n3 = self._c.savesize(self._state), 3 * self.sites
        head, out = size % n3, Numbers(self._c.savesize(self._state), self.real)
        for first, count in self.windows():
            self._c.part_save(self._state, first, first + count, out.array.ctypes.data)
            if first == 0:
                yield 0, out.array[:head]
            for begin in range(head + 3 * first, size, n3):
                yield begin, out.array[begin:begin + 3 * count]
            out.forget()

    def restore(self, saved: np.ndarray) -> Divided:
        """As `Integrator.restore`; of what was saved each rank reads its part."""
        self._started()
        fits = saved.shape == (self._c.savesize(self._state),)
        status = self._c.restore(self._state, saved.ctypes.data) if fits else Status.BAD_PARAMETER
        if status:
            raise RunError(f"not a saved state of {self.name}: {STATUS[status][1]}", status)
        head = Saved.of(saved)
        self._now(t0=head.t0, h=head.h, count=head.count)
        self._status = 0
        return self

    def _taken(self) -> None:
        """Nobody writes to the state."""
        self._started()

    def _whole(self, *_, **__):
        raise UsageError("the state is divided among ranks: use `part`")

    state = save = casimirs = field = tangent = push_forward = outputs = energy = _whole

    def _rate(self, site: int) -> float:
        return math.nan

    def _varies(self) -> str:
        return ""
