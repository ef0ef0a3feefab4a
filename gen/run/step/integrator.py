"""A compiled model in Python: step numpy arrays in place.

    spec = smidgen.load("top.toml")
    top = smidgen.build(spec)
    top.start("tilted", h=0.1)
    top.steps(100)
    top.t, top.w                # the time, and the state: an array of shape (sites, 3)
"""
from __future__ import annotations

import ctypes
import math
from collections.abc import Iterable, Mapping

import numpy as np

from ... import ranks
from ...build.binary import Built, build_library
from ...errors import RunError, UsageError
from ...language.spec import Spec
from ...methods import METHODS
from ...public import ReadOnly, few, public
from ...read.shipped import SpecLike, spec_or_name
from .block import Block
from .library import functions, loaded, loaded_with_threads, packed, passed
from .noise import noise_of
from .prepared import Prepared, asked, checked_threads, checked_tolerance, choose, prepare
from .saved import Saved
from .start import find_start, state_at, wrong_start
from .status import NO_MEMORY, REFUSED, STATUS, Status, advice, why


@public
@spec_or_name
def build(spec: SpecLike, run: str | None = None, *, method: str | None = None, solver: str | None = None, effects: Iterable[str] | None = None,
          parameters: Mapping[str, object] | None = None, real: str = "double", native: bool | None = None, fast: bool = False,
          threads: int | None = None, features: Iterable[str] = ()) -> Integrator:
    """Compile `spec` (or take the build from the cache) and return an Integrator.

    run: of the spec, by default its first. In place of what that run says:
    method: one of those that `smidgen list --methods` shows; solver: "auto", "newton", "rotation" or "plain"; effects: names of those
    to keep; parameters: values by name, in the units of the spec (a number, or a sequence for an array).
    real: "double" or "long double"; native: compile for this processor (None: where the
    model has vectors of lanes, whose bits are the same); fast: native, and products and sums in one operation; threads: how many may
    share a step, with OpenMP and the same bits; features: what the C shall have beyond the step, such as "tangent".
    Raises UsageError for a name that is not known, a value that does not fit, threads where steps have none,
    MissingTool without a C compiler, BuildError when it fails.
    """
    one = asked(spec, run, method, solver, effects, parameters)
    return compiled(prepare(spec, one.method, one.effects, dict(one.parameters), one.solver), real, native, features, fast, threads)


def compiled(prepared: Prepared, real: str = "double", native: bool | None = None, features: Iterable[str] = (), fast: bool = False,
             threads: int | None = None) -> Integrator:
    """The same of what is prepared."""
    choose("real", real, ("double", "long double"))
    threads = checked_threads(threads)
    with ranks.first_first():
        built = build_library(prepared.scene, prepared.method, prepared.solver, real, native, features, fast=fast,
                              threads=threads is not None, ranks=ranks.count() > 1, plan=prepared.plan)
    model = Integrator(prepared, built, threads)
    ranks.check(model._library)
    return model


