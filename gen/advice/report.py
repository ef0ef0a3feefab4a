"""Step advice: the largest h that is safe for a start, and why."""
from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from ..errors import RunError
from ..integrator import build
from ..public import public
from ..settings import find_run, settle
from ..symmetry.energy import Energy
from .branch import Branch, follow
from .equation import Nowhere, StepEquation
from .trial import climb, first_failure

UNKNOWNS = 150          # up to here the branch is followed with all of J; beyond, by trial
MARGIN = 0.85           # of the limit that is found
TURN = 2 * math.pi      # h times the fastest rate at the cap: one rotation a step
PARTNER = 0.3           # of the largest entry of the null vector: what counts as taking part


@dataclass(frozen=True)
class Advice:
    """h: the largest safe step, found for this start; it has the sign of the run's h.

    limit: where the branch of solutions ends, or None: no end up to cap; cap: one rotation of the
    fastest motion a step; kind: 'fold', 'centre', 'edge', 'trial' or 'open'; sites and effect: who
    makes the end; rate: the fastest local rate, 1/time; phase_error: relative error of its phase
    at h, (h rate)^2/12; run_h: the step of the run, None when it has none.
    """
    spec: str
    run: str
    method: str
    h: float
    limit: float | None
    cap: float
    kind: str
    sites: tuple
    effect: str
    rate: float
    phase_error: float
    run_h: float | None
    reason: str

    def __repr__(self) -> str:
        return f"<Advice {self.spec} {self.run}: {self.method}: h = {self.h:.6g}, {self.kind}>"

    def words(self) -> list[str]:
        """The advice in plain sentences."""
        head = (f"The first step has no limit up to h = {self.cap:.6g}" if self.kind == "open" else
                f"The largest safe step for this start is h = {self.h:.6g}")
        lines = [f"{head}: {self.reason}.", _accuracy(abs(self.h), self.rate)]
        if self.run_h is not None:
            side = "within" if abs(self.run_h) <= abs(self.h) else "above"
            lines.append(f"The run's h = {self.run_h:.6g} is {side} it.")
        return lines

    def as_dict(self) -> dict:
        """For JSON."""
        return {**asdict(self), "words": self.words()}


def _accuracy(h: float, rate: float) -> str:
    """What h does to the fastest motion: a relative error (h rate)^2/12 of its phase."""
    if not rate:
        return "Accuracy: nothing moves at this start."
    turn, fine = h * rate, math.sqrt(0.012) / rate
    said = f"its phase is off by about {100 * turn ** 2 / 12:.2g} %" if turn < 1.5 else "it is not resolved"
    more = f"; h = {fine:.3g} brings that to 0.1 %" if fine < h else ""
    return f"Accuracy: the fastest local rate is {rate:.6g}, h times it is {turn:.3g}, and {said}{more}."


@public
def advise(spec, run: str | None = None, *, start=None, method: str | None = None, solver: str | None = None,
           h=None, effects=None, values=None, seed: int | None = None) -> Advice:
    """The largest safe step for the start of a run; start .. seed as for `smidgen.run`.

    The branch of solutions of the step equation is followed from h = 0 (up to `UNKNOWNS` unknowns;
    beyond, by trial steps), and the advice is tried with first steps of the generated code. Raises
    UsageError for what does not fit, RunError when not even a tiny step exists.
    """
    base = find_run(spec, run)
    stated = h is not None or base.h is not None
    s = settle(spec, run, start=start, method=method, solver=solver, h=h if stated else 1.0, steps=1, every=1,
               effects=effects, values=values, seed=seed)
    model = build(spec, s.method, s.effects, s.values, s.solver)
    w = model.start(s.start, h=s.h, seed=s.seed).w.copy()
    return advice_for(model, w, 0.0, s.h, s.run, stated)


def advice_for(model, w, t: float, h: float, run: str = "", stated: bool = True) -> Advice:
    """Advice for a compiled model at a state w of shape (sites, 3) and time t; only the sign of h counts,
    and it is compared with the advice when `stated`."""
    sign = math.copysign(1.0, h)
    model.start(np.array(w, model.real), t0=t, h=h)
    equation = StepEquation(model, w, t, sign)
    try:
        rate = local_rate(equation)
    except Nowhere as place:
        raise RunError(f"the field is not finite at site {place.site} of the start", 4, site=place.site) from None
    cap = TURN / rate if rate else abs(h)
    if 3 * model.sites <= UNKNOWNS:
        facts = _followed(model, equation, cap)
    else:
        facts = _climbed(model, equation, cap)
    facts = _tried(model, equation, facts)
    if not facts["h"]:
        raise RunError(f"no first step succeeds: {facts['reason']}", 1, site=(*facts["sites"], -1)[0])
    error = (facts["h"] * rate) ** 2 / 12
    facts["h"] = math.copysign(facts["h"], h)
    return Advice(model.name, run, model.method, cap=cap, rate=rate, phase_error=error,
                  run_h=h if stated else None, **facts)


