"""Every choice of a run: what the caller gives, else what the spec's run says."""
from __future__ import annotations

import dataclasses
import math
import numbers
import typing
from collections.abc import Iterable, Mapping

import numpy as np

from ..errors import UsageError
from ..language import limits
from ..language.evaluate import evaluate, integer
from ..language.expr import Expr
from ..language.spec import Averages, Run, Spec
from ..read.given import time as time_of
from ..read.names import COMPUTED
from .fields.field import Field
from ..methods import NAMES as METHODS, SOLVERS
from ..public import guess
from .record.means import BINS
from .step.integrator import Integrator, compiled
from .step.prepared import Prepared, asked, checked_threads, checked_tolerance, choose, prepare
from .step.evaluated import Evaluated
from .step.real import real_array

_FORMULA = typing.get_args(Expr)
KINDS = ("states", "energy", "momentum", "casimirs")


@dataclasses.dataclass(frozen=True)
class Settings:
    """A run with every choice made. every: steps between outputs; start: a name or an
    array; period: the time between outputs when every came from one; substeps: take a step
    that fails as smaller ones; checkpoint: steps between two checkpoints, None for none; estimate: of the
    error at the end; tolerance: of a step, None for round-off; fast: for this processor, and
    products and sums in one operation; averages: what, after and bins of those that the run takes, None for none; numbers: the spec's, evaluated with these parameters."""
    run: str
    start: object
    method: str
    solver: str
    h: float
    steps: int
    every: int
    period: float | None
    what: tuple[str, ...]
    effects: tuple[str, ...] | None
    parameters: dict
    numbers: Evaluated = dataclasses.field(repr=False, compare=False)
    seed: int | None
    real: str = "double"
    native: bool | None = None
    substeps: bool = False
    checkpoint: int | None = None
    estimate: bool | None = False
    tolerance: float | None = None
    fast: bool = False
    threads: int | None = None
    averages: dict | None = None

    @property
    def own_start(self):
        """The start, an array as a copy: steps change theirs in place."""
        return self.start.copy() if isinstance(self.start, np.ndarray) else self.start

    def prepared(self, spec: Spec) -> Prepared:
        """Of the spec that these choices were made for, or of a part of it, such as `spec.calm`."""
        return prepare(spec, self.method, self.effects, self.parameters, self.solver, self.numbers)


def model_of(spec: Spec, s: Settings, real: str | None = None, features=()) -> Integrator:
    """The compiled model of a run; real: in place of that of the run."""
    return compiled(s.prepared(spec), real or s.real, s.native, features, s.fast, s.threads)


def settle(spec: Spec, run: str | None = None, *, start=None, method=None, solver=None,
           h=None, steps=None, time=None, every=None, period=None, what=None, effects=None,
           parameters=None, seed=None, real="double", native=None, substeps=None,
           checkpoint=None, estimate=False, tolerance=None, fast=False, threads=None, averages=None) -> Settings:
    """All choices of a run: what is given, else what the run says, else the defaults."""
    base = asked(spec, run, method, solver, effects, parameters)
    parameters = dict(base.parameters)
    numbers = Evaluated(spec, parameters)
    env = numbers.values
    h, time, period = (_read(spec, what_, value) for what_, value in
                        (("h", h), ("time", time), ("period", period)))
    h = step_size(base.h if h is None else h, env)
    if steps is None and time is None:
        steps, time = base.steps, base.time
    if every is None and period is None:
        every, period = (base.every, None) if base.period is None else (None, base.period)
    period = None if period is None else abs(number(period, env, "the period"))
    return Settings(
        base.name, _placed(base.start if start is None else start, numbers),
        choose("method", base.method, METHODS), choose("solver", base.solver, SOLVERS), h,
        number_of_steps(steps, time, h, env), interval(every, period, h), period,
        chosen_outputs(spec, tuple(what or base.what if averages is None and base.averages is None or what is None else what)),
        base.effects, parameters, numbers,
        None if seed is None else whole(seed, "a seed"), real, None if native is None else bool(native),
        bool(base.substeps if substeps is None else substeps), cadence(checkpoint, base.checkpoint), None if estimate is None else bool(estimate),
        None if tolerance is None and base.tolerance is None else checked_tolerance(base.tolerance if tolerance is None else tolerance), bool(fast), checked_threads(threads),
        averages_of(base.averages if averages is None else asked_averages(spec, averages), env))


def asked_averages(spec: Spec, given: Mapping) -> Averages:
    """Those of a call: `what`, `after` and `bins`, each optional. Raises UsageError for another key, and for names that are none."""
    known = [f.name for f in dataclasses.fields(Averages)]
    if not isinstance(given, Mapping):
        raise UsageError(f"averages must be a dictionary with the optional keys {', '.join(known)}, not {given!r}")
    for key in given:
        if key not in known:
            raise UsageError(f"averages have no '{key}'{guess(str(key), known, {})}")
    what = given.get("what", ())
    what = (what,) if isinstance(what, str) else what
    if not isinstance(what, Iterable) or not all(isinstance(name, str) for name in what):
        raise UsageError("averages: `what` must be a list of names")
    return Averages(tuple(what), _read(spec, "after", given.get("after")), given.get("bins"))


