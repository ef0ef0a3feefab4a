"""Integrals that the method must keep: momentum, those of single sites, and an energy made of them.

W - w = h X(m) keeps a.w wherever a.X = 0, and w.(S w) of a single site since W + w is a multiple
of m. One step in extended precision shows the method, up to the round-off of the coefficients of I; the run in
double, after k steps over sqrt(k), what happens on its way. A comparator is asked for what it keeps in exact arithmetic.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

import numpy as np

from ...chance import generator
from ...errors import RunError
from ...extremes import largest
from ...language.held import standing
from ...methods import METHODS
from .case import EPS, Case
from .leaves import LONG, lengths
from .row import Row, at_most, not_applicable
from .symmetries import LARGEST, actions, explained, site_integrals

ULPS = 16
LOOKS = 64              # at the run: a state that was moved stays so
FIT = 1e-11             # distance of H from the span of the integrals that counts as none


@dataclass(frozen=True)
class Integral:
    """numbers: w of shape (sites, 3) -> the numbers that are kept; scale: their size at random states."""
    numbers: Callable
    scale: float

    def changes(self, before, after) -> np.ndarray:
        """Relative changes between states, as an array of floats."""
        gap = np.atleast_1d(self.numbers(after)) - np.atleast_1d(self.numbers(before))
        return np.asarray(gap, float).ravel() / self.scale


@dataclass(frozen=True)
class Known:
    """What there is to keep: the actions, the integrals by row, and whether the energy is claimed."""
    actions: list
    momentum: list
    quadratic: list
    energy: bool

    def by_row(self):
        return {"momentum": self.momentum, "quadratic integrals": self.quadratic}


def known_integrals(case: Case) -> Known:
    """From the numbers of the interpreter and from the symbolic analysis."""
    report = explained(case)
    found, sites = actions(case, report), site_integrals(case)
    said = [i for i in report.integrals if i.kept] if report else []
    momentum = [integral(case, total(case, a)) for a in found if a.mask.all() and not standing(case.scene)]
    momentum += [integral(case, row(one.site, x)) for one in sites for x in one.linear]
    momentum += [integral(case, i.numbers) for i in said if i.kind == "linear"]
    quadratic = [integral(case, form(one.site, x)) for one in sites for x in one.quadratic]
    quadratic += [integral(case, i.numbers) for i in said if i.kind == "quadratic"]
    method = METHODS[case.settings.method]
    if not case.scene.conservative:
        return Known(found, [], [], False)
    momentum, quadratic = momentum if method.keeps_linear else [], quadratic if method.keeps_quadratic else []
    claimed = any(i.kind == "energy" for i in said)
    return Known(found, momentum, quadratic, not case.timed and (claimed or made_of(case, [*momentum, *quadratic])))


def integral(case: Case, numbers) -> Integral:
    """With its size over random directions of all w."""
    dice = generator("sizes of integrals")
    sizes = []
    for _ in range(16):
        v = dice.standard_normal(case.w.shape)
        v *= (lengths(case.w) / lengths(v))[:, None]
        sizes.append(np.abs(np.atleast_1d(numbers(v))).max())
    return Integral(numbers, largest(*sizes, np.finfo(float).tiny))


def total(case: Case, action):
    """w -> sum kappa axis.w over the sites that act on others."""
    acting = action.mask & ~case.tracers & case.numbers.present
    weight = np.where(acting if acting.any() else action.mask, case.witness.kappa, 0)[:, None] * action.axis
    return lambda w: np.einsum("si,si->", weight, w)


def row(site, a):
    """w -> a.w of one site."""
    return lambda w: w[site] @ a.astype(w.dtype)


def form(site, s):
    """w -> w.(S w)/2 of one site."""
    return lambda w: w[site] @ (s.astype(w.dtype) @ w[site]) / 2


def integrals(case: Case, subject, known: Known) -> list[Row]:
    """Momentum, quadratic integrals, energy."""
    return [kept(case, subject, "momentum", known.momentum, no_momentum(case)),
            kept(case, subject, "quadratic integrals", known.quadratic, "no single site has a quadratic integral that the method conserves"),
            energy(case, subject, known)]


def no_momentum(case: Case) -> str:
    method = METHODS[case.settings.method]
    if not case.scene.conservative:
        return case.scene.given_up("momentum")
    if method.keeps_linear:
        return "no rotation leaves H unchanged"
    return "not claimed: the parts of H do not conserve any of them individually" if method.splitting else "not claimed for this method"


def kept(case: Case, subject, name, found, otherwise) -> Row:
    """The largest change of any of them over one step in extended precision, and along the run, in ulps of double."""
    if not found:
        return not_applicable(name, otherwise)
    steps = (change(case, subject, one, *trial) for one in found for trial in case.trials())
    return at_most(name, largest(*steps, *(along(case, one) for one in found)), ULPS)


def along(case: Case, one: Integral) -> float:
    """The largest change after k steps of the run, in ulps sqrt(k); sums of many sites are taken in extended precision."""
    if case.path is None:
        return 0.0
    steps = np.unique(np.linspace(1, len(case.path) - 1, LOOKS).astype(int))
    return largest(*(np.abs(one.changes(*case.path[[0, k]].astype(LONG))).max() / (EPS * np.sqrt(k)) for k in steps))


def change(case: Case, subject, one: Integral, w, t, h) -> float:
    w = case.long(w)
    return float(np.abs(one.changes(w, subject.step(w, t, h))).max()) / EPS


def energy(case: Case, subject, known: Known) -> Row:
    """The energy is claimed where H is made of integrals that the method keeps."""
    if case.timed:
        return not_applicable("energy", "H depends on time")
    if not case.scene.conservative:
        return not_applicable("energy", case.scene.given_up("energy"))
    if not known.energy:
        return not_applicable("energy", "not claimed: H is not a sum of integrals that the method conserves")
    if subject.energy(case.w, 0.0) is None:
        return not_applicable("energy", "this integrator does not provide the energy")
    worst = largest(*(energy_change(case, subject, *trial) for trial in case.trials()))
    return at_most("energy", worst, ULPS)


def energy_change(case: Case, subject, w, t, h) -> float:
    w = case.long(w)
    b = case.witness.field(np.array(w, float), t)
    scale = float(np.sum(np.abs(case.witness.kappa) * lengths(w) * lengths(b)))
    gap = abs(subject.energy(subject.step(w, t, h), t) - subject.energy(w, t))
    return float(gap) / (EPS * largest(scale, abs(subject.energy(w, t)), np.finfo(float).tiny))


def made_of(case: Case, found) -> bool:
    """Is H, at random states, a linear combination of the integrals, the Casimirs and 1?"""
    if not found or case.sites > LARGEST:
        return False
    states = [case.nudged(0.5) for _ in range(4 * (len(found) + case.sites) + 8)]
    try:
        values = np.array([case.witness.energy(w) for w in states])
    except RunError:
        return False
    columns = [np.concatenate([*(np.atleast_1d(one.numbers(w)) for one in found),
                               np.asarray(case.leaves.values(w.astype(LONG)), float), [1.0]]) for w in states]
    matrix = np.array(columns, float)
    fit = matrix @ np.linalg.lstsq(matrix, values, rcond=1e-12)[0]
    return float(np.abs(fit - values).max()) <= FIT * max(np.abs(values).max(), np.finfo(float).tiny)