def local_rate(equation: StepEquation) -> float:
    """The fastest rate at the start, 1/time: sqrt(r^2 + v^2), r the spectral radius of DX P' in the tangent
    planes and v the largest |X|/|w|. A spin at an angle a to a field B has r = B cos a, v = B sin a, and turns
    with the rate B. For many sites the largest |b|."""
    w = equation.w
    y = np.linalg.norm(equation.rate(w, 0.0), axis=1)
    if w.size > UNKNOWNS:
        b = np.linalg.norm(np.asarray(equation.model.field(w, equation.t), float), axis=1)
        return float(np.max(b * np.linalg.norm(equation.casimir, 2, axis=(1, 2))))
    spins = np.max(np.abs(np.linalg.eigvals(equation.slope(w, 0.0))))
    moves = np.max(y / np.where(equation.length > 0, equation.length, 1))
    return float(np.hypot(spins, moves))


def _followed(model, equation, cap) -> dict:
    branch = follow(equation, cap)
    if not branch.ends:
        return _facts(cap, None, "open", (), "", OPEN)
    sites = _partners(branch) if branch.kind == "fold" else (branch.site,)
    effect = _effect(model, equation, branch)
    return _facts(MARGIN * branch.h, branch.h, branch.kind, sites, effect,
                  REASONS[branch.kind].format(branch.h, _named(model, sites), effect, MARGIN))


OPEN = "there the fastest motion turns once around in a step; accuracy decides"
REASONS = {
    "fold": "the step equation has a fold at h = {:.6g}, made by {} through effect '{}'; this is {} of it",
    "centre": "near h = {:.6g} the midpoint of {} runs into the centre (effect '{}'), and no step exists beyond; "
              "this is {} of it",
    "edge": "near h = {:.6g} the midpoint of {} comes to the edge of where its Casimir or its energy (effect '{}') "
            "is defined; this is {} of it",
    "trial": "the first step of the generated code fails at h = {:.6g}: {}; this is {} of what works",
}


def _facts(h, limit, kind, sites, effect, reason) -> dict:
    return {"h": h, "limit": limit, "kind": kind, "sites": sites, "effect": effect, "reason": reason}


def _partners(branch: Branch) -> tuple:
    """The sites that the null vector moves most: one or two."""
    size = np.linalg.norm(branch.null, axis=1)
    order = np.argsort(-size)[:2]
    return tuple(sorted(int(k) for k in order if size[k] > PARTNER * size[order[0]]))


def _named(model, sites) -> str:
    """`w[3] and v[0]`, by the families of the spec."""
    found = []
    for site in sites:
        name, first = max(((n, f) for n, (f, _) in model.families.items() if f <= site), key=lambda x: x[1])
        found.append(name if model.families[name][1] == 1 else f"{name}[{site - first}]")
    return " and ".join(found) or "the whole system"


def _effect(model, equation, branch: Branch) -> str:
    """The effect whose energy curves most along the null vector, at the last midpoint."""
    parts, d = Energy(model.scene, model.values_in).parts, 1e-4
    try:
        m, v = equation.project(equation.w + branch.u / 2), branch.null
    except Nowhere:
        m, v = equation.w, branch.null
    t = equation.t + equation.sign * branch.h / 2
    with np.errstate(all="ignore"):
        up, here, down = parts(m + d * v, t), parts(m, t), parts(m - d * v, t)
        bend = {e: abs(up[e] - 2 * here[e] + down[e]) for e in here}
        slope = {e: d * abs(up[e] - down[e]) for e in here}
    found = {e: bend[e] + slope[e] for e in bend if math.isfinite(bend[e])}
    return max(found, key=found.get) if found else ""


def _climbed(model, equation, cap) -> dict:
    good, bad = climb(model, equation.w, equation.t, cap, equation.sign)
    if bad is None:
        return _facts(cap, None, "open", (), "", OPEN)
    return _facts(MARGIN * good, good, "trial", bad.sites, "",
                  REASONS["trial"].format(bad.h, f"{bad.message} ({_named(model, bad.sites)})", MARGIN))


def _tried(model, equation, facts) -> dict:
    """The advice after first steps up to it: lower where one of them fails."""
    for _ in range(4):
        bad = first_failure(model, equation.w, equation.t, equation.sign * facts["h"]) if facts["h"] else None
        if bad is None:
            return facts
        limit = bad.reached or bad.h / 1.2
        facts = _facts(MARGIN * limit, limit, "trial", bad.sites, facts["effect"],
                       REASONS["trial"].format(bad.h, f"{bad.message} ({_named(model, bad.sites)})", MARGIN))
    return {**facts, "h": 0.0}