def averages_of(given: Averages | None, env) -> dict | None:
    """As metadata have them."""
    if given is None:
        return None
    after = 0.0 if given.after is None else number(given.after, env, "after")
    bins = BINS if given.bins is None else whole(given.bins, "bins")
    if after < 0 or bins < 2:
        raise UsageError("averages: `after` must not be negative, and `bins` must be at least 2")
    return {"what": list(given.what), "after": after, "bins": bins}


def _read(spec: Spec, what: str, value):
    """Text becomes a formula of the spec's parameters; the rest stays."""
    return time_of(value, what, spec) if isinstance(value, str) else value


def _placed(start, numbers: Evaluated):
    """The vectors of a file on the sites of the spec, those of a list as an array; another start stays."""
    if isinstance(start, Field):
        return start.placed(numbers)
    return real_array(start, None, "a state") if isinstance(start, (list, tuple)) or hasattr(start, "__array__") else start


def whole(value, what: str) -> int:
    """An integer from 0 up. Raises UsageError."""
    if not isinstance(value, numbers.Real) or not math.isfinite(value) or value != int(value) or value < 0:
        raise UsageError(f"{what} must be a non-negative integer, not {value}")
    return int(value)


def number(value, env, what: str) -> float:
    """A finite number from a number or a formula."""
    if isinstance(value, _FORMULA):
        value = evaluate(value, env)
    if not isinstance(value, numbers.Real):
        raise UsageError(f"{what} must be a number or a formula, not {value!r}")
    if not math.isfinite(value):
        raise UsageError(f"{what} must be finite, not {value}")
    return float(value)


def step_size(h, env) -> float:
    """The step h: finite, not zero."""
    if h is None:
        raise UsageError("no step size is given: give h (on the command line: --h 0.1)")
    h = number(h, env, "h")
    if h == 0:
        raise UsageError("h must not be 0")
    return h


def number_of_steps(steps, time, h: float, env) -> int:
    """From a number of steps or a duration; both is an error, and so is neither."""
    if (steps is None) == (time is None):
        raise UsageError("no duration is given: give either steps or time"
                         " (on the command line: --steps 1000 or --time 100)")
    if time is not None:
        return multiple(number(time, env, "time"), h, "the duration")
    steps = integer(steps, env, "steps") if isinstance(steps, _FORMULA) else whole(steps, "steps")
    if not 0 <= steps <= limits.STEPS:
        raise UsageError(f"steps must be from 0 to {limits.STEPS}, not {steps}")
    return steps


def duration(spec: Spec, base: Run, s: Settings, steps=None, time=None) -> float | None:
    """How long a run is, whether or not that is a multiple of h; None: nothing says so."""
    if steps is None and time is None:
        steps, time = base.steps, base.time
    if time is not None:
        return abs(number(_read(spec, "time", time), s.numbers.values, "time"))
    return None if steps is None else abs(s.h) * number_of_steps(steps, None, s.h, s.numbers.values)


def multiple(duration: float, h: float, what: str) -> int:
    """duration / |h| as an integer. Raises UsageError that names the two nearest."""
    if duration < 0 < h:
        raise UsageError(f"{what} is {duration:g}: to run backward, use a negative h")
    duration, h = abs(duration), abs(h)
    n = round(min(duration / h, 2.0 * limits.STEPS))        # which may be infinite
    if n > limits.STEPS:
        raise UsageError(f"{what} of {duration:g} takes more than {limits.STEPS} steps")
    if abs(n * h - duration) <= limits.MULTIPLE * duration:
        return n
    low = math.floor(duration / h)
    raise UsageError(f"{what} {duration:.15g} is not a multiple of h = {h:.15g}; the nearest are "
                     f"{low * h:.15g} ({low} steps) and {(low + 1) * h:.15g} ({low + 1} steps)")


def interval(every, period, h: float) -> int:
    """Steps between outputs, from a count or from the time between them."""
    if period is not None:
        every = multiple(period, h, "the period")
        if every == 0:
            raise UsageError(f"the period must be a multiple of h = {abs(h):.15g} and not 0")
    every = whole(every, "every")
    if not 1 <= every <= limits.EVERY:
        raise UsageError(f"every must be from 1 to {limits.EVERY} steps, not {every}")
    return every


def cadence(given, otherwise) -> int | None:
    """Steps between checkpoints: what is given, else what the run says."""
    steps = otherwise if given is None else whole(given, "checkpoint")
    if steps is not None and not 1 <= steps <= limits.EVERY:
        raise UsageError(f"checkpoint must be from 1 to {limits.EVERY} steps, not {steps}")
    return steps


def chosen_outputs(spec: Spec, what) -> tuple[str, ...]:
    """Names of outputs, checked."""
    known = [*KINDS, *COMPUTED, *(o.name for o in spec.observables)]
    for name in what:
        if name not in known:
            raise UsageError(f"there is no output '{name}'; there are: {', '.join(known)}")
    return what
