"""The advice in plain sentences."""
from __future__ import annotations

import math

from .along import ROOM
from .rates import SAMPLES

COARSE = 1.5            # radians by which the fastest motion turns in a step: beyond, its phase is not given
ENDS = {
    "fold": "the step equation has a fold at h = {limit:.6g}, caused by {sites}{through}",
    "centre": "near h = {limit:.6g} the midpoint of {sites} reaches the centre{of}; no solution exists beyond that",
    "edge": "near h = {limit:.6g} the midpoint of {sites} leaves the region where its Casimir or its energy{of} is defined",
    "trial": "a step of {said} ({sites}), and the limit is near h = {limit:.6g}",
}


def reason(end, h: float, sites: str, t: float | None) -> str:
    """Why not more than h: what ends the steps, from the state at the time t, None: the start."""
    if end.kind == "open":
        return "at this step the fastest motion makes a full turn per step; accuracy is the limit"
    effect = f"effect '{end.effect}'"
    limit = math.copysign(end.limit, h)
    text = ENDS[end.kind].format(limit=limit, sites=sites, said=end.said,
                                 through=f" through {effect}" if end.effect else "", of=f" ({effect})" if end.effect else "")
    where = "" if t is None else f"from the state at t = {t:.6g}, "
    return f"{where}{text}; the advice is {h / limit:.2g} of that limit"


def named(model, sites) -> str:
    """`w[3] and v[0]`, by the families of the spec."""
    found = []
    for site in sites:
        name, first = max(((n, f) for n, (f, _) in model.families.items() if f <= site), key=lambda x: x[1])
        found.append(name if model.families[name][1] == 1 else f"{name}[{site - first}]")
    return " and ".join(found) or "the whole system"


def sentences(a) -> list[str]:
    """Of an `Advice`: the largest safe step, the accuracy, what was looked at, the run's own step."""
    lines = [_head(a), _accuracy(a), _looked(a)]
    if a.spacing is not None:
        lines += _clock(a)
    if not a.completes:
        lines.append(f"Even with h = {a.h:.6g} a step near t = {a.failing:.6g} fails or has no margin, so the run may not finish.")
    if a.run_h is not None:
        lines.append(_own(a))
    return lines


def _head(a) -> str:
    what = "start" if not a.span else "run"
    return (f"No limit was found up to h = {a.h:.6g}: {a.reason}." if a.kind == "open" else
            f"The largest safe step for this {what} is h = {a.h:.6g}: {a.reason}.")


def _accuracy(a) -> str:
    """What h does to the fastest motion, and to a modulation of H."""
    h = abs(a.h)
    if a.fine is None:
        return "Accuracy: nothing moves from this start."
    at = f"rate {a.rate:.6g}, at t = {a.rate_t:.6g}" if a.span else f"rate {a.rate:.6g}"
    slow = f"at h = {a.h:.6g} the fastest rotation ({at}) turns by {h * a.rate:.3g} rad in a step, {'and ' * (h * a.rate < COARSE)}{_off(h * a.rate)}"
    more = f"; with h = {math.copysign(a.fine, a.h):.3g} its phase is accurate to 0.1 %" if a.fine < h else ""
    return f"Accuracy: {slow}{more}."


def _off(turn: float) -> str:
    return f"the phase is off by about {100 * turn ** 2 / 12:.2g} %" if turn < COARSE else "too much to be accurate"


def _clock(a) -> list[str]:
    """How fast H changes, and how well that is known."""
    changes = f" and changes as fast as a modulation with a period of about {math.tau / a.change:.2g}; steps per period: {_per_period(a.h, a)}" if a.change else ""
    if changes and abs(a.h) > a.fine:
        changes += f", {math.tau / a.change / a.fine:.2g} with h = {math.copysign(a.fine, a.h):.3g}"
    abrupt = f"At some time H changes within less than {a.spacing:.3g}, as if it jumped; a step across that time is less accurate."
    return [f"H depends on time{changes}.", *([abrupt] if a.abrupt else []),
            f"Its strength was sampled every {a.spacing:.3g} of t over {a.span:.6g}; a pulse shorter than that may have been missed."]


def _per_period(h: float, a) -> str:
    """How many steps of h a period of the modulation has, and whether they are enough."""
    count = math.tau / a.change / abs(h)
    return f"{count:.2g} with h = {h:.6g}" + " (too few to follow it)" * (count < SAMPLES / 2)


def _looked(a) -> str:
    """Which states and times the advice was found from: a margin there, none elsewhere."""
    if not a.span:
        return "Only this state was examined. If bodies come closer later, a smaller step may be needed."
    runs = " and ".join(f"with h = {h:.6g} to t = {t:.6g} ({count} steps)" for h, count, t in a.orbits)
    room = f"a step {ROOM} times as large exists from each of the {a.states} states examined" if a.completes else "not to its end"
    return (f"Examined: the run over a time of {a.span:.6g}, {runs}; {room}. "
            "Other starts, and later times, may need a smaller step.")


def _own(a) -> str:
    """The run's own step beside the advice."""
    side = "does not exceed" if abs(a.run_h) <= abs(a.h) else "exceeds"
    turn = abs(a.run_h) * a.rate
    off = f"; {_off(turn)}" if 0 < turn < COARSE else f"; the fastest rotation turns by {turn:.3g} rad in it, {_off(turn)}" if turn else ""
    off += f"; steps per period of H: {_per_period(a.run_h, a)}" if a.change else ""
    what = "the largest step examined" if a.kind == "open" else "the largest safe step"
    return f"The run's h = {a.run_h:.6g} {side} {what}, {a.h:.6g}{off}."
