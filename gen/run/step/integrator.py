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
import numbers
from collections.abc import Iterable, Mapping

import numpy as np

from ... import ranks
from ...build.binary import Built, build_library
from ...errors import RunError, UsageError
from ...language import limits
from ...language.spec import Spec
from ...methods import METHODS
from ...public import ReadOnly, few, public
from ...read.shipped import SpecLike, spec_or_name
from .block import Block, clean
from .grid import check_grid, grid_flags
from .library import functions, loaded, loaded_with_threads, packed, passed
from .noise import noise_of
from .prepared import Prepared, asked, checked_threads, checked_tolerance, choose, prepare
from .real import real_array
from .saved import Saved
from .start import find_start, state_at, wrong_start
from .status import NO_MEMORY, REFUSED, STATUS, Status, advice, infinite_energies, what, why

VARIES = 3          # a field that changes by more within a step that fails is worth a word


@public
@spec_or_name
def build(spec: SpecLike, run: str | None = None, *, method: str | None = None, solver: str | None = None, effects: Iterable[str] | None = None,
          parameters: Mapping[str, object] | None = None, real: str = "double", native: bool | None = None, fast: bool = False,
          threads: int | None = None, features: Iterable[str] = ()) -> Integrator:
    """Compile the model of a run, or find it in the cache, and return an Integrator.

    :param spec: a Spec, a Model, the path of a spec, or the name of one that comes with smidgen.
    :param run: the name of a run, by default the first, from which method, solver, effects and parameters are taken if they are not given.
    :param parameters: values by name, in the units of the spec: a number, or a sequence for an array.
    :param real: "double" or "long double".
    :param native: whether to compile for this processor; None chooses what is fastest without changing a bit of the result.
    :param fast: like `native`, and with fused multiply-add instructions, which change the last bits.
    :param threads: the number of OpenMP threads that share a step.
    :param features: additions to the C code, such as "tangent" for the tangent map.
    :raises UsageError: for an unknown name, a value that does not fit, or threads if steps of this model cannot be shared.
    :raises MissingTool: if there is no C compiler.
    :raises BuildError: if it fails.
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
                              threads=threads is not None, ranks=ranks.count() > 1, grid=grid_flags(prepared), plan=prepared.plan)
    check_grid(built.notes)
    model = Integrator(prepared, built, threads)
    ranks.check(model._library)
    return model


class Integrator(ReadOnly):
    """A compiled model with values of its parameters, and one trajectory. Made by `build`.

    :ivar w: the state, shape (sites, 3). Steps change this array in place; it is the array passed to `start` if that has the right shape
        and type. You may write to it between steps: the next call continues from the new state, at the same time, without predictor and
        compensation, or raises UsageError if it is not a valid state.
    :ivar h: the step size (nan before `start`). `t0`: the time of the start. `count`: the number of steps since then.
    :ivar name: of the model; `method`, `solver` and `threads` are the requested ones, and `notes` describes what was chosen.
    :ivar parameters: the values of the parameters by name. `prepared`: these, with everything that was computed from them.
    :ivar families: for each family, the number of its first site and the number of its sites.
    :ivar columns: the names of the quantities that `values` returns.

    All attributes are read-only.
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
    INSTEAD = {"": "build another model with smidgen.build(spec, ...)", "count": "steps(count) takes steps"} | dict.fromkeys(
        ("h", "t0", "t", "w"), "call start(w, t0=..., h=...)") | {
            "w": "write to w[:], or call start(w, t0=..., h=...)",
            "parameters": "call set_parameters({name: value})"}

    def __init__(self, prepared: Prepared, built: Built, threads: int | None = None):
        self.prepared, self.built = prepared, built
        self.spec, self.scene, self.method, self.solver = prepared.spec, prepared.scene, prepared.method, prepared.solver
        self.name, self.notes, self.threads = self.scene.name, built.notes, threads
        self.parameters, self.families = prepared.numbers.parameters, prepared.numbers.places
        self.real = np.dtype(np.longdouble if built.real == "long double" else np.float64)
        self._library = loaded(built.binary) if threads is None else loaded_with_threads(built.binary, threads)
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
        """The number of sites."""
        return sum(count for _, count in self.families.values())

    @public
    def start(self, w=None, t0: float = 0.0, h: float | None = None, seed: int | None = None, tolerance: float | None = None,
              member: int = 0) -> Integrator:
        """Start a trajectory.

        :param w: an array of shape (sites, 3), which steps change in place; or the name of a start of the spec, or None if there is only
            one. Two integrators that share an array each continue from what the other has written.
        :param h: the step size; negative to go backward in time.
        :param t0: the time of the start.
        :param seed: the seed of a random start and of thermal noise (None: 0).
        :param member: selects one of the independent realisations of the noise with this seed.
        :param tolerance: the error allowed in a step, relative to the largest component of w; None for round-off (with step control, its
            default).
        :raises UsageError: for an array of another shape, a vector off its sphere, or an invalid h.
        :raises RunError: if the model refuses the state or its parameters.
        """
        if h is None or not math.isfinite(h) or h == 0:
            raise UsageError(f"h must be a finite number other than 0, not {h}")
        noise, w, tolerance = noise_of(self.scene, h, seed, member), self._array(w, seed), checked_tolerance(tolerance)
        self.close()
        self._now(w=w, h=float(h), t0=float(t0), count=0)
        self._new(tolerance)
        if noise:
            self._c.set_seed(self._state, *noise)
        return self

    @public
    def set_parameters(self, values: Mapping[str, object]) -> Integrator:
        """Change real parameters from the next step on, by name. The others are unchanged, as are w, time, count, h, tolerance and the
        seed of noise.

        Further steps are those of a trajectory that starts here with the new values.

        :raises UsageError: for an unknown name, an integer or fixed parameter, or a value that does not fit.
        :raises RunError: if the model refuses the values, for example another radius. In both cases nothing is changed.
        """
        for p in self.scene.parameters:
            if p.name in values and (p.kind == "int" or p.fixed):
                raise UsageError(f"'{p.name}' cannot be changed: it is {'an integer parameter' if p.kind == 'int' else 'fixed when the model is compiled'}; build another model")
        prepared = self.prepared.with_parameters(values)
        given = passed(*packed(prepared.numbers))
        if self._state:
            self._taken()
            status = self._c.set_parameters(self._state, given[0].ctypes.data, given[2])
            if status:
                raise RunError(f"the parameters of {self.name} are not changed: {': '.join(STATUS[status])}", status)
        self._passed = given
        self._now(prepared=prepared, parameters=prepared.numbers.parameters)
        return self

    @property
    def halved(self) -> int:
        """The number of steps since the start that were taken as two steps of h/2 with the same noise, because the whole step had no
        solution.
        """
        return self._c.halved(self._state) if self._state and self.scene.heated else 0

    def step(self) -> Integrator:
        """Take one step, changing w in place. If it fails, RunError is raised and w is unchanged."""
        return self.steps(1)

    def steps(self, count: int) -> Integrator:
        """Take `count` steps. If one fails, RunError is raised and w is the state before that step."""
        if self.advance(count) < count:
            self._fail(self._status)
        return self

    def advance(self, count: int) -> int:
        """Take up to `count` steps without raising an error; return the number of steps that succeeded."""
        self._started()
        check_count(count)
        self._gather_threads()
        done = ctypes.c_int64(0)
        status = self._c.go(self._state, self.w.ctypes.data, count, ctypes.byref(done))
        if status >= REFUSED:
            self._refuse(status - REFUSED)
        self._status = status
        self._now(count=self.count + done.value)
        return done.value

    def outputs(self, first: int, every: int, block: Block, begin: int, count: int) -> int:
        """Write up to `count` outputs into `block`, from row `begin` on: the first after `first` steps, the others every `every` steps.

        Returns the number of outputs written. It is less than `count` if a step failed; `failure` then returns the error.
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
        """The RunError of the last step, or None if it succeeded."""
        try:
            self._fail(self._status)
        except RunError as error:
            return error

    @property
    def t(self) -> float:
        """The current time, t0 + count*h."""
        self._started()
        return self._c.time(self._state)

    def state(self, out=None) -> np.ndarray:
        """A copy of the state, or the state written into `out`, an array of shape (sites, 3)."""
        self._taken()
        out = self._room(out, self.sites, 3)
        self._c.state(self._state, out.ctypes.data)
        return out

    def report(self) -> dict:
        """Details of the last step: iterations, residual (in units of w), site and partner (-1: none), and reached, the fraction of h up
        to which the branch of solutions was followed (0: it was not).
        """
        self._started()
        found = (ctypes.c_int(0), ctypes.c_double(0), ctypes.c_int64(-1), ctypes.c_int64(-1), ctypes.c_double(0))
        self._c.report(self._state, *map(ctypes.byref, found))
        return dict(zip(("iterations", "residual", "site", "partner", "reached"), (f.value for f in found)))

    def save(self) -> np.ndarray:
        """Everything that determines later steps, as numbers to pass to `restore`; `saved.Saved` gives access to its parts."""
        self._taken()
        out = np.empty(self._c.savesize(self._state), self.real)
        self._c.save(self._state, out.ctypes.data)
        return clean(out)

    def restore(self, saved: np.ndarray) -> Integrator:
        """Return to the point at which `save` was called; the trajectory must have been started with the same parameter values.

        :raises RunError: if the numbers were not saved by this model; the state is then unchanged.
        """
        self._started()
        saved = real_array(saved, self.real, "a saved state")
        size = self._c.savesize(self._state)
        status = self._c.restore(self._state, saved.ctypes.data) if saved.shape == (size,) else Status.BAD_PARAMETER
        if status:
            raise RunError(f"not a saved state of {self.name}: {STATUS[status][1]}", status)
        head = Saved.of(saved)
        self._now(t0=head.t0, h=head.h, count=head.count)
        self._status = 0
        self._c.state(self._state, self.w.ctypes.data)
        return self

    def values(self, out=None) -> np.ndarray:
        """All conserved quantities and observables, in the order of `columns`."""
        self._taken()
        out = self._room(out, len(self.columns))
        self._c.values(self._state, np.ones(len(self.columns), np.uint8).ctypes.data, out.ctypes.data)
        return out

    def casimirs(self, out=None) -> np.ndarray:
        """|w|^2 of each site, or C(w) of a Nambu factor; shape (sites,)."""
        self._taken()
        out = self._room(out, self.sites)
        self._c.casimirs(self._state, out.ctypes.data)
        return out

    @public
    def energy(self, w=None, t: float | None = None) -> float:
        """H(t, w), by default at the current time and state. Requires a trajectory."""
        self._started()
        w = self._present() if w is None else self._given(w)
        out = np.empty(1, self.real)
        self._c.energy(self._state, self.t if t is None else t, w.ctypes.data, out.ctypes.data)
        return out[0]

    @public
    def field(self, w=None, t: float | None = None) -> np.ndarray:
        """The field b = (1/kappa) dH/dw, shape (sites, 3), by default at the current time and state. Requires a trajectory."""
        self._started()
        w, out = self._present() if w is None else self._given(w), np.empty((self.sites, 3), self.real)
        self._c.field(self._state, self.t if t is None else t, w.ctypes.data, out.ctypes.data)
        return out

    def tangent(self, v) -> np.ndarray:
        """Apply the tangent map of the last step: tangent vectors dw before the step become dW after it.

        The step is W = w + h X(m), so that on spheres (I - K) dW = (I + K) dw with K = (h/2) DX(m) P'; on R^3 and Nambu factors the
        derivative with respect to the leaf is included.

        :param v: one vector, shape (sites, 3), or several, shape (columns, sites, 3). A contiguous array of doubles is changed in place.
        :returns: the vectors after the step.
        :raises UsageError: for another shape, or if the model was built without the feature "tangent".
        :raises RunError: before the first step, after w has been changed, or if the map has no value. v is then unchanged.
        """
        if self.count == 0 and self._state:
            raise UsageError("no step has been taken yet: the tangent map is that of the last step")
        return self._carry(v, 0)

    def push_forward(self, v, count: int) -> np.ndarray:
        """Take `count` steps and apply the tangent map of each to v, as `tangent` does.

        :raises RunError: if a step or its tangent map fails: w is then the state before that step, and v is unchanged.
        """
        check_count(count)
        return self._carry(v, count) if count else v

    def _carry(self, v, count):
        self._taken()
        if not hasattr(self._c, "tangent"):
            raise UsageError("this build has no tangent map: use build(..., features=('tangent',))")
        array = real_array(v, self.real, "tangent vectors")
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
                meaning = "no step has been taken since the state was changed or restored"
            site = self.report()["site"]
            if status - REFUSED == Status.SINGULAR and site >= 0 and not self.w[site].any():
                other = next(m.name for m in METHODS.values() if m.midpoint and not m.onto_leaf)
                meaning = (f"site {site} is the zero vector of R^3, where a step that projects onto |w| has no derivative; "
                           f"use the method {other}, or leave the site out")
            raise RunError(f"tangent map of step {self.count}: {name}: {meaning}", status - REFUSED, self.count, site=site)
        if not array.flags.writeable:
            return carried
        array[...] = carried
        return array

    def close(self) -> None:
        """Free the memory of the trajectory."""
        if self._state:
            self._c.free(self._state)
        self._state = None

    def __del__(self):
        if getattr(self, "_state", None):
            self.close()

    def _started(self):
        if not self._state:
            raise UsageError("there is no trajectory yet: call start(w, h=...) first")

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
        raise UsageError(f"the values written to w of {self.name} are not a valid state: {STATUS[status][0]}"
                         f"{wrong_start(self.prepared.numbers, self.w)}; change w")

    def _array(self, w, seed):
        if w is None or isinstance(w, str):
            find_start(self.spec, w)
            w = state_at(self.prepared.numbers, w, seed)
        return self._given(w)

    def _given(self, w):
        """`w` itself if C can work on it, else a copy. Raises UsageError for its shape."""
        array = real_array(w, self.real, "a state")
        if array.shape != (self.sites, 3):
            raise UsageError(f"a state of {self.name} has shape ({self.sites}, 3), "
                             f"not {np.shape(w)}")
        return array if array.flags.writeable else array.copy()

    def _room(self, out, *shape: int) -> np.ndarray:
        """A new array, or `out`, if C can write to it. Raises UsageError."""
        if out is None:
            return np.empty(shape, self.real)
        if not (isinstance(out, np.ndarray) and out.shape == shape and out.dtype == self.real and out.flags.c_contiguous and out.flags.writeable):
            raise UsageError(f"out must be a contiguous array of shape {shape} and type {self.real} that can be written to")
        return out

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
        found = self.report()
        found["rate"] = self._rate(found["site"])
        infinite = infinite_energies(self.columns, self.values()) if status == Status.NOT_FINITE else []
        raise RunError(f"step {self.count + 1} from t = {self.t:.12g}: {what(status, infinite, self.count)}"
                       f"{why(found)}{advice(status, found, self.h, METHODS[self.method].midpoint)}{self._varies()}",
                       status, self.count, **found)

    def _varies(self) -> str:
        """What is said of a field that changes much within the step because H depends on time."""
        with np.errstate(over="ignore", invalid="ignore"):
            low, *_, high = sorted(float(np.linalg.norm(self.field(self.state(), self.t + part * self.h))) for part in (0, 0.5, 1))
        return f"; H depends on time, and the field changes by a factor of {high / low:.3g} within this step" if VARIES * low < high < np.inf and low else ""

    def _rate(self, site: int) -> float:
        """|h b|, the angle by which the field turns `site` in a step; of the fastest one for -1."""
        b = np.asarray(self.field(self.state()), float)
        with np.errstate(over="ignore", invalid="ignore"):      # a step of 1e300 fails, and its rate may be infinite
            turns = abs(self.h) * np.hypot(np.hypot(b[:, 0], b[:, 1]), b[:, 2])
        return float(turns[site] if site >= 0 else turns.max())


def check_count(count: int) -> None:
    """Raises UsageError for a number of steps that C does not take."""
    if not isinstance(count, numbers.Integral):
        raise UsageError(f"the number of steps must be an integer, not {count!r}")
    if count < 0:
        raise UsageError("the number of steps must not be negative; to run backward, use a negative h")
    if count > limits.STEPS:
        raise UsageError(f"the number of steps must be at most {limits.STEPS}, not {count}")


def value_columns(scene: Spec) -> list[str]:
    """Names of what `m_abi_values` fills, in its order."""
    axes = [f"momentum.{f.name}.{axis}" for f in scene.families for axis in "xyz"]
    return ["energy", *(f"energy.{e.name}" for e in scene.energies), *axes,
            *(o.name for o in scene.observables)]
