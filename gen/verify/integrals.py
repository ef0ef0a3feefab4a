"""Integrals that the method must keep: momentum, those of single sites, and an energy made of them.

W - w = h X(m) keeps a.w wherever a.X = 0, and w.(S w) of a single site since W + w is a multiple
of m. One step in extended precision shows the method, up to the round-off of the coefficients of I;
`round_off` watches many in double.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import RunError
from .case import EPS, Case
from .leaves import LONG, lengths
from .row import Row, at_most, not_applicable
from .symmetries import LARGEST, SiteIntegrals, round_sites, site_integrals

ULPS = 16
FIT = 1e-11             # distance of H from the span of the integrals that counts as none


@dataclass(frozen=True)
class Integral:
    """I = sum a.w + sum w.(S w)/2; linear (sites, 3) or quadratic (sites, 3, 3), the other None."""
    linear: np.ndarray | None
    quadratic: np.ndarray | None = None

    def __call__(self, w):
        """Its value; leading axes of w are kept."""
        if self.linear is not None:
            return np.einsum("si,...si->...", self.linear.astype(w.dtype), w)
        return np.einsum("...si,sij,...sj->...", w, self.quadratic.astype(w.dtype), w) / 2

    def size(self, w) -> float:
        """The sum of absolute terms, by which round-off is measured."""
        part = Integral(*(None if x is None else np.abs(x) for x in (self.linear, self.quadratic)))
        return max(float(part(np.abs(w))), np.finfo(float).tiny)


def known_integrals(case: Case, axes) -> dict[str, list[Integral]]:
    """{"momentum": linear ones, "quadratic integrals": quadratic ones}."""
    acting = round_sites(case) & ~case.tracers
    weights = np.where(acting, case.witness.kappa, 0)
    momentum = [Integral(weights[:, None] * axis) for axis in axes] if acting.any() else []
    sites = site_integrals(case)
    return {"momentum": momentum + [Integral(x) for one in sites for x in on_site(case, one, one.linear)],
            "quadratic integrals": [Integral(None, x) for one in sites for x in on_site(case, one, one.quadratic)]}


def on_site(case: Case, one: SiteIntegrals, rows):
    """Each row at its site, zero elsewhere."""
    for row in rows:
        out = np.zeros((case.sites, *row.shape))
        out[one.site] = row
        yield out


def integrals(case: Case, subject, known) -> list[Row]:
    """Momentum, quadratic integrals, energy."""
    return [kept(case, subject, "momentum", known["momentum"], "no rotation leaves H unchanged"),
            kept(case, subject, "quadratic integrals", known["quadratic integrals"], none_said(case)),
            energy(case, subject, known)]


def none_said(case: Case) -> str:
    return "single sites have none" if case.sites <= LARGEST else f"none of the first {LARGEST} sites"


def kept(case: Case, subject, name, found, otherwise) -> Row:
    """The largest change of any of them over one step in extended precision, in ulps of double."""
    if not found:
        return not_applicable(name, otherwise)
    worst = max(change(case, subject, one, *trial) for one in found for trial in case.trials())
    return at_most(name, worst, ULPS, f"{len(found)} found")


def change(case: Case, subject, one: Integral, w, t, h) -> float:
    w = case.long(w)
    return float(abs(one(subject.step(w, t, h)) - one(w))) / (EPS * one.size(w))


def energy(case: Case, subject, known) -> Row:
    """The energy is claimed where H is made of integrals that the method keeps."""
    if case.timed:
        return not_applicable("energy", "H depends on time")
    if subject.energy(case.w, 0.0) is None:
        return not_applicable("energy", "this integrator shows no energy")
    if not made_of(case, [*known["momentum"], *known["quadratic integrals"]]):
        return not_applicable("energy", "not claimed: H is no sum of integrals that the method keeps")
    worst = max(energy_change(case, subject, *trial) for trial in case.trials())
    return at_most("energy", worst, ULPS)


def energy_change(case: Case, subject, w, t, h) -> float:
    w = case.long(w)
    b = case.witness.field(np.array(w, float), t)
    scale = float(np.sum(np.abs(case.witness.kappa) * lengths(w) * lengths(b)))
    gap = abs(subject.energy(subject.step(w, t, h), t) - subject.energy(w, t))
    return float(gap) / (EPS * max(scale, abs(float(subject.energy(w, t))), np.finfo(float).tiny))


def made_of(case: Case, found) -> bool:
    """Is H, at random states, a linear combination of the integrals, the Casimirs and 1?"""
    if not found or case.sites > LARGEST:
        return False
    states = [case.nudged(0.5) for _ in range(4 * (len(found) + case.sites) + 8)]
    try:
        values = np.array([case.witness.energy(w) for w in states])
    except RunError:
        return False
    columns = [[one(w) for w in states] for one in found]
    columns += [[1.0] * len(states), *np.array([case.leaves.values(w.astype(LONG)) for w in states], float).T]
    matrix = np.array(columns, float).T
    fit = matrix @ np.linalg.lstsq(matrix, values, rcond=1e-12)[0]
    return float(np.abs(fit - values).max()) <= FIT * max(np.abs(values).max(), np.finfo(float).tiny)
