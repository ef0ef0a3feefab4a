"""Which sites and which effect make the end of a branch.

At a fold J v = 0 with a left null vector y, and J = 1 - (h/2) sum over the effects of D(X_e P): so the effect with the
largest (h/2) y.D(X_e P) v / y.v makes it; their sum is 1. Uniform rotations, H = B . sum kappa w, are left out: alone they have no fold, and all
that they do is to turn the frame. Where a midpoint runs into a centre or to an edge, it is the effect with the strongest
field there.
"""
from __future__ import annotations

import numpy as np

from ...compile.plan.held import present
from ..symmetry.energy import Energy
from .branch import Branch
from .equation import Nowhere

PARTNER = 0.3           # of the largest entry of the null vector: what counts as taking part
DIFFERENCE = 1e-4       # of the state, in units of its length
SAME = 1e-6             # relative difference of fields that are equal


def partners(branch: Branch) -> tuple:
    """The sites that make the end: one or two that the null vector moves most, or the one that runs into a place."""
    if branch.kind != "fold":
        return (branch.site,)
    size = np.linalg.norm(branch.null, axis=1)
    order = np.argsort(-size)[:2]
    return tuple(sorted(int(k) for k in order if size[k] > PARTNER * size[order[0]]))


def effect_of(model, equation, branch: Branch) -> str:
    """The name of the effect that makes the end; "" where none can be told, as where torques act, which have no energy."""
    if model.scene.pushed:
        return ""
    fields = Fields(model, equation, equation.t + equation.sign * branch.h / 2)
    mbar = equation.w + branch.u / 2
    with np.errstate(all="ignore"):
        try:
            sizes = _bends(fields, mbar, branch) if branch.kind == "fold" else _strengths(fields, mbar, branch.site)
        except Nowhere:
            sizes = _strengths(fields, equation.w, branch.site)
    found = {e: size for e, size in sizes.items() if np.isfinite(size)}
    return max(found, key=found.get) if found else ""


class Fields:
    """b_e = (1/kappa) dH_e/dw of every effect at the time t, by differences of the energies."""

    def __init__(self, model, equation, t: float):
        self.equation, self.t = equation, t
        self.energies = Energy(present(model.scene), model.parameters).parts
        self.kappa = model.prepared.numbers.kappas
        self.active = np.repeat([not f.tracer for f in model.scene.families], [n for _, n in model.families.values()]) & model.prepared.numbers.moving

    def at(self, m) -> dict:
        """effect -> b_e at the midpoints m, shape (sites, 3)."""
        found = {e: np.zeros(m.shape) for e in self.energies(m, self.t)}
        for k in np.ndindex(m.shape):
            d = np.zeros(m.shape)
            d[k] = DIFFERENCE * max(np.linalg.norm(m[k[0]]), 1e-9)
            up, down = self.energies(m + d, self.t), self.energies(m - d, self.t)
            for e in found:
                found[e][k] = (up[e] - down[e]) / (2 * d[k] * self.kappa[k[0]])
        return found

    def motions(self, mbar) -> dict:
        """effect -> its X_e(P(mbar))."""
        m = self.equation.project(mbar)
        normal = np.einsum("sij,sj->si", self.equation.casimir, m)
        return {e: np.cross(normal, b) for e, b in self.at(m).items()}

    def uniform(self) -> set:
        """The effects whose field is one and the same vector at all sites that act, whatever the state."""
        here, there = self.at(self.equation.w), self.at(-0.5 * self.equation.w[::-1])
        return {e for e in here if _same(np.concatenate([here[e][self.active], there[e][self.active]]))}


def _same(rows) -> bool:
    return bool(np.all(np.ptp(rows, axis=0) <= SAME * np.max(np.abs(rows))))


def _bends(fields, mbar, branch) -> dict:
    """(h/2) y.D(X_e P) v / y.v of every effect that is no uniform rotation."""
    left_out = fields.uniform()
    return {e: part for e, part in shares(fields, mbar, branch).items() if e not in left_out}


def shares(fields, mbar, branch) -> dict:
    """(h/2) y.D(X_e P) v / y.v of every effect: near 1 in sum, for J v is near 0."""
    equation, size = fields.equation, DIFFERENCE * np.linalg.norm(mbar)
    up, down = (fields.motions(mbar + sign * size * branch.null) for sign in (1, -1))
    factor = equation.sign * equation.model.scene.orientation * branch.h / (4 * size * np.sum(branch.left * branch.null))
    return {e: factor * np.sum(branch.left * (up[e] - down[e])) for e in up}


def _strengths(fields, mbar, site: int) -> dict:
    return {e: np.linalg.norm(b[site]) for e, b in fields.at(fields.equation.project(mbar)).items()}
