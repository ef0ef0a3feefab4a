"""Equivariance: a turn R that leaves H unchanged commutes with the step, step(R w) = R step(w)."""
from __future__ import annotations

import numpy as np

from ...extremes import largest
from ...methods import METHODS
from .case import EPS, Case, size
from .reversible import stretch
from .row import Row, at_most, not_applicable
from .symmetries import Action

ULPS = 32
ANGLE = 0.7


def equivariant(case: Case, subject, actions) -> list[Row]:
    """The worst of all turns, states, steps and both precisions, in ulps."""
    if not METHODS[case.settings.method].equivariant:
        return [not_applicable("equivariant", "the method treats the axes in turn")]
    if not actions:
        return [not_applicable("equivariant", f"no rotation leaves H{' and the torques' * bool(case.scene.pushed)} unchanged")]
    found = [apart(case, subject, x, t, h, action) for w, t, h in case.trials()
             for x in (w, case.long(w)) for action in actions]
    return [at_most("equivariant", largest(*found), ULPS, said(case, actions))]


def apart(case: Case, subject, w, t, h, action: Action) -> float:
    """|step(R w) - R step(w)| in ulps of double that the step may stretch: the axis is a double."""
    after = subject.step(w, t, h)
    there = action(case, w, ANGLE)
    gap = float(np.abs(subject.step(there, t, h) - action(case, after, ANGLE)).max())
    return gap / (EPS * largest(size(w), size(there)) * stretch(subject, w, after, t, h))


def said(case: Case, actions) -> str:
    """The axes in words, family by family."""
    words = []
    for mask in {action.mask.tobytes(): action.mask for action in actions}.values():
        axes = [a.axis for a in actions if np.array_equal(a.mask, mask)]
        names = [name for name, (first, _) in case.witness.families.items() if mask[first]]
        words.append(axes_said(axes) + ("" if mask.all() else f" of {', '.join(names)}"))
    return "; ".join(words)


def axes_said(axes) -> str:
    if len(axes) == 3:
        return "all rotations"
    return "about " + ", ".join("(" + ", ".join(f"{x:.4g}" for x in axis) + ")" for axis in axes)
