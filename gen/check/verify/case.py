"""What is examined and where: the run, the independent interpreter, states and times to look at."""
from __future__ import annotations

import math

import numpy as np

from ...chance import generator
from ...compile.select import select
from ...errors import RunError
from ...extremes import largest
from ...language.expr import timed
from ...language.spec import Spec
from ...run.settings import Settings
from ...run.step.start import given_or_at, put_away
from ..witness import LARGEST_DENSE, Witness
from .leaves import LONG, Leaves, lengths

SEED = 20170501
EPS = 2.0 ** -52
LONG_EPS = float(np.finfo(LONG).eps)
NUDGES = (0.3, 0.1, 0.03, 0.01)     # how far a state may lie from the start, in units of |w|
CANDIDATES = 64                     # times of the run among which the busiest are chosen
TURN = 0.25                         # angle that a probing step turns the fastest site by


class Case:
    """A run to certify. w: its start (sites, 3); h: its step; probe: a larger one, or h."""

    def __init__(self, spec: Spec, settings: Settings, states: int, seed: int = SEED, tier="normal", features=(),
                 layouts: bool = False):
        s = self.settings = settings
        self.spec, self.scene = spec, select(spec, s.effects, s.parameters)
        self.numbers = s.numbers.of(self.scene)
        self.witness = Witness(spec, s.parameters, s.effects)
        self.leaves = Leaves(s.numbers.kappas.astype(LONG), s.numbers.casimir_matrices.astype(LONG), s.numbers.radii)
        self.dice = generator("verify", seed)
        self.w, self.h, self.sites = self._start(), s.h, self.witness.sites
        self.timed = any(timed(*e.formulas.values()) for e in self.scene.effects)
        self.small = self.sites <= LARGEST_DENSE
        self.tracers = self._tracers()
        self.probe = self._probe()
        self.wanted, self.points, self.tier, self.features = states, [], tier, tuple(features)
        self.layouts = layouts  # are threads, wavefronts and ranks to be looked at?
        self.path = None        # the run's own states, (steps + 1, sites, 3), once it was taken
        self.unseen = []        # what was not looked at, in words

    def _start(self):
        s = self.settings
        if s.start is None and not self.spec.starts:
            return self.placed(self.dice.standard_normal((self.witness.sites, 3)))
        return given_or_at(self.numbers, s.start, s.seed)

    def of_tier(self, table: dict):
        """The entry of the tier; a number of steps asks for the normal one."""
        return table.get(self.tier, table["normal"])

    def _tracers(self):
        """Mask of the sites that act on nothing."""
        found = np.zeros(self.witness.sites, bool)
        for family in self.spec.families:
            first, count = self.witness.families[family.name]
            found[first:first + count] = family.tracer
        return found

    def _probe(self):
        """A step that turns the fastest site by TURN: a defect of order h^3 does not hide at a small h."""
        fastest = largest(*(self.fastest(self.w, t) for t in self.times()[:4]))
        h = TURN / fastest if fastest > 0 else abs(self.h)
        return float(np.copysign(max(h, abs(self.h)), self.h))

    def times(self) -> list[float]:
        """Times of the run, those first at which the vector field changes most within a step.

        A frozen time shows where dX/dt is large, not where it vanishes. Without time dependence: 0.
        """
        if not self.timed:
            return [0.0]
        span = self.end()
        grain, dice = 2.0 ** min(math.frexp(span)[1], 0) / 1024, generator("times")     # t + h is then exact
        found = [0.0, *(float(np.round(span * x / grain) * grain) for x in np.sort(dice.uniform(size=CANDIDATES)))]
        return sorted(found, key=lambda t: -self.change(t))

    def end(self) -> float:
        """Where the run ends."""
        return self.h * max(self.settings.steps, 1)

    def change(self, t: float) -> float:
        """max |X(t + h/2) - X(t)| at the start."""
        at = self.witness.vector_field
        return float(np.abs(at(self.w, t + self.h / 2) - at(self.w, t)).max())

    def fastest(self, w, t: float) -> float:
        """|R| of the site where it is largest, w' = grad C(w) x R: the field, and what dampings and torques add to it."""
        return float(lengths(self.witness.turning(w, t)).max())

    @property
    def moving(self) -> np.ndarray:
        """Which sites move; a zero vector of R^3 does not."""
        return self.numbers.moving & (lengths(self.w) > 0)

    def placed(self, w) -> np.ndarray:
        """w on its spheres, with absent sites where they are kept."""
        return put_away(self.numbers, np.array(self.leaves.polished(w), float))

    def nudged(self, size: float) -> np.ndarray:
        """A state about size*|w| away from the start, on its spheres."""
        away = self.w + size * lengths(self.w)[:, None] * self.dice.uniform(-1, 1, self.w.shape)
        return self.placed(away)

    def find_states(self, subject) -> None:
        """points: (w, t) of the start and of states beside it, at the busiest times.

        A state that the subject refuses is sought nearer to the start.
        """
        times = self.times()
        self.points = [(self.w, 0.0)]
        for k in range(self.wanted - 1):
            t = times[k % len(times)]
            w = next((w for w in map(self.nudged, NUDGES) if self.takes(subject, w, t, self.h)), None)
            if w is not None:
                self.points.append((w, t))
        while self.probe != self.h and not all(self.takes(subject, w, t, self.probe) for w, t in self.points):
            self.probe = self.probe / 2 if abs(self.probe) > 2 * abs(self.h) else self.h

    @staticmethod
    def takes(subject, w, t, h) -> bool:
        """Can the subject step here and back?"""
        try:
            return bool(np.all(np.isfinite(subject.step(subject.step(w, t, h), t + h, -h))))
        except RunError:
            return False

    def steps(self):
        """The steps to look at: the run's, and the probing one if larger."""
        return [self.h] if self.probe == self.h else [self.h, self.probe]

    def trials(self):
        """(w, t, h) of every state with every step."""
        return [(w, t, h) for w, t in self.points for h in self.steps()]

    def long(self, w):
        """w in extended precision, exactly on its spheres."""
        return self.leaves.polished(w.astype(LONG))


def size(w) -> float:
    """Largest component: a unit in its last place is what round-off is measured by."""
    return float(np.abs(w).max())


def ulp(w) -> float:
    """A unit in the last place of numbers of the size and precision of w."""
    return (LONG_EPS if w.dtype == LONG else EPS) * size(w)
