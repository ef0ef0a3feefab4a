"""States over the whole space: short runs from everywhere, each step held against the step equation.

Starts are spread evenly over every sphere, in another order on each. An increment that is wrong in
a part of a sphere shows when a state lies there; how large a part may go unseen is measured: the
largest cap of any sphere that holds no state of a last step.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ...extremes import largest
from ..witness import EQUATIONS
from .case import Case
from .leaves import lengths
from .residual import RESIDUAL, worst
from .row import Row, at_most, not_applicable

MOST = 256              # states: the gaps between them are then below a fiftieth of a sphere
FEWEST = 16
WORK = {"quick": 4096, "normal": 16384}     # states times sites
ACCEPTED = 2 * RESIDUAL # ulps: a long step may itself leave as much as RESIDUAL (SMG_VOUCHED in the C), beside the rounding of W
FOLLOW = 20             # steps from each state: a single sphere takes the way that it takes from then on after 16
FAR = 1.0               # angle that a step may turn the fastest site by; where it is faster, h is halved
NARROW = 0.05           # |C|/(|w|.|A||w|): nearer to the cone C = 0 the projection is ill-conditioned
GRID = 1024             # points of a sphere among which the emptiest is sought
GRIDDED = 64            # sites for which it is


def whole_space(case: Case, subject) -> list[Row]:
    """One row: the largest residual in ulps, from all the states that are not refused."""
    if case.settings.method not in EQUATIONS:
        return [not_applicable("whole space", "the interpreter cannot compute residuals of this method")]
    starts = spread(case, max(FEWEST, min(MOST, case.of_tier(WORK) // case.sites)))
    found, ends = 0.0, []
    for (t, h), group in groups(case, starts).items():
        for states in paths(subject, np.array(group), t, h):
            found = largest(found, worst(case, subject, states, t, h))
            ends.append(states[-1])
    if not ends:
        return [not_applicable("whole space", "no step succeeds from any of the states")]
    return [at_most("whole space", found, ACCEPTED, said(case, len(starts), np.array(ends)))]


def said(case: Case, asked, ends) -> str:
    """What was seen; what was not is kept for the certificate."""
    gap = f"{100 * largest_gap(ends[:, case.moving] if case.moving.any() else ends):.2g} %"
    case.unseen.append(f"states other than those of the run, those near its start, and {len(ends)} spread over the whole "
                       f"space (the largest cap without any of them is {gap} of the sphere of a site)")
    left_out = f", {asked - len(ends)} more were refused" * (asked > len(ends))
    return f"{FOLLOW} steps from {len(ends)} states{left_out}; the largest empty cap is {gap} of a sphere"


def directions(count) -> np.ndarray:
    """(count, 3): unit vectors, evenly spread (Fibonacci's lattice)."""
    k = np.arange(count) + 0.5
    z, phi = 1 - 2 * k / count, k * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def spread(case: Case, count) -> np.ndarray:
    """(count, sites, 3): every direction of every site; off spheres at half to twice the length of the start.

    A site of a Nambu factor stays as it is where the direction is near the cone C = 0.
    """
    dice, even = case.dice, directions(count)
    turns = np.linalg.qr(dice.standard_normal((case.sites, 3, 3)))[0]
    w = np.stack([(even @ turn.T)[dice.permutation(count)] for turn in turns], axis=1)
    sphere = ~np.isnan(case.leaves.radius)
    factor = np.where(sphere, 1, 2 ** dice.uniform(-1, 1, (count, case.sites)))
    w = w * (lengths(case.w) * factor)[..., None]
    narrow = np.abs(case.leaves.values(w)) < NARROW * case.leaves.sizes(w)
    w = np.where(narrow[..., None], case.w, w)
    return np.array([case.placed(x) for x in w])


def groups(case: Case, starts) -> dict:
    """{(t, h): states}: the busiest times in turn, or start and end of the run; its h, halved while the fastest site turns too far."""
    found, times = {}, case.times()[:4] if case.timed else [0.0, case.end()]
    for k, w in enumerate(starts):
        t = times[k % len(times)]
        try:
            angle = abs(case.h) * case.fastest(w, t)
        except RunError:
            continue
        h = case.h / 2 ** max(0, int(np.ceil(np.log2(max(angle, FAR) / FAR))))
        found.setdefault((t, h), []).append(w)
    return found


def paths(subject, starts, t, h) -> list:
    """Each start with the states after it, (FOLLOW + 1, sites, 3); without those that the subject refuses."""
    try:
        ends = subject.run(starts, t, h, range(1, FOLLOW + 1))
        return list(np.concatenate([starts[None], ends]).swapaxes(0, 1))
    except RunError:
        return [path for w in starts for path in paths(subject, w[None], t, h)] if len(starts) > 1 else []


def largest_gap(ends) -> float:
    """The largest part of a sphere that is a cap without any of the directions ends[:, site]."""
    grid, unit = directions(GRID), ends / np.maximum(lengths(ends), np.finfo(float).tiny)[..., None]
    nearest = [(grid @ unit[:, site].T).max(axis=1).min() for site in range(min(ends.shape[1], GRIDDED))]
    return float((1 - min(nearest)) / 2)
