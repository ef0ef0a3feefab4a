"""Ensembles: each member beside the same state alone, bit for bit.

Numbers of members that fill whole vectors and such as leave lanes empty; alike and with parameters of their own; in many small calls and
in few large ones; at the start of the run and at its end.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ...run.many.ensemble import Stepped
from .case import Case
from .past import another
from .row import Row, at_most, not_applicable
from .whole_space import spread

FEATURE = "ensemble"
CALLS = (1, 1, 5, 16, 40)       # steps of each call: the first has no history, the last is longer than vectors keep one
WORK = {"quick": 10**5, "normal": 4 * 10**5}    # steps of single sites
OWN = 0.05                      # part by which the parameters of members differ


def members(case: Case, subject) -> list[Row]:
    """One row: how many members have other bits than alone, or stop elsewhere."""
    if FEATURE not in case.features:
        case.unseen.append("ensembles: this code was generated without them")
        return [not_applicable("ensemble", f"this build has no ensembles: use --features {FEATURE}")]
    one = getattr(subject, "double", None)
    if one is None or not hasattr(one._c, "ensemble_new"):
        case.unseen.append("ensembles: this integrator gives no access to them")
        return [not_applicable("ensemble", "this integrator does not provide ensembles")]
    lanes, wrong, total = one._c.ensemble_lanes(), [], 0
    for count, t, own in tried(case, one, lanes):
        wrong += differing(case, one, count, t, own)
        total += count
    note = f"{total} members, {lanes} at a time" + (f"; first: {wrong[0]}" if wrong else "")
    return [at_most("ensemble", len(wrong), 0, note)]


def tried(case: Case, one, lanes):
    """(members, time, do they have parameters of their own?) of every ensemble."""
    counts = sorted({1, 2, lanes - 1, lanes, lanes + 1, 3 * lanes, 4 * lanes + 3} - {0})
    most = max(2, case.of_tier(WORK) // (case.sites * sum(CALLS) * 8))
    for count in counts:
        if count <= most:
            yield count, 0.0, False
    largest = min(max(counts), most)
    yield largest, case.end(), False
    yield largest, 0.0, True


def differing(case: Case, one, count, t, own) -> list[str]:
    """Which members of an ensemble do not end as they do alone."""
    w = np.ascontiguousarray(spread(case, count))
    values = parameters(case, one, count) if own else {}
    stepped = Stepped(one.prepared, one.built, values, w, t, case.h, 0.0, 1)
    try:
        found = [(stepped.advance(calls), stepped.state(), stepped.reports()) for calls in CALLS]
    finally:
        stepped.close()
    wrong = []
    for k in range(count):
        for (_, states, (steps, status, *_)), (state, done, said) in zip(found, alone(case, one, w[k], t, {p: v[k] for p, v in values.items()})):
            if states[k].tobytes() != state.tobytes() or (steps[k], status[k]) != (done, said):
                wrong.append(f"member {k} of {count} after {done} steps")
                break
    return wrong


def alone(case: Case, one, w, t, values):
    """(state, steps taken, status) after each call, by the single state."""
    by_itself, done, status = with_values(one, values), 0, 0
    try:
        by_itself.start(w.copy(), t0=t, h=case.h)
    except RunError as error:
        return [(w, 0, error.status)] * len(CALLS)
    found = []
    for count in CALLS:
        if not status:
            done += by_itself.advance(count)
            status = by_itself._status
        found.append((by_itself.state(), done, status))
    return found


def with_values(one, values):
    """A trajectory of the same library with other values."""
    from ...run.step.integrator import Integrator
    return Integrator(one.prepared.with_parameters(values), one.built) if values else another(one)


def parameters(case: Case, one, count) -> dict:
    """Numbers near those of the run, one for each member."""
    names = [p.name for p in one.scene.parameters if not p.fixed and p.kind != "int" and p.kind != "array" and one.parameters.get(p.name)]
    return {name: one.parameters[name] * (1 + OWN * case.dice.uniform(-1, 1, count)) for name in names}
