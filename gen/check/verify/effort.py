"""What a step costs beside what it should: where its iterations begin, and where they end.

A predictor that is wrong leaves all results right, only later, and an iteration that is left too early still solves the equation to some
ulps: nothing else tells. So iterations are counted from other beginnings of the same steps, put into saved states: the run's own increments
extrapolated here; a history on a polynomial, whose next value is the solution; and the solution itself, from which nothing is left to do.
"""
from __future__ import annotations

from math import comb

import numpy as np

from ...chance import generator
from ...errors import RunError
from ...extremes import largest, with_largest, with_smallest
from ...methods import METHODS
from ...run.step.saved import SCALE, TOLERANCE
from .case import EPS, Case
from .past import Past, another
from .row import Row, at_most, not_applicable

NAMES = ("iterations", "predictor", "settled", "tolerance")
WARM = 33               # steps until every degree was tried and one was chosen
SAMPLES = 32            # steps looked at
WORK = {"quick": 3 * 10**5, "normal": 10**6}    # steps of single sites
RATIO = 1.15            # of the iterations from the best extrapolation, or without a history
MORE = 0.75             # iterations, more than from the solution itself with the round-off of the sum
LEFT = 4                # ulps
FEW = 6                 # of these steps, which end in many ways
MISSED = 8              # times a tolerance: what iterations leave is judged by their last change
TOLERANCES = 10.0 ** -np.arange(3, 11, 0.25)
BEGINNINGS = 10.0 ** -np.arange(0, 15, 0.5)


def effort(case: Case, subject) -> list[Row]:
    """Four rows."""
    one, method = getattr(subject, "double", None), METHODS[case.settings.method]
    if method.how[:1] == ("explicit",):
        return neither("the method is explicit")
    if one is None:
        return neither("this integrator does not save states")
    try:
        path = Steps(case, another(one))
    except RunError as error:
        return neither(f"the steps ended before the history was complete: {error}")
    if path.closed():
        return neither("nothing to iterate: every step has a solution in closed form")
    if not method.midpoint:
        return [cold(path), *neither("its history does not contain increments of steps")[1:3], tolerance(path)]
    return [iterations(path), predictor(path), settled(path), tolerance(path)]


def neither(why) -> list[Row]:
    return [not_applicable(name, why) for name in NAMES]


class Steps:
    """Steps of the run with the saved states before and after each; `trial` takes one of them again from another beginning."""

    def __init__(self, case: Case, one):
        self.one, self.other, self.w, self.h = one, another(one), case.w, case.h
        one.start(case.w.copy(), h=case.h)
        self.other.start(case.w.copy(), h=case.h)
        path = [one.step().save() for _ in range(WARM)]
        self.past, self.steps = Past(path[-1], case.sites), []
        each = case.sites * (3 * len(self.past.degrees) + FEW * (len(TOLERANCES) + len(BEGINNINGS)) // 4)
        for _ in range(max(FEW, min(SAMPLES, case.of_tier(WORK) // each))):
            path.append(one.step().save())
            self.steps.append((path[-2], path[-1], one.report()["iterations"]))
        self.increments = [self.past.row(saved, 0) for saved in path]

    def trial(self, saved) -> tuple[int, np.ndarray]:
        """(iterations, saved state after) of the step from a saved state."""
        self.other.restore(saved).step()
        return self.other.report()["iterations"], self.other.save()

    def extrapolated(self, k: int, degree: int) -> np.ndarray:
        """The polynomial through the degree + 1 increments before the k-th of these steps, at that step."""
        return sum((-1) ** j * comb(degree + 1, j + 1) * self.increments[WARM + k - 1 - j] for j in range(degree + 1))

    def mean(self, begun) -> float:
        """Iterations of a step, on the average, from begun(saved state before, saved state after)."""
        return float(np.mean([self.trial(begun(before, after))[0] for before, after, _ in self.steps]))

    def set_to(self) -> dict:
        """What a state holds where a tolerance is asked for."""
        return {asked: self.one.start(self.w.copy(), h=self.h, tolerance=asked).save()[TOLERANCE] for asked in TOLERANCES}

    def few(self):
        """Some of the steps, far apart."""
        return self.steps[::max(1, len(self.steps) // FEW)][:FEW]

    def closed(self) -> bool:
        """Did no step take an iteration, without a history neither?"""
        return not self.taken() and not self.mean(lambda saved, _: self.past.forgotten(saved))

    def taken(self) -> float:
        return float(np.mean([count for *_, count in self.steps]))


def iterations(path: Steps) -> Row:
    """Those of the run over those from the best extrapolation of its last increments, of one degree for all."""
    past = path.past
    best = {d: float(np.mean([path.trial(past.begun_at(before, path.extrapolated(k, d)))[0] for k, (before, *_) in enumerate(path.steps)]))
            for d in past.degrees}
    degree = with_smallest(best, best.get)
    note = f"{path.taken():.3g} a step; {best[degree]:.3g} from the polynomial of degree {degree}"
    return at_most("iterations", path.taken() / max(best[degree], 1), RATIO, note)


def cold(path: Steps) -> Row:
    """The same of a method that keeps something else: against steps without a history."""
    fresh = path.mean(lambda saved, _: path.past.forgotten(saved))
    return at_most("iterations", path.taken() / max(fresh, 1), RATIO, f"{path.taken():.3g} a step; {fresh:.3g} without a history")


def predictor(path: Steps) -> Row:
    """What a history on a polynomial costs more than the solution itself, off by the round-off of the sum; the worst degree."""
    past, dice = path.past, generator("round-off of a predictor")

    def rounded(saved, after, degree):
        u = past.row(after, 0)
        return past.begun_at(saved, u * (1 + 2 ** degree * EPS * dice.uniform(-1, 1, u.shape)))
    more = {d: path.mean(lambda s, a, d=d: past.along(s, past.row(a, 0), d)) - path.mean(lambda s, a, d=d: rounded(s, a, d))
            for d in past.degrees}
    worst = with_largest(more, more.get)
    return at_most("predictor", largest(more[worst], 0.0), MORE, f"degrees to {max(past.degrees)}; worst: {worst}")


def settled(path: Steps) -> Row:
    """How far steps move that begin where they ended, in ulps of the largest component; they began at many distances from it."""
    past, dice, worst = path.past, generator("beginnings of iterations"), 0.0
    for before, after, _ in path.few():
        for off in BEGINNINGS:
            u = past.row(after, 0)
            ended = path.trial(past.begun_at(before, u * (1 + off * dice.uniform(-1, 1, u.shape))))[1]
            again = path.trial(past.begun_at(before, past.row(ended, 0)))[1]
            worst = largest(worst, past.moved(ended, again))
    return at_most("settled", worst / EPS, LEFT, f"{FEW} steps from {len(BEGINNINGS)} beginnings each")


def tolerance(path: Steps) -> Row:
    """The largest error of steps to tolerances, each in units of its own, with their history and without."""
    past, found, set_to = path.past, {}, path.set_to()
    for before, after, _ in path.few():
        for asked in TOLERANCES:
            for begun in (before, past.forgotten(before)):
                ended = path.trial(past.asked(begun, set_to[asked]))[1]
                error = np.abs(past.state(ended) - past.state(after)).max() / (asked * before[SCALE])
                found[asked] = largest(found.get(asked, 0.0), error)
    worst = with_largest(found, found.get)
    return at_most("tolerance", found[worst], MISSED, f"{len(TOLERANCES)} tolerances; worst: {worst:.0e}")
