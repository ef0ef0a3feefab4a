"""Step advice: the largest h that is safe for a run, and why."""
from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass

import numpy as np

from ...errors import RunError, UsageError
from ...methods import METHODS
from ...public import html_of, public
from ...read.shipped import SpecLike, spec_or_name
from ...run.settings import duration, model_of, settle
from ...run.step.prepared import find_run
from .along import MARGIN, TURN, along
from .clock import clock
from .end import End, end_of, of_failure, there
from .equation import Nowhere, StepEquation
from .rates import fastest, fine_step, local_rate
from .trial import first_failure
from .words import named, reason, sentences

AT_CAP = 0.98           # of the cap: what counts as the cap
STEPS = 100             # of the largest h of the start, where nothing says how long the run is


@dataclass(frozen=True)
class Advice:
    """h: the largest safe step that was found for this run; it has the sign of the run's h.

    limit: where the branch of solutions ends, or None: no end up to cap; cap: one rotation of the
    fastest motion a step; kind: 'fold', 'centre', 'edge', 'trial' or 'open'; t: the time of the state that
    limits h; sites and effect: who makes the end; rate: the fastest local rate, 1/time, and rate_t its time;
    change: the angular frequency of the fastest modulation of H, 0 for none; abrupt: does H also change faster than could be
    resolved, as at a jump?; phase_error: relative error (h rate)^2/12 of a phase at h; fine: an h at which that is 0.1 % and a
    period of the modulation has ten steps, None when nothing moves; run_h: the step of the run, None when it has none; orbits: (h, steps, last time)
    of the runs that were tried; states: how many of their states were looked at; span: the length of the run;
    spacing: of the times at which H was looked at, None when it does not depend on time; completes: False when even
    with h a step fails; failing: its time, or None.
    """
    spec: str
    run: str
    method: str
    h: float
    limit: float | None
    cap: float
    kind: str
    t: float
    sites: tuple
    effect: str
    rate: float
    rate_t: float
    change: float
    abrupt: bool
    phase_error: float
    fine: float | None
    run_h: float | None
    orbits: tuple
    states: int
    span: float
    spacing: float | None
    completes: bool
    failing: float | None
    reason: str

    def __repr__(self) -> str:
        return f"<Advice {self.spec} {self.run}: {self.method}: h = {self.h:.6g}, {self.kind}>"

    def words(self) -> list[str]:
        """The advice in plain sentences."""
        return sentences(self)

    def _repr_html_(self) -> str:
        return html_of("\n".join(self.words()))

    def as_dict(self) -> dict:
        """For JSON."""
        return {**asdict(self), "words": self.words()}


@public
@spec_or_name
def advise(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, method: str | None = None, solver: str | None = None,
           h: float | str | None = None, steps: int | None = None, time: float | str | None = None, effects: Iterable[str] | None = None,
           parameters: Mapping[str, object] | None = None, seed: int | None = None) -> Advice:
    """Estimate the largest safe step of a run. The arguments are as for `run`.

    The branch of solutions of the step equation is followed from h = 0 (with more than `UNKNOWNS` unknowns, trial steps are taken
    instead). The result is then checked with first steps of the generated code, and at states along the run as far as the allotted work
    permits.

    :raises UsageError: for an argument that does not fit.
    :raises RunError: if not even a tiny step has a solution.
    """
    base = find_run(spec, run)
    stated = h is not None or base.h is not None
    s = settle(spec, run, start=start, method=method, solver=solver, h=h if stated else 1.0, steps=1, every=1,
               effects=effects, parameters=parameters, seed=seed)
    if not METHODS[s.method].midpoint:
        raise UsageError(f"`smidgen advise` supports midpoint methods only; {METHODS[s.method].title} solves a different step equation")
    model = model_of(spec.calm, s)
    w = model.start(s.own_start, h=s.h, seed=s.seed).w.copy()
    return advice_for(model, w, 0.0, s.h, s.run, stated,
                      duration(spec, base, s, steps, time) if stated or time is not None else None, STEPS if steps is None else steps)


def advice_for(model, w, t: float, h: float, run: str = "", stated: bool = True, span: float | None = 0.0,
               steps: int = STEPS) -> Advice:
    """Advice for a compiled model from a state w of shape (sites, 3) and time t on; only the sign of h counts,
    and it is compared with the advice when `stated`. span: the length of the run, 0 for the state alone, None for
    `steps` of the largest steps of this state."""
    sign = math.copysign(1.0, h)
    model.start(np.array(w, model.real), t0=t, h=h)
    equation = StepEquation(model, w, t, sign)
    try:
        local_rate(equation)
    except Nowhere as place:
        raise RunError(f"the field is not finite at site {place.site} of the start", 4, site=place.site) from None
    return _advice(model, equation, h, run, stated, span, steps)


def _advice(model, equation, h, run, stated, span, steps) -> Advice:
    ticks = clock(equation, span or 0.0)
    rate, rate_t = fastest(equation, [(at, equation.w) for at in (equation.t, *(ticks.moments if ticks else ()))])
    cap = TURN / rate if rate else abs(h)
    start = _tried(model, equation, end_of(model, equation, cap), cap)
    safe = cap if start.limit is None else min(cap, MARGIN * start.limit)
    if span is None:
        span = steps * safe
        ticks = clock(equation, span)
    look = along(model, equation, safe, (rate, rate_t), span, abs(h) if stated else 0.0, ticks)
    cap = TURN / look.rate if look.rate else abs(h)
    end, t = _binding(model, equation, look, start, cap)
    return Advice(
        model.name, run, model.method, equation.sign * look.h, end.limit, cap, end.kind, equation.t if t is None else t,
        end.sites, end.effect, look.rate, look.rate_t, ticks.change if ticks else 0.0, bool(ticks and ticks.abrupt),
        (look.h * look.rate) ** 2 / 12, fine_step(look.rate, ticks.change if ticks else 0.0), h if stated else None,
        tuple((o.h, o.count, o.end) for o in look.orbits), sum(len(o.places) for o in look.orbits), span,
        ticks.spacing if ticks else None, look.failing is None, look.failing,
        reason(end, equation.sign * look.h, named(model, end.sites), t))


def _tried(model, equation, end: End, cap: float) -> End:
    """The end after first steps up to the advice: nearer where one of them fails."""
    for _ in range(4):
        h = cap if end.limit is None else min(cap, MARGIN * end.limit)
        bad = first_failure(model, equation.w, equation.t, equation.sign * h) if h else None
        if bad is None and h:
            return end
        end = of_failure(bad, bad.limit) if bad is not None else end
    raise RunError(f"no step from the start succeeds, however small: {end.said}", 1, site=(*end.sites, -1)[0])


def _binding(model, equation, look, start: End, cap: float):
    """(the end that decides, the time of its state, None: that of the start)."""
    if look.h >= AT_CAP * cap:
        return End(None), None
    if look.refusal is None:
        return start, None
    at = equation.of(look.refusal.w, look.refusal.t)
    return there(model, at, look.refusal.failure, cap), look.refusal.t
