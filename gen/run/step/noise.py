"""Thermal noise: which seed and member a run has, and what it does not go with."""
from __future__ import annotations

from numbers import Integral

import numpy as np

from ...errors import UsageError
from ...language.evaluate import evaluate
from ...language.spec import Spec
from .evaluated import Evaluated

SEEDS, MEMBERS = 2 ** 64, 2 ** 32
WITHOUT = "the noise is different for every h"


def noise_of(scene: Spec, h: float, seed: int | None = None, member: int = 0) -> tuple[int, int] | None:
    """(seed, member) as C takes them, a seed from 2^63 on less 2^64; None without noise. Raises UsageError for those that do not fit, and for h < 0."""
    if not scene.heated:
        if member:
            raise UsageError("`member` selects one of several realisations of the noise, but no effect of the scene has kT")
        return None
    if h < 0:
        raise UsageError("with noise, steps cannot be negative: use a positive h, or remove the effect with kT")
    seed = whole_below(0 if seed is None else seed, SEEDS, "the seed of noise")
    return seed - SEEDS * (seed >= SEEDS // 2), whole_below(member, MEMBERS, "a member")


def noisy(numbers: Evaluated) -> bool:
    """Is a temperature other than 0 with these values of the parameters?"""
    def hot(e):
        return np.any(evaluate(e.kT, {**numbers.values, e.over.index: np.arange(numbers.places[e.over.family][1])}) != 0)
    return any(hot(e) for e in numbers.spec.effects if e.heats)


def whole_below(value, most: int, what: str) -> int:
    """An integer from 0 to most - 1. Raises UsageError."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= value < most:
        raise UsageError(f"{what} must be an integer from 0 to {most - 1}, not {value}")
    return int(value)


def refuse_with_noise(scene: Spec, what: str, why: str = WITHOUT) -> None:
    """Raises UsageError where `what` is asked of a scene with noise."""
    if scene.heated:
        raise UsageError(f"{what} cannot be used with thermal noise, because {why}; remove the effect with kT, or its kT")
