"""The generated tangent map: the derivative of the step that was taken, and symplectic itself.

A tangent made from the solver's matrix stays symplectic for a wrong H, and right differences
tell nothing of the generated tangent: both are asked for.
"""
from __future__ import annotations

import numpy as np

from ...extremes import smallest
from .case import EPS, Case
from .leaves import LONG, lengths
from .row import Row, at_most, not_applicable
from .symplectic import WIDTHS, columns, form_defect, given_up, tangents

DERIVATIVE = 1e-9
ULPS = 256              # of the symplectic form, in double precision


def tangent(case: Case, subject) -> list[Row]:
    """Two rows: against differences, and its own defect; the sites that act on others."""
    if not lengths(case.w).all():
        case.unseen.append("the tangent map: it is refused beside a zero vector")
        return neither("tangent maps beside a zero vector are refused")
    moving = case.moving
    sites = next((found for mask in (~case.tracers & moving, moving) if (found := np.flatnonzero(mask)).size), np.arange(case.sites))
    found = [compared(case, subject, w, t, h, sites) for w, t, h in case.trials()]
    if any(one is None for one in found):
        return neither("this integrator has no tangent map")
    apart, defect = np.max(found, axis=0)
    form = at_most("tangent symplectic", defect, ULPS * EPS) if case.scene.conservative else not_applicable("tangent symplectic", given_up(case.scene))
    return [at_most("tangent map", apart, DERIVATIVE), form]


def neither(why: str) -> list[Row]:
    return [not_applicable("tangent map", why), not_applicable("tangent symplectic", why)]


def compared(case: Case, subject, w, t, h, sites):
    """(distance from differences in units of the largest entry, relative defect of the form)."""
    w = case.long(w)
    v = columns(case, w, sites)
    mine = subject.tangent(np.array(w, float), t, h, np.array(v, float))
    if mine is None:
        return None
    apart = smallest(*(np.abs(mine - ref).max() / np.abs(ref).max()
                       for ref in (tangents(case, subject, w, t, h, v, width) for width in WIDTHS[:2])))
    return apart, form_defect(case, w, subject.step(w, t, h), v, mine.astype(LONG), sites)
