"""Equivariance: a rotation R that leaves H unchanged commutes with the step, step(R w) = R step(w)."""
from __future__ import annotations

import numpy as np

from .case import Case, ulp
from .leaves import LONG
from .reversible import stretch
from .row import Row, at_most, not_applicable
from .symmetries import rotation, turned

ULPS = 32
ANGLE = 1.1


def equivariant(case: Case, subject, axes) -> list[Row]:
    """The worst of all axes, states, steps and both precisions, in ulps."""
    if not len(axes):
        return [not_applicable("equivariant", "no rotation leaves H unchanged")]
    found = [apart(case, subject, x, t, h, axis) for w, t, h in case.trials()
             for x in (w, case.long(w)) for axis in axes]
    return [at_most("equivariant", max(found), ULPS, said(axes))]


def apart(case: Case, subject, w, t, h, axis) -> float:
    """|step(R w) - R step(w)| in ulps that the step may stretch."""
    turn = rotation(axis, ANGLE, LONG)
    after = subject.step(w, t, h)
    other = subject.step(turned(case, w, turn), t, h)
    gap = float(np.abs(other - turned(case, after, turn)).max())
    return gap / (ulp(w) * stretch(subject, w, after, t, h))


def said(axes) -> str:
    """The axes in words."""
    if len(axes) == 3:
        return "all rotations"
    return "about " + ", ".join("(" + ", ".join(f"{x:.4g}" for x in axis) + ")" for axis in axes)
