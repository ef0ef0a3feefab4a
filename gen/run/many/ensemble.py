"""Many starts, or many values of parameters, of one model at once: each member with the bits that it has alone.

    found = smidgen.ensemble(spec, start=w, parameters={"I3": np.linspace(3, 4, 1000)}, h=0.1, steps=1000)
    found.w, found.failures         # the end of each, and the members that stopped before it
"""
from __future__ import annotations

import ctypes
import os
import threading
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from ...build.binary import build_library
from ...errors import RunError, UsageError
from ...language import limits
from ...public import few, public
from ...read.names import plural
from ...read.shipped import SpecLike, spec_or_name
from ..step.evaluated import Evaluated
from ..step.library import functions, loaded, packed
from ..step.noise import noise_of
from ..step.pace import Pace
from ..step.prepared import Prepared, checked_tolerance
from ..step.real import real_array
from ..step.start import find_start, state_at, wrong_start
from ..step.status import NO_MEMORY, STATUS, Status
from ..settings import number, settle, whole

BLOCK, LEAST = 256, 32      # members that one call steps: few enough to share out and to stop between, at least some registers full
FIRST = 4096                # steps of sites in the first call of a thread, before it knows how long they take: some ms, of slow ones 0.1 s
MEMORY = 2 ** 31            # bytes of outputs
OUTPUTS = ("states", "energy")


@dataclass(frozen=True)
class Ensemble:
    """The result of `smidgen.ensemble`. Members are numbered from 0.

    :ivar t: the times of the outputs, shape (outputs,); the last one is the end.
    :ivar w: the states at the end, or before the step that failed, shape (members, sites, 3).
    :ivar states: the states at the outputs, shape (outputs, members, sites, 3). `energy`: the energies, shape (outputs, members). None if
        not requested. A member that failed keeps its last value.
    :ivar status: 0 or the status with which a member failed, shape (members,). `steps`: the steps that it took, shape (members,).
    :ivar failures: a message for each member that failed.
    :ivar lanes: how many members were stepped at once in vector registers; 1 if they were stepped one by one.
    """
    t: np.ndarray
    w: np.ndarray
    status: np.ndarray
    steps: np.ndarray
    states: np.ndarray | None = None
    energy: np.ndarray | None = None
    failures: dict = field(default_factory=dict)
    lanes: int = 1

    def __repr__(self) -> str:
        how = f"{self.lanes} at a time" if self.lanes > 1 else "one by one"
        failed = f"; failed: {few(map(str, self.failures))}" if self.failures else ""
        return f"<Ensemble of {len(self.w)} members, {plural(self.w.shape[1], 'site')} each, to t = {self.t[-1]:.10g}, {how}{failed}>"


@public
@spec_or_name
def ensemble(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, method: str | None = None,
             solver: str | None = None, h: float | str | None = None, steps: int | None = None, time: float | str | None = None,
             every: int | None = None, what: Iterable[str] | None = None, effects: Iterable[str] | None = None,
             parameters: Mapping[str, object] | None = None, seed: int | None = None, native: bool | None = None,
             tolerance: float | None = None, fast: bool = False, threads: int | None = None, t0: float = 0.0) -> Ensemble:
    """Run a model from many starts, or with many values of its parameters, and return an Ensemble.

    Arguments that are not given are taken from the run in the spec. Those not listed here are as for `run`; formulas take the parameters
    of member 0.

    :param start: an array of shape (members, sites, 3), or (members, 3) for a single site; or the name of a start, for all members.
    :param parameters: values by name, as for `run`; with an additional first dimension, (members,) or (members, size), one for each
        member. Integer and fixed parameters are the same for all members.
    :param what: "states", "energy" or both; at the end, or at the start and every `every` steps.
    :param every: the number of steps between outputs.
    :param native: whether to compile for this processor; None: if members are stepped side by side in vector registers.
    :param fast: like `native`, and with fused multiply-add instructions, which change the last bits.
    :param seed: the seed of a random start and of thermal noise, which is different for each member: `start(..., seed=seed, member=k)`.
    :param threads: the number of threads; by default one per processor.
    :param t0: the time of the start.
    :raises UsageError: for an argument that does not fit.
    :raises MissingTool: if there is no C compiler. BuildError if it fails; RunError if there is not enough memory.

    Each member has the same bits as if it were run alone (with `fast`: other last bits). A member that cannot start, or whose step fails, keeps its state and is listed
    in `failures`; the others continue.
    """
    parameters, given = dict(parameters or {}), start if isinstance(start, str) or start is None else _stacked(start)
    own = {name: value for name, value in parameters.items() if _is_own(spec, name, value)}
    members = _members(None if given is None or isinstance(given, str) else given, own)
    first = {**parameters, **{name: np.asarray(value)[0] for name, value in own.items()}}
    s = settle(spec, run, start=given if isinstance(given, str) else None, seed=seed, method=method, solver=solver, h=h, steps=steps, time=time,
               every=1 if every is None else every, what=(), effects=effects, parameters=first, tolerance=tolerance, fast=fast)
    prepared = s.prepared(spec)
    noise = noise_of(prepared.scene, s.h, seed)
    w = _states(prepared, s.start if given is None else given, own, members, seed)
    built = build_library(prepared.scene, s.method, s.solver, "double", native, ("ensemble",), fast=s.fast, plan=prepared.plan)
    rows = _rows(s.steps, None if every is None else s.every)
    stepped = Stepped(prepared, built, own, w, number(float(t0), {}, "t0"), s.h, checked_tolerance(s.tolerance), _threads(threads), noise)
    try:
        return stepped.outputs(rows, _chosen(what or (), len(rows), w.nbytes))
    finally:
        stepped.close()


