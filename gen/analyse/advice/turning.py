"""The field about which each site turns, m' = o C m x F, of a compiled model.

Without dampings and torques F is b = (1/kappa) dH/dw. A torque T adds the field o T x m/|m|^2. A damping makes f g + q m x g of a field g
(`Damping.response`): that of Landau and Lifshitz of b alone, Gilbert's of torques as well. Sites that do not move have none.
"""
from __future__ import annotations

import numpy as np

from ...compile.plan.held import present
from ...effects.damping import Damping
from ...effects.torque import Torque
from ...language.evaluate import evaluate
from ...language.expr import Num
from ...language.instances import instances_of
from ...run.step.evaluated import per_site


class Turning:
    """F of a model."""

    def __init__(self, model):
        self.model, self.numbers = model, model.prepared.numbers
        spec, self.places = self.numbers.spec, self.numbers.places
        self.torques = [self._torque(e) for e in present(spec).of(Torque)]
        self.f, self.q, self.lagging = np.ones(model.sites), np.zeros(model.sites), np.ones(model.sites, bool)
        for damping in spec.of(Damping):
            first, count = self.places[damping.over.family]
            law, sites = damping.response(spec), slice(first, first + count)
            self.f[sites], self.q[sites] = (per_site(e, self.numbers.values, count) for e in (law.f, law.q))
            self.lagging[sites] = law.lag != Num(0)

    def at(self, w, t) -> np.ndarray:
        """(sites, 3)."""
        b = np.asarray(self.model.field(w, t), float)
        with np.errstate(all="ignore"):
            push = self._push(np.asarray(w, float), t)
            g = b + np.where(self.lagging[:, None], push, 0)
            found = self.f[:, None] * g + self.q[:, None] * np.cross(w, g) + np.where(self.lagging[:, None], 0, push)
        return np.where(self.numbers.moving[:, None], found, 0)

    def _torque(self, e) -> tuple:
        """(its formula, what its indices and columns are, the sites that it moves)."""
        indices, columns = instances_of(e.over, self.numbers.values, self.places)
        slot = e.on.slot
        sites = self.places[e.on.family][0] + np.atleast_1d(indices[slot] if isinstance(slot, str) else slot)
        return e.value, {**self.numbers.values, **indices, **columns}, sites

    def _push(self, w, t) -> np.ndarray:
        """The fields of torques."""
        total = np.zeros(w.shape)
        for value, known, sites in self.torques:
            env = {**known, "t": t, "spins": lambda family, slot: w[self.places[family][0] + slot]}
            np.add.at(total, sites, np.broadcast_to(evaluate(value, env), (len(sites), 3)))
        square = np.sum(w * w, axis=1)[:, None]
        return self.numbers.spec.orientation * np.cross(total, w) / np.where(square > 0, square, 1)
