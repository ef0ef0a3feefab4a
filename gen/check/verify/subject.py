"""What a certificate looks at: anything that steps. The generated C is one such subject."""
from __future__ import annotations

import typing
from dataclasses import replace

import numpy as np

from ...methods import METHODS
from ...build.binary import digest, identity
from ...language.spec import Spec
from ...run.step.integrator import Integrator
from ...run.settings import Settings, model_of

LONG = np.longdouble


class Subject(typing.Protocol):
    """An integrator under examination. States have shape (sites, 3).

    `step` works in the precision of w, float64 or longdouble: the same map in both. A subject
    without a tangent, a field, an energy or outputs of its own returns None for it.
    """

    def step(self, w: np.ndarray, t: float, h: float) -> np.ndarray:
        """The state after one step from (t, w), with no history of steps before."""

    def run(self, starts: np.ndarray, t: float, h: float, counts) -> np.ndarray:
        """States after each of `counts` (increasing) steps from every start, in float64.

        starts: (k, sites, 3); returns (len(counts), k, sites, 3).
        """

    def tangent(self, w: np.ndarray, t: float, h: float, v: np.ndarray) -> np.ndarray | None:
        """M v of the step from (t, w) for the columns v of shape (columns, sites, 3), in float64."""

    def field(self, w: np.ndarray, t: float) -> np.ndarray | None:
        """b = (1/kappa) dH/dw in the precision of w."""

    def energy(self, w: np.ndarray, t: float) -> float | None:
        """H(t, w) in the precision of w."""

    def outputs(self, w: np.ndarray, t: float) -> dict | None:
        """Column of a run -> its value at (t, w) in the precision of w; and "casimirs", of shape (sites,)."""


class Emitted:
    """The generated C: the library in double, the same text in extended precision, its tangent."""

    def __init__(self, double: Integrator, extended: Integrator, varied: Integrator | None = None):
        self.double, self.extended, self.varied = double, extended, varied
        self.generated = False      # is `double` what the generator gives, so that it can be compiled once more in another way?

    def step(self, w, t, h):
        return self._of(w).start(w.copy(), t0=t, h=h).step().state()

    def run(self, starts, t, h, counts):
        out = np.empty((len(counts), *starts.shape))
        for k, w in enumerate(starts):
            one, done = self.double.start(w.copy(), t0=t, h=h), 0
            for row, count in enumerate(counts):
                out[row, k] = one.steps(count - done).w
                done = count
        return out

    def tangent(self, w, t, h, v):
        if self.varied is None:
            return None
        return np.array(self.varied.start(w.copy(), t0=t, h=h).step().tangent(np.array(v, float)))

    def field(self, w, t):
        return self._any(w).field(w, t)

    def energy(self, w, t):
        return self._any(w).energy(w, t)

    def outputs(self, w, t):
        one = self._of(w).start(w.copy(), t0=t, h=1.0)
        return {**dict(zip(one.columns, one.values())), "casimirs": one.casimirs()}

    def _of(self, w) -> Integrator:
        return self.extended if w.dtype == LONG else self.double

    def _any(self, w) -> Integrator:
        """An integrator in the precision of w with a trajectory, which a field needs none of."""
        one = self._of(w)
        if one._state is None:
            one.start(w.copy(), h=1.0)
        return one


def emitted(spec: Spec, s: Settings, features=()) -> Emitted:
    """The generated code of a run, compiled as users get it; and twice more to be measured."""
    def made(real, *more):
        return model_of(spec, s, real, (*features, *more))
    found = Emitted(made("double"), made("long double"), made("double", "tangent") if "tangent" in METHODS[s.method].features else None)
    found.generated = True
    return found


def fingerprint(scene: Spec, method: str, solver: str, features=()) -> str:
    """Digest of what decides the text of a step: the selected spec, method, solver, features.

    The tangent map is certified with every step, and leaves the step as it is.
    """
    return digest(identity(replace(scene, path="", sources=())), method, solver, tuple(sorted(set(features) - {"tangent"})))