class Stepped:
    """The members in C, and the threads that step them."""

    def __init__(self, prepared, built, own, w, t0, h, tolerance, threads, noise=None):
        self.c, self.w, self.t0, self.h, self.threads = functions(loaded(built.binary), prepared.scene.name), w, t0, h, threads
        self.members, self.pace, self.stop = len(w), threading.local(), threading.Event()
        self.block = max(LEAST, min(BLOCK, -(-self.members // (threads * LEAST)) * LEAST))
        self.prepared, self.own = prepared, _known(prepared, own)
        scalars, arrays = _parameters(prepared.numbers, self.own, self.members)
        pointers = (ctypes.c_void_p * max(1, len(arrays)))(*(a.ctypes.data for a in arrays))
        self.keep = scalars, arrays, pointers
        self.at = self.c.ensemble_new(scalars.ctypes.data, pointers, bool(self.own), self.members, w.ctypes.data, t0, h, tolerance)
        if not self.at:
            raise RunError(f"an ensemble of {self.members} members: {NO_MEMORY[1]}", -1)
        if noise:
            self.c.ensemble_set_seed(self.at, noise[0])
        self.began = (self.reports()[1] == 0).astype(np.uint8)

    def close(self):
        """Give the memory back."""
        if self.at:
            self.c.ensemble_free(self.at)
        self.at = None

    def outputs(self, rows, what) -> Ensemble:
        """The members stepped to each of `rows`, numbers of steps from the start."""
        states = np.empty((len(rows), *self.w.shape)) if "states" in what else None
        energy = np.empty((len(rows), self.members)) if "energy" in what else None
        done = 0
        for k, row in enumerate(rows):
            self.advance(row - done)
            done = row
            if states is not None:
                states[k] = self.state()
            if energy is not None:
                self.c.ensemble_energies(self.at, self.began.ctypes.data, energy[k].ctypes.data)
        return self.result(np.array([self.t0 + row * self.h for row in rows]), states, energy)

    def result(self, t, states, energy) -> Ensemble:
        count, status, site, reached = self.reports()
        failures = {int(k): self.why(int(status[k]), int(count[k]), int(site[k]), float(reached[k])) if self.began[k] else self.refused(int(k), int(status[k]))
                    for k in np.flatnonzero(status)}
        return Ensemble(t, self.state(), status, count, states, energy, failures, self.c.ensemble_lanes())

    def reports(self) -> tuple:
        """(steps, statuses, sites, reached) of all members."""
        found = np.empty(self.members, np.int64), np.empty(self.members, np.intc), np.empty(self.members, np.int64), np.empty(self.members)
        self.c.ensemble_reports(self.at, *(one.ctypes.data for one in found))
        return found

    def refused(self, k: int, status: int) -> str:
        """Why member k cannot begin, and where."""
        return f"cannot start: {': '.join(STATUS[status])}{wrong_start(_numbers_of(self.prepared, self.own, k), self.w[k])}"

    def why(self, status: int, count: int, site: int, reached: float) -> str:
        where = f" at site {site}" if site >= 0 and self.w.shape[1] > 1 else ""
        far = f"; from this state, steps exist up to |h| = {abs(self.h) * reached:.6g}" if status == Status.NO_SOLUTION and 0 < reached <= 1 else ""
        return f"step {count + 1} from t = {self.t0 + count * self.h:.12g}: {': '.join(STATUS[status])}{where}{far}"

    def state(self) -> np.ndarray:
        """(members, sites, 3); of members that could not begin what was given."""
        found = self.w.copy()
        self.c.ensemble_states(self.at, self.began.ctypes.data, found.ctypes.data)
        return found

    def advance(self, count: int) -> None:
        """`count` steps of all members, block by block."""
        blocks = range(0, self.members, self.block)
        if count == 0:
            return
        if self.threads == 1 or len(blocks) == 1:       # a thread takes a tenth of a millisecond to start
            for first in blocks:
                self.advance_block(first, count)
            return
        with ThreadPoolExecutor(self.threads) as pool:
            try:
                list(pool.map(lambda first: self.advance_block(first, count), blocks))
            except BaseException:
                self.stop.set()         # Ctrl-C: each thread ends with the call that it is in
                raise

    def advance_block(self, first: int, left: int) -> None:
        if not hasattr(self.pace, "own"):
            self.pace.own = Pace(max(1, FIRST // (self.block * self.w.shape[1])))
        members = min(self.block, self.members - first)
        while left > 0 and not self.stop.is_set():
            asked = min(left, self.pace.own.size)
            self.pace.own.timed(lambda k: self.c.ensemble_steps(self.at, first, members, k), asked)
            left -= asked


def _stacked(start) -> np.ndarray:
    try:
        w = np.array(real_array(start, float, "the start"), order="C")
    except UsageError:
        raise UsageError("the start must be an array of shape (members, sites, 3), or a name") from None
    if w.ndim == 2:
        w = w[:, None, :]
    if w.ndim != 3 or w.shape[2] != 3 or not len(w):
        raise UsageError(f"the start must have shape (members, sites, 3), not {np.shape(start)}")
    return w


def _is_own(spec, name: str, value) -> bool:
    """Is there a value for each member? Checks those."""
    p = next((p for p in spec.parameters if p.name == name), None)
    try:
        dimensions = np.ndim(value)
    except ValueError:
        raise UsageError(f"'{name}' must be a number, or an array with a value for each member") from None
    if p is None or dimensions != (2 if p.kind == "array" else 1):
        return False
    if p.kind == "int" or p.fixed:
        raise UsageError(f"'{name}' must be the same for all members: it is {'an integer parameter' if p.kind == 'int' else 'fixed when the model is compiled'}")
    array = real_array(value, float, f"'{name}', one value for each member,")
    bad = ~(np.isfinite(array) & (np.abs(array) <= limits.LARGEST) & ((array == 0) | (np.abs(array) >= limits.SMALLEST)))
    if bad.any():
        raise UsageError(f"'{name}' of member {int(np.argwhere(bad)[0][0])} is {array[bad][0]}: it must be 0 or a number between "
                         f"{limits.SMALLEST:g} and {limits.LARGEST:g}")
    return True


def _members(given, own) -> int:
    """How many there are, by the starts and the values, which must agree."""
    found = {**({} if given is None else {"starts": len(given)}), **{f"'{name}'": len(value) for name, value in own.items()}}
    if len(set(found.values())) > 1:
        raise UsageError("the numbers of members differ: " + ", ".join(f"{name}: {count}" for name, count in found.items()))
    members = next(iter(found.values()), 1)
    if not 1 <= members <= limits.MEMBERS:
        raise UsageError(f"an ensemble must have from 1 to {limits.MEMBERS} members, not {members}")
    return members


def _known(prepared: Prepared, own: dict) -> dict:
    """Of the values of members those that the scene takes."""
    return {p.name: own[p.name] for p in prepared.scene.parameters if p.name in own}


def _numbers_of(prepared: Prepared, own: dict, k: int) -> Evaluated:
    """The numbers of member k."""
    return prepared.with_parameters({name: value[k] for name, value in _known(prepared, own).items()}).numbers if own else prepared.numbers


def _states(prepared: Prepared, start, own, members, seed=None) -> np.ndarray:
    """The start of each member, shape (members, sites, 3)."""
    if isinstance(start, np.ndarray):
        total = sum(count for _, count in prepared.numbers.places.values())
        if start.shape[1] != total:
            raise UsageError(f"a state of {prepared.scene.name} has {total} sites, but the starts have {start.shape[1]}")
        return start
    find_start(prepared.spec, start)
    w = [state_at(_numbers_of(prepared, own, k), start, seed) for k in (range(members) if own else [0])]
    return np.ascontiguousarray(np.broadcast_to(np.array(w), (members, *w[0].shape)))


def _parameters(numbers: Evaluated, own, members):
    """(scalars, arrays) as the C takes them, one set for all members or one after the other."""
    scalars, arrays = packed(numbers)
    if not own:
        return scalars, arrays
    free = [p for p in numbers.spec.parameters if not p.fixed]
    names = [p.name for p in free if p.kind != "array"]
    table = np.tile(scalars[:len(names)], (members, 1))
    for k, name in enumerate(names):
        if name in own:
            table[:, k] = own[name]
    sets = [of_members(own[p.name], members, len(one)) if p.name in own else one for p, one in zip((p for p in free if p.kind == "array"), arrays)]
    return np.ascontiguousarray(table), [one[k] if one.ndim == 2 else one for k in range(members) for one in sets]


def of_members(given, members: int, size: int) -> np.ndarray:
    """The arrays of all members, shape (members, size); a single number of a member stands for as many equal ones."""
    return np.ascontiguousarray(np.broadcast_to(np.asarray(given, float), (members, size)))


def _rows(steps: int, every: int | None) -> list:
    """After how many steps there is an output; the end is one."""
    return [steps] if every is None else [*range(0, steps, every), steps]


def _chosen(what, rows: int, size: int) -> tuple:
    """Names of outputs, checked; what they take must fit into MEMORY."""
    for name in what:
        if name not in OUTPUTS:
            raise UsageError(f"an ensemble has no output '{name}'; there are: {', '.join(OUTPUTS)}")
    if "states" in what and rows * size > MEMORY:
        raise UsageError(f"the outputs take {rows * size / 2 ** 30:.1f} GiB of memory: use a larger every, or fewer members")
    return what


def _threads(threads) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if whole(threads, "threads") < 1:
        raise UsageError("threads must be at least 1")
    return int(threads)