class Integrator(ReadOnly):
    """One model with its parameter values, compiled; at most one trajectory at a time.

    name, method, solver, threads: as asked for; `notes`: what the generator chose. `w` is the state,
    shape (sites, 3); it is the same array after every step, and the caller's own if
    `start` was given one of that shape and type. What is written into it (`top.w[:] = ..`) is the state from
    the next call on, at the same time: the predictor and the compensation then begin anew, and UsageError
    says what is wrong with a w that no start may be, such as one off its sphere. h: the step, nan before `start`; t0: the time
    of the start; count: the steps taken since; times in the unit that the spec's energy implies.
    parameters: their values; prepared: these and the rest of what steps are made of, evaluated; families: name -> (first site, number of sites); columns:
    the names of what `values` gives. All of them are only read: ReadOnlyError says what to call.
    """
    prepared: Prepared
    spec: Spec
    scene: Spec
    built: Built
    name: str
    method: str
    solver: str
    notes: dict
    threads: int | None
    parameters: dict
    families: dict[str, tuple[int, int]]
    real: np.dtype
    columns: list[str]
    h: float
    t0: float
    count: int
    w: np.ndarray | None
    INSTEAD = {"": "smidgen.build(spec, ...) makes another model", "count": "steps(count) takes steps"} | dict.fromkeys(
        ("h", "t0", "t", "w"), "start(w, t0=..., h=...) begins anew from any state, time and step") | {
            "w": "w[:] = ... writes into it, start(w, t0=..., h=...) begins anew from any state, time and step",
            "parameters": "set_parameters({name: value}) gives other values from the next step on"}

    def __init__(self, prepared: Prepared, built: Built, threads: int | None = None):
        self.prepared, self.built = prepared, built
        self.spec, self.scene, self.method, self.solver = prepared.spec, prepared.scene, prepared.method, prepared.solver
        self.name, self.notes, self.threads = self.scene.name, built.notes, threads
        self.parameters, self.families = prepared.numbers.parameters, prepared.numbers.places
        self.real = np.dtype(np.longdouble if built.real == "long double" else np.float64)
        self._library = loaded(built.binary) if threads is None else loaded_with_threads(built.binary)
        self._c = functions(self._library, self.name)
        self._state, self._passed = None, passed(*packed(prepared.numbers))
        self.h, self.t0, self.count, self.w = math.nan, 0.0, 0, None
        self.columns = value_columns(self.scene)

    def __repr__(self) -> str:
        at = f"step {self.count}, t = {self.t:.10g}, h = {self.h:.10g}" if self._state else "not started"
        return f"<Integrator {self.name}: {self.method}, {self.sites} sites of {few(self.families)}; {at}>"

    def _now(self, **facts) -> None:
        """Where the trajectory is; the one way past ReadOnly."""
        vars(self).update(facts)

    @property
    def sites(self) -> int:
        """Number of sites: the state has shape (sites, 3)."""
        return sum(count for _, count in self.families.values())

    @public
    def start(self, w=None, t0: float = 0.0, h: float | None = None, seed: int | None = None, tolerance: float | None = None,
              member: int = 0) -> Integrator:
        """Begin a trajectory at time t0 with step h (negative: backward).

        w: an array of shape (sites, 3), which the steps change in place (of two integrators with one array each goes on
        from what the other has made of it), the name of a start of the spec, or None for its only one; seed replaces the seed of random starts, and is that of
        thermal noise (None: 0), of which each member has its own; tolerance: of a
        step, as part of the largest component of w, where its iterations end or its step control
        aims (None: to round-off, and what step control has by default). Raises
        UsageError for a wrong shape, a start off its sphere or no h, RunError for what the C
        refuses.
        """
        if h is None or not math.isfinite(h) or h == 0:
            raise UsageError(f"a step h is needed: a finite number, not 0; it is {h}")
        noise = noise_of(self.scene, h, seed, member)
        self.close()
        self._now(w=self._array(w, seed), h=float(h), t0=float(t0), count=0)
        self._new(checked_tolerance(tolerance))
        if noise:
            self._c.set_seed(self._state, *noise)
        return self

    @public
    def set_parameters(self, values: Mapping[str, object]) -> Integrator:
        """Other values of real parameters, by name, from the next step on: a torque, a field that is switched on. The other parameters stay, as
        do w, time, count, h, tolerance and the seed of noise; the steps are those of a start here with the new values.

        Raises UsageError for a name that is not known, an integer or a fixed parameter and a value that does not fit, RunError for what the C
        refuses, such as another radius; all is then as it was.
        """
        for p in self.scene.parameters:
            if p.name in values and (p.kind == "int" or p.fixed):
                raise UsageError(f"'{p.name}' stays: it is {'an integer' if p.kind == 'int' else 'fixed, compiled in'}; build another model")
        prepared = self.prepared.with_parameters(values)
        given = passed(*packed(prepared.numbers))
        if self._state:
            self._taken()
            status = self._c.set_parameters(self._state, given[0].ctypes.data, given[2])
            if status:
                raise RunError(f"{self.name} keeps its parameters: {': '.join(STATUS[status])}", status)
        self._passed = given
        self._now(prepared=prepared, parameters=prepared.numbers.parameters)
        return self

    @property
    def halved(self) -> int:
        """Steps since the start that were taken as two of h/2 with the same noise, since there was none of h."""
        return self._c.halved(self._state) if self._state and self.scene.heated else 0

    def step(self) -> Integrator:
        """One step; w is changed in place. Raises RunError, then w is as before."""
        return self.steps(1)

    def steps(self, count: int) -> Integrator:
        """`count` steps. On failure w is the state before the step that failed."""
        if self.advance(count) < count:
            self._fail(self._status)
        return self

    def advance(self, count: int) -> int:
        """Up to `count` steps; returns how many succeeded."""
        self._started()
        if count < 0:
            raise UsageError("a number of steps from 0 up; a negative h runs backward")
        self._gather_threads()
        done = ctypes.c_int64(0)
        status = self._c.go(self._state, self.w.ctypes.data, count, ctypes.byref(done))
        if status >= REFUSED:
            self._refuse(status - REFUSED)
        self._status = status
        self._now(count=self.count + done.value)
        return done.value

    def outputs(self, first: int, every: int, block: Block, begin: int, count: int) -> int:
        """Up to `count` outputs into `block` from its row `begin` on: one after `first` steps, then one every `every` steps.

        Returns how many there are; fewer than `count` where a step failed, which `failure` tells.
        """
        self._taken()
        self._gather_threads()
        done = ctypes.c_int64(0)
        self._status = self._c.outputs(self._state, first, every, count, ctypes.byref(block.addressed(begin)), ctypes.byref(done))
        self._c.state(self._state, self.w.ctypes.data)
        self._now(count=self._c.count(self._state))
        return done.value

    def _gather_threads(self) -> None:
        """How many there are is a property of the thread that calls, in OpenMP."""
        if self.threads is not None:
            self._library.omp_set_num_threads(self.threads)

    def failure(self) -> RunError | None:
        """The error of the last step, or None when it succeeded."""
        try:
            self._fail(self._status)
        except RunError as error:
            return error

    @property
    def t(self) -> float:
        """The time t0 + count*h."""
        self._started()
        return self._c.time(self._state)

    def state(self, out=None) -> np.ndarray:
        """A copy of the state, or the state written into `out` of shape (sites, 3)."""
        self._taken()
        out = np.empty((self.sites, 3), self.real) if out is None else out
        self._c.state(self._state, out.ctypes.data)
        return out

    def report(self) -> dict:
        """Of the last step: iterations, residual (in units of w), site and partner (-1: none), and
        reached, the part of h up to which its branch of solutions was followed (0: it was not)."""
        self._started()
        found = (ctypes.c_int(0), ctypes.c_double(0), ctypes.c_int64(-1), ctypes.c_int64(-1), ctypes.c_double(0))
        self._c.report(self._state, *map(ctypes.byref, found))
        return dict(zip(("iterations", "residual", "site", "partner", "reached"), (f.value for f in found)))

    def save(self) -> np.ndarray:
        """All that decides later steps, to go on with the same bits: `saved.Saved` reads it."""
        self._taken()
        out = np.empty(self._c.savesize(self._state), self.real)
        self._c.save(self._state, out.ctypes.data)
        return out

    def restore(self, saved: np.ndarray) -> Integrator:
        """Be where `save` was called, after a start with the same parameter values.

        Raises RunError for what no `save` of this model wrote; the state is then as it was.
        """
        self._started()
        saved = np.ascontiguousarray(saved, self.real)
        size = self._c.savesize(self._state)
        status = self._c.restore(self._state, saved.ctypes.data) if saved.shape == (size,) else Status.BAD_PARAMETER
        if status:
            raise RunError(f"no saved state of {self.name}: {STATUS[status][1]}", status)
        head = Saved.of(saved)
        self._now(t0=head.t0, h=head.h, count=head.count)
        self._status = 0
        self._c.state(self._state, self.w.ctypes.data)
        return self

    def values(self, out=None) -> np.ndarray:
        """All conserved quantities and observables, in the order of `columns`."""
        self._taken()
        out = np.empty(len(self.columns), self.real) if out is None else out
        self._c.values(self._state, out.ctypes.data)
        return out

    def casimirs(self, out=None) -> np.ndarray:
        """|w|^2, or C(w) of a Nambu factor, for each site: shape (sites,)."""
        self._taken()
        out = np.empty(self.sites, self.real) if out is None else out
        self._c.casimirs(self._state, out.ctypes.data)
        return out

    def energy(self, w=None, t: float | None = None) -> float:
        """H(t, w), by default of the present state and time; once there is a trajectory."""
        self._started()
        w = self._present() if w is None else self._given(w)
        out = np.empty(1, self.real)
        self._c.energy(self._state, self.t if t is None else t, w.ctypes.data, out.ctypes.data)
        return out[0]

    def field(self, w=None, t: float | None = None) -> np.ndarray:
        """b = (1/kappa) dH/dw of shape (sites, 3), by default of the present state; once there is a trajectory."""
        self._started()
        w, out = self._present() if w is None else self._given(w), np.empty((self.sites, 3), self.real)
        self._c.field(self._state, self.t if t is None else t, w.ctypes.data, out.ctypes.data)
        return out

    def tangent(self, v) -> np.ndarray:
        """Carry tangent vectors through the step just taken: dw before it -> dW after it, in place.

        v: (sites, 3) or (columns, sites, 3); an array that C can work on is changed in place, and it comes
        back. The step is W = w + h X(m), so that on spheres (I - K) dW = (I + K) dw with K = (h/2) DX(m) P';
        where the leaf moves with w, on R^3 and Nambu factors, its derivative is in it. Raises UsageError
        before the first step, for a wrong shape and without the feature "tangent", RunError for what the C
        refuses, before the first step after w was written too; v is then as it was.
        """
        if self.count == 0 and self._state:
            raise UsageError("no step taken yet: the tangent map is that of the step just taken")
        return self._carry(v, 0)

    def push_forward(self, v, count: int) -> np.ndarray:
        """`count` steps, tangent vectors carried through each: v of shape ([columns,] sites, 3), in place.

        Where a step or its tangent map fails, RunError: w is the state before the step that failed, and v
        is as it was before the call.
        """
        if count < 0:
            raise UsageError("a number of steps from 0 up; a negative h runs backward")
        return self._carry(v, count) if count else v

    def _carry(self, v, count):
        self._taken()
        if not hasattr(self._c, "tangent"):
            raise UsageError("no tangent map in this build: build(..., features=('tangent',))")
        array = _real_array(v, self.real)
        if array.ndim not in (2, 3) or array.shape[-2:] != (self.sites, 3):
            raise UsageError(f"tangent vectors of {self.name} have shape ({self.sites}, 3) or "
                             f"(columns, {self.sites}, 3), not {np.shape(v)}")
        carried, done = array.copy(), ctypes.c_int64(0)
        status = self._c.tangent(self._state, carried.ctypes.data, array.size // (3 * self.sites), count,
                                 ctypes.byref(done))
        self._now(count=self.count + done.value)
        self._c.state(self._state, self.w.ctypes.data)
        self._status = status if status < REFUSED else 0
        self._fail(self._status)
        if status:
            name, meaning = STATUS.get(status - REFUSED, NO_MEMORY)
            if status - REFUSED == Status.BAD_PARAMETER:
                meaning = "no step taken since the state was written or restored"
            raise RunError(f"tangent map of step {self.count}: {name}: {meaning}", status - REFUSED, self.count,
                           site=self.report()["site"])
        if not array.flags.writeable:
            return carried
        array[...] = carried
        return array

    def close(self) -> None:
        """Give the memory of the trajectory back."""
        if self._state:
            self._c.free(self._state)
        self._state = None

    def __del__(self):
        if getattr(self, "_state", None):
            self.close()

    def _started(self):
        if not self._state:
            raise UsageError("no trajectory yet: call start(w, h=...) first")

    def _taken(self) -> None:
        """What has been written into w is the state."""
        self._started()
        status = self._c.take(self._state, self.w.ctypes.data)
        if status:
            self._refuse(status - REFUSED)

    def _present(self) -> np.ndarray:
        """w, the state."""
        self._taken()
        return self.w

    def _refuse(self, status: int) -> None:
        """Nothing is done with a w that cannot be the state."""
        raise UsageError(f"what was written into w of {self.name} cannot be its state: {STATUS[status][0]}"
                         f"{wrong_start(self.prepared.numbers, self.w)}; write another w")

    def _array(self, w, seed):
        if w is None or isinstance(w, str):
            find_start(self.spec, w)
            w = state_at(self.prepared.numbers, w, seed)
        return self._given(w)

    def _given(self, w):
        """`w` itself if C can work on it, else a copy. Raises UsageError for its shape."""
        try:
            array = np.ascontiguousarray(w, dtype=self.real)
        except (TypeError, ValueError):
            raise UsageError("a state is an array of numbers") from None
        if array.shape != (self.sites, 3):
            raise UsageError(f"a state of {self.name} has shape ({self.sites}, 3), "
                             f"not {np.shape(w)}")
        return array if array.flags.writeable else array.copy()

    def _new(self, tolerance: float):
        scalars, _, pointers = self._passed
        status = ctypes.c_int(0)
        self._state = self._c.new(scalars.ctypes.data, pointers, self.w.ctypes.data, self.t0,
                                  self.h, ctypes.byref(status))
        self._status = status.value
        if not self._state:
            name, meaning = STATUS.get(status.value, NO_MEMORY)
            raise RunError(f"{self.name} cannot start: {name}: {meaning}{wrong_start(self.prepared.numbers, self.w)}", status.value)
        self._c.set_tolerance(self._state, tolerance)
        self._c.state(self._state, self.w.ctypes.data)      # on its spheres, to the last digit

    def _fail(self, status):
        if status == 0:
            return
        name, meaning = STATUS.get(status, NO_MEMORY)
        found = self.report()
        found["rate"] = self._rate(found["site"])
        raise RunError(f"step {self.count + 1} from t = {self.t:.12g}: {name}: {meaning}"
                       f"{why(found)}{advice(status, found, self.h, METHODS[self.method].midpoint)}", status, self.count, **found)

    def _rate(self, site: int) -> float:
        """|h b|, the angle by which the field turns `site` in a step; of the fastest one for -1."""
        b = np.asarray(self.field(self.state()), float)
        with np.errstate(over="ignore"):        # a step of 1e300 fails, and its rate may be infinite
            turns = abs(self.h) * np.hypot(np.hypot(b[:, 0], b[:, 1]), b[:, 2])
        return float(turns[site] if site >= 0 else turns.max())


def value_columns(scene: Spec) -> list[str]:
    """Names of what `m_abi_values` fills, in its order."""
    axes = [f"momentum.{f.name}.{axis}" for f in scene.families for axis in "xyz"]
    return ["energy", *(f"energy.{e.name}" for e in scene.energies), *axes,
            *(o.name for o in scene.observables)]


def _real_array(v, real):
    """`v` itself if C can work on it, else a copy. Raises UsageError for what is no array of numbers."""
    try:
        return np.ascontiguousarray(v, dtype=real)
    except (TypeError, ValueError):
        raise UsageError("tangent vectors are an array of numbers") from None


