"""Symplecticity: the step's tangent map keeps the symplectic form, omega_W(M u, M v) = omega_w(u, v).

M is taken from the step itself, by differences in extended precision: a tangent made from the
solver's own matrix could be symplectic for a step that is not.
"""
from __future__ import annotations

from operator import itemgetter

import numpy as np

from ...extremes import largest, smallest, with_largest
from ...methods import METHODS
from .case import Case
from .leaves import LONG, derivative, frame, lengths
from .row import MOST, NO, Row, at_most, not_applicable

DEFECT = 1e-12
WIDTHS = (1e-3, 1e-4, 1e-5)     # angles of a difference: the wider has less round-off, the narrower less error
FRAMES = {"quick": 4, "normal": 12}     # sites whose two tangent vectors are taken; neighbours stay together
GLOBAL = 4                      # random tangent vectors of all sites at once


def symplectic(case: Case, subject) -> list[Row]:
    """The defect of all sites that act on others, and of the tracers among themselves."""
    if not case.scene.conservative:
        return [not_applicable("symplectic", given_up(case.scene))]
    moving = case.moving
    if not case.tracers.any():
        return [defect_row(case, subject, "symplectic", np.flatnonzero(moving), "" if moving.all() else "of the sites that move")] if moving.any() else [
            not_applicable("symplectic", "no site moves")]
    why = "tracers act on nothing, so together with the other sites they do not form a Hamiltonian system"
    carried = np.flatnonzero(case.tracers & moving)
    rows = [not_applicable("symplectic", why)]
    if (~case.tracers & moving).any():
        rows = [defect_row(case, subject, "symplectic", np.flatnonzero(~case.tracers & moving), "of the sites that are not tracers")]
    return [*rows, defect_row(case, subject, "tracers' area", carried, "")] if carried.size else rows


def given_up(scene) -> str:
    """Why no step is symplectic."""
    return scene.given_up("symplectic")


def defect_row(case: Case, subject, name, sites, note) -> Row:
    found = [(defect(case, subject, w, t, h, sites), h) for w, t, h in case.trials()]
    worst, h = with_largest(found, itemgetter(0))
    steps = "" if len(case.steps()) == 1 else f"worst at h = {h:.3g}"
    if METHODS[case.settings.method].controlled:
        return Row(name, worst, MOST, DEFECT, NO, "the method is not symplectic: the defect is about the size of its tolerance and accumulates")
    method = METHODS[case.settings.method]
    said = "the method is not symplectic" if worst > DEFECT and not method.symplectic and not method.of_midpoints else ""
    return at_most(name, worst, DEFECT, "; ".join(x for x in (said, note, steps) if x))


def defect(case: Case, subject, w, t, h, sites) -> float:
    """Relative defect of the form; the narrowest difference that is needed decides.

    A defect is there at every width; what falls with the width is the error of the difference.
    """
    w = case.long(w)
    v, found = columns(case, w, sites), np.inf
    for width in WIDTHS:
        found = smallest(found, form_defect(case, w, subject.step(w, t, h), v, tangents(case, subject, w, t, h, v, width), sites))
        if found <= DEFECT:
            break
    return found


def form_defect(case: Case, w, after, v, mv, sites) -> float:
    """max |omega_W(M v, M v) - omega_w(v, v)| in units of the largest term of the sums."""
    inside = np.zeros(case.sites, bool)
    inside[sites] = True
    keep = inside[:, None].astype(LONG)
    leaves = case.leaves
    gap = leaves.form(after, mv * keep, mv * keep) - leaves.form(w, v, v)
    n = leaves.normal(after)
    weight = np.abs(leaves.kappa)[:, None] / np.sqrt(leaves.squares(n))[:, None]
    scale = np.einsum("csi,csi,sj->c", mv * keep, mv, np.broadcast_to(weight, (case.sites, 1)))
    return float(np.abs(gap).max() / largest(scale.max(), np.finfo(float).tiny))


def tangents(case: Case, subject, w, t, h, v, width):
    """M v by differences of the step, (columns, sites, 3)."""
    def step(x):
        return subject.step(x, t, h)
    return np.array([derivative(case.leaves, step, w, one, width) for one in v], LONG)


def columns(case: Case, w, sites) -> np.ndarray:
    """Tangent vectors at w: both of some neighbouring sites, and random ones of all sites.

    Scaled so that the form of a site's two vectors is of one size for every strength.
    """
    most = case.of_tier(FRAMES)
    first = int(case.dice.integers(len(sites)))
    chosen = np.roll(sites, -first)[:most]
    normal, frames = case.leaves.normal(w), np.zeros((2, case.sites, 3), LONG)
    for i in sites:
        frames[:, i] = np.array(frame(normal[i])) * lengths(w)[i]
    found = [only(pair, i) for i in chosen for pair in frames]
    if len(sites) > 1:
        found += [mixed(case, frames) for _ in range(GLOBAL)]
    return np.array(found)


def only(vectors, site):
    """The vectors of one site, zero elsewhere."""
    out = np.zeros_like(vectors)
    out[site] = vectors[site]
    return out


def mixed(case: Case, frames):
    """A random tangent vector of all sites."""
    weights = case.dice.uniform(-1, 1, (2, case.sites, 1)).astype(LONG)
    return np.sum(weights * frames, axis=0)
