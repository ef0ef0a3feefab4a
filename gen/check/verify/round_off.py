"""Growth of round-off: a random walk, sqrt(N), and no drift, N; and its size.

The rms change of every conserved quantity, over many starts and sites, after N, 10 N and 100 N
steps. Its exponent is the steepest of a fit through the three and of the last decade, in which a
drift that begins below a unit in the last place comes out. The size is that change over sqrt(N): a state that
was moved on the way keeps its exponent, and not its size.

A damped state that has come to rest is a fixed point: every step rounds as the one before, and what that makes has one sign until
|w| has changed by an ulp. It has no exponent below the walk of half a unit a step, sqrt(N)/2, and is judged beyond it.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ...extremes import largest, with_largest
from .case import EPS, Case
from .row import Row, at_most, not_applicable

EXPONENT = 0.6
SIZE = 8                # ulps sqrt(N), as for the Casimirs of the run; rounding w + u makes some tenths of one
SAMPLES = 64            # starts times sites; an exponent is then known to 0.05
AGAIN = 4               # times as many where the first look says no
FLOOR = 1.0             # ulps of change at the end below which there is no law to see
AT_REST = 0.5           # the same over sqrt(steps), of states at rest
STILL = 1e-12           # the part of |w| by which a step moves them at most
WORK = {"quick": 10**6, "normal": 2 * 10**7}    # steps of single sites
SHORTEST = 10


def round_off(case: Case, subject, known) -> list[Row]:
    """Two rows: the largest exponent, and the largest size, of Casimirs and of integrals."""
    steps = length(case)
    if steps < SHORTEST:
        return neither("too few steps to see how errors grow; use a longer run")
    try:
        found = walks(case, subject, known, steps, SAMPLES)
        if largest(*(law(*walk) for _, *walk in found)) > EXPONENT:
            found = walks(case, subject, known, steps, AGAIN * SAMPLES)
    except RunError as error:
        return neither(f"orbits cannot be followed for {100 * steps} steps: {error}")
    case.unseen.append(f"round-off beyond {100 * steps} steps")
    name, rms, floor = with_largest(found, lambda x: law(*x[1:]))
    note = f"{name}: rms {', '.join(f'{x:.2g}' for x in rms)} ulp after {steps}, {10 * steps}, {100 * steps} steps"
    widest, most = with_largest(((name, size_of(rms, steps)) for name, rms, _ in found), lambda x: x[1])
    return [at_most("round-off", law(rms, floor), EXPONENT, note), at_most("round-off size", most, SIZE, widest)]


def neither(why) -> list[Row]:
    return [not_applicable("round-off", why), not_applicable("round-off size", why)]


def size_of(rms, steps) -> float:
    """The largest change over sqrt(N), in ulps."""
    return float(np.max(rms / np.sqrt(steps * np.array([1, 10, 100]))))


def starts_of(case: Case, samples) -> int:
    """At least 4, for sites of one orbit are not independent."""
    return max(4, -(-samples // case.sites))


def length(case: Case) -> int:
    """N: what the tier allows, to one digit."""
    tier = case.tier
    most = tier if isinstance(tier, int) else WORK[tier] // (starts_of(case, SAMPLES) * case.sites)
    steps = max(most // 100, 1)
    unit = 10 ** (len(str(steps)) - 1)
    return steps // unit * unit


def walks(case: Case, subject, known, steps, samples) -> list:
    """(name of the quantity, its three rms changes in ulps, the floor of their law) of each, apart for states that come to rest."""
    starts = np.array([case.nudged(0.1) for _ in range(starts_of(case, samples))])
    counts = [steps, 10 * steps, 100 * steps]
    ends = subject.run(starts, 0.0, case.h, counts)
    rest = at_rest(case, subject, ends[-1], counts[-1] * case.h)
    kinds = ((~rest, "", FLOOR), (rest, " at rest", AT_REST * np.sqrt(counts[-1])))
    return [(name + more, rms, floor) for some, more, floor in kinds if some.any() for name, rms in changes(case, known, starts[some], ends[:, some])]


def at_rest(case: Case, subject, ends, t) -> np.ndarray:
    """Which orbits are damped and end where one more step moves nothing."""
    if not case.scene.damped:
        return np.zeros(len(ends), bool)
    moved = np.abs(subject.run(ends, t, case.h, [1])[0] - ends)
    return moved.max(axis=(1, 2)) <= STILL * np.abs(ends).max(axis=(1, 2))


def changes(case: Case, known, starts, ends):
    """(name, rms change in ulps after each count) of the Casimirs and of every kind of integral."""
    leaves = case.leaves
    gap = (leaves.values(ends) - leaves.values(starts)) / leaves.sizes(starts)
    yield "casimirs", rms_of(gap)
    for name, found in known.by_row().items():
        gaps = [[np.concatenate([one.changes(a, b) for one in found]) for a, b in zip(starts, row)]
                for row in ends if found]
        if gaps:
            yield name, rms_of(np.array(gaps))


def rms_of(gap) -> np.ndarray:
    """Over starts and sites or integrals, for each count; in ulps."""
    return np.sqrt(np.mean(np.square(gap, dtype=float), axis=(1, 2))) / EPS


def law(rms, floor: float = FLOOR) -> float:
    """The exponent of N in the changes; 0 below the floor."""
    if not np.all(np.isfinite(rms)):
        return np.inf
    if rms[-1] <= floor:
        return 0.0
    logs = np.log10(np.maximum(rms, FLOOR / 10))
    return largest((logs[2] - logs[0]) / 2, logs[2] - logs[1])
