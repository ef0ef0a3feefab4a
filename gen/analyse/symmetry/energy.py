"""The energy of a state with numpy: a sum over all terms, effect by effect."""
from __future__ import annotations

import numpy as np

from ...language.instances import instances_of
from ...language.evaluate import evaluate
from ...language.spec import Spec
from ...run.step.evaluated import parameter_values, sizes


class Energy:
    """H of a selected spec for parameter values; effects: those that count, None for all."""

    def __init__(self, spec: Spec, values: dict | None = None, effects=None):
        self.env, self.places = parameter_values(spec, values), sizes(spec, values)
        self.terms = [(e, *instances_of(e.over, self.env, self.places)) for e in spec.energies
                      if effects is None or e.name in effects]

    def __call__(self, w, t: float = 0.0) -> float:
        """H(t, w) of a state of shape (sites, 3)."""
        return float(sum(self.parts(w, t).values()))

    def parts(self, w, t: float = 0.0) -> dict:
        """The energy of each effect by name."""
        env = {**self.env, "t": t, "spins": lambda family, slot: w[self.places[family][0] + slot]}
        return {e.name: float(np.sum(_whole(evaluate(e.value, {**env, **indices, **columns}), indices)))
                for e, indices, columns in self.terms}


def _terms(indices) -> int:
    return len(next(iter(indices.values()))) if indices else 1


def _whole(value, indices):
    """A term that depends on no index counts once for each."""
    return np.broadcast_to(value, (_terms(indices),))
