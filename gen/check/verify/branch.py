"""The branch: what a long step returns is the solution connected to W = w at h = 0, or it is refused.

The step equation may have other solutions, right to round-off. Steps that turn sites far are asked for, from states
over the whole space and from such as nearly repeat after a few sites: from these Newton's method reaches another
solution more often. The increment d of each that is taken is followed back, F(d, p h) = 0 with p from 1 down to 0, by the interpreter's F and
F'. On the right branch F' stays regular all the way from F' = 1 at p = 0. On another one p cannot reach 0: the
curve turns in a fold, where F' is singular, or det F' < 0 from the start.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ..witness import EQUATIONS
from .case import Case
from .leaves import lengths
from .residual import cancelled
from .row import Row, at_most, not_applicable
from .whole_space import spread

SHARE = 0.05            # of the steps followed back; see docs/verify.md for what was measured
ANGLES = np.geomspace(0.5, 16, 24)      # |h b| of the fastest site, ascending; most systems have one solution below
JUMP = 0.25             # of |w|, by which the increment changes between two angles where it may have left its branch
SUSPECTS = 4            # increments of a state that are followed back
PERIODS = (1, 2, 3, 5)  # sites after which a state nearly repeats; 1: it does not
NEARLY = 0.1
DIGITS = 1e6            # round-off may grow to so many ulps in the field; where sites nearly meet there is nothing to tell
WORK = {"quick": 96, "normal": 640}    # states times sites, for F' is a dense matrix
STATES = (4, 16, 96)    # the fewest; the most for --quick, and otherwise
LARGEST = 32            # sites
CLOSE = 0.1             # of |w|: the largest correction of a good prediction
SETTLED = 1e-9
ITERATIONS = 6
PACES = 200
SHORTEST = 1e-4         # of h
FOLD = 0.1              # singular value of F' below which a pace that has become so short means a fold
CONTRACTS = 0.5         # row sums of |F' - 1|: the only solution near is the one that goes to 0 with p


def branch(case: Case, subject) -> list[Row]:
    """One row: which part of the long steps that were followed back ended on another branch."""
    if case.settings.method not in EQUATIONS:
        return [not_applicable("branch", "the interpreter cannot compute residuals of this method")]
    if case.sites > LARGEST:
        case.unseen.append(f"whether long steps end on another branch (more than {LARGEST} sites)")
        return [not_applicable("branch", f"more than {LARGEST} sites: the interpreter's matrix is dense")]
    taken, found = 0, []
    for w, t, unit in places(case):
        tried = [(angle * unit, step(subject, w, t, angle * unit)) for angle in ANGLES]
        taken += sum(after is not None for _, after in tried)
        found += [judged(case, w, after - w, t, h) for h, after in suspects(w, tried)]
    case.unseen.append(f"whether steps other than the {taken} long ones tried are on the branch")
    return [followed(case, taken, found)]


def followed(case: Case, taken: int, found) -> Row:
    """The row of what was found of each step that was followed back: True, False, or None where the way back gets lost."""
    decided, wrong = [one for one in found if one is not None], found.count(False)
    if not decided:
        case.unseen.append("whether long steps end on another branch: none could be followed back")
        return not_applicable("branch", f"none of {taken} long steps could be followed back to h = 0")
    lost = len(found) - len(decided)
    if lost:
        case.unseen.append(f"whether {lost} of the long steps are on the branch: they could not be followed back")
    note = f"{taken} long steps, {len(decided)} followed back to h = 0{f', {lost} others undecided' * (lost > 0)}; on another branch: {wrong}"
    return at_most("branch", wrong / len(decided), SHARE, note)


def places(case: Case):
    """(w, t, h): states over the whole space, with the step that turns the fastest site by 1."""
    times, (few, quick, many) = case.times()[:4], STATES
    count = max(few, min(quick if case.tier == "quick" else many, case.of_tier(WORK) // case.sites))
    for k, w in enumerate(repeated(case, spread(case, count))):
        t = times[k % len(times)]
        try:
            fastest = case.fastest(w, t)
            lost = float(cancelled(case, w, t).max())
        except RunError:
            continue
        if fastest > 0 and lost < DIGITS * fastest * np.abs(w).max():
            yield w, t, float(np.copysign(1 / fastest, case.h))


def suspects(w, tried):
    """(h, W) of the longest step, and of those after a jump of the increment or after a refusal."""
    found, last = dict(x for x in tried[-1:] if x[1] is not None), np.zeros_like(w)
    for h, after in tried:
        if after is not None and (last is None or np.abs(after - w - last).max() > JUMP * np.abs(w).max()):
            found[h] = after
        last = None if after is None else after - w
    return list(found.items())[:SUSPECTS]


def repeated(case: Case, states):
    """The states in turn as they are, and with sites that nearly repeat after a few."""
    for k, w in enumerate(states):
        period = PERIODS[k % len(PERIODS)]
        again = w[np.arange(case.sites) % period] + NEARLY * lengths(w)[:, None] * case.dice.uniform(-1, 1, w.shape)
        yield w if period == 1 else case.placed(again)


def step(subject, w, t, h):
    """The state after the step, None where it is refused."""
    try:
        after = subject.step(w, t, h)
    except RunError:
        return None
    return after if np.all(np.isfinite(after)) else None


def judged(case: Case, *step) -> bool | None:
    """Is the step on the right branch? None where the way back gets lost."""
    try:
        return connected(case, *step)
    except (RunError, np.linalg.LinAlgError):
        return None


def connected(case: Case, w, d, t, h) -> bool | None:
    """Is the solution d of the step from w connected to d = 0 at h = 0?"""
    def equation(d, p):     # the field stays that of t + h/2
        return case.witness.equation(w, d, t + (1 - p) * h / 2, p * h, case.settings.method)
    reach = np.maximum(lengths(w), np.finfo(float).tiny)[:, None]
    part, pace = 1.0, 1 / 16
    point = newton(equation, d, part, reach)
    for _ in range(PACES):
        if point is None:
            return None
        d, jacobian = point
        if np.linalg.det(jacobian) <= 0:
            return False
        if np.abs(jacobian - np.eye(d.size)).sum(axis=1).max() < CONTRACTS and np.all(np.abs(d) < CONTRACTS * reach):
            return True
        point, part, pace = back(equation, d, jacobian, part, pace, reach)
        if point is None and np.linalg.svd(jacobian, compute_uv=False)[-1] < FOLD:
            return False
    return None


def back(equation, d, jacobian, part, pace, reach):
    """(point, p, pace) at a smaller p; point None where p cannot be made smaller."""
    slope = np.linalg.solve(jacobian, d.ravel() / part)        # F = d - p h X(m) = 0: F' dd/dp = h X = d/p
    while pace > SHORTEST * part:
        target = part * (1 - pace)
        try:
            point = newton(equation, d + (target - part) * slope.reshape(d.shape), target, reach)
        except (RunError, np.linalg.LinAlgError):
            point = None
        if point is not None and np.linalg.det(point[1]) > 0:
            return point, target, min(2 * pace, 0.25)
        pace /= 2
    return None, part, pace


def newton(equation, d, part, reach):
    """(d, F') where F(d) = 0, from a d that is CLOSE; None without convergence."""
    last = CLOSE
    for _ in range(ITERATIONS):
        f, jacobian = equation(d, part)
        move = np.linalg.solve(jacobian, f.ravel()).reshape(d.shape)
        d, size = d - move, float(np.max(np.abs(move) / reach))
        if size <= SETTLED:
            return d, jacobian
        if not size <= last:
            return None
        last = size / 2
    return None
