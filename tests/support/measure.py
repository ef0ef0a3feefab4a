"""Measurements that tests judge and docs/numbers.md shows."""
import numpy as np

from smidgen.check.witness import Witness

from .growth import growth
from .systems import SPHERICAL, model, on_leaf
from .tangent import WIDTH, LongStep, leaves_of, long_start, poisson_defect

STEPS, AGREEMENT, SENSITIVE = 100, 1e-13, 10


def defect(case, method=SPHERICAL, sites=None, steps=20, width=WIDTH, **more):
    """Poisson defect of one step from a generic state: the start, `steps` steps on."""
    return poisson_defect(LongStep(case, method, t=0.3, **more), long_start(case, steps),
                          leaves_of(case), sites, width)


def hundred_steps(case, method=SPHERICAL, **more):
    """(largest distance from the witness's steps, what round-off allows, growth of the tangent map)."""
    compiled = model(case, method, **more).start(case.w.copy(), h=case.h)
    states = [case.w] + [compiled.step().w.copy() for _ in range(STEPS)]
    mine = Witness(case.spec, case.values).steps(case.w, 0.0, case.h, STEPS, method)
    grown = growth(case, method, STEPS, leaves_of(case).radius)
    allowed = AGREEMENT * max(1, np.abs(mine).max()) * (grown if grown > SENSITIVE else 1)
    return np.abs(np.array(states) - mine).max(), allowed, grown


def start_points(count):
    """Starts of one body: points of the sphere, each of shape (1, 3)."""
    return on_leaf(np.random.default_rng(11).standard_normal((count, 3)))[:, None]


def scatter(one, starts, h, counts, quantity):
    """Root mean square change of a quantity of a model after these numbers of steps of h."""
    found = []
    for w in starts:
        one.start(w.copy(), h=h)
        before, done, row = quantity(one), 0, []
        for count in counts:
            row.append(np.sqrt(np.mean((quantity(one.steps(count - done)) - before)**2)))
            done = count
        found.append(row)
    return np.sqrt(np.mean(np.square(found), axis=0))


def energy(one):
    return one.energy()


def casimirs(one):
    return one.casimirs()
