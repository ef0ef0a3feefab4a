"""Saved states: a trajectory that is broken off and taken up elsewhere goes on with the bits of the unbroken one.

It is taken up in a trajectory of its own that has been elsewhere, so that nothing which a saved state leaves out is there by chance; and
what it saves at once is what it was given.
"""
from __future__ import annotations


from ...errors import RunError
from .case import Case
from .past import another
from .row import Row, at_most, not_applicable

BREAKS = (0, 1, 2, 5, 13, 16, 33, 64)       # steps: before a history, in its first steps, whole; where degrees are chosen, and between
FOLLOWED = 20           # steps after a break: what was lost to rounding decides a bit in each few of them
WORK = {"quick": 10**5, "normal": 4 * 10**5}    # steps of single sites
TOLERANCE = 1e-6


def restore(case: Case, subject) -> list[Row]:
    """One row: the part of the breaks after which something differs, at the start of the run and at its end."""
    one = getattr(subject, "double", None)
    if one is None:
        return [not_applicable("restore", "this integrator does not save states")]
    one, other, found = another(one), another(one), []
    breaks = BREAKS[:max(3, case.of_tier(WORK) // (case.sites * 3 * (max(BREAKS) + FOLLOWED)) * len(BREAKS))]
    try:
        for t, tolerance in ((0.0, None), (case.end(), None), (0.0, TOLERANCE)):
            path = unbroken(case, one, t, tolerance, max(breaks) + FOLLOWED)
            found += [same(case, other, path, count) for count in breaks if count + 1 < len(path)]
    except RunError as error:
        return [not_applicable("restore", f"orbits cannot be followed: {error}")]
    where = next((said for said in found if said), "")
    note = f"{len(found)} breaks, {FOLLOWED} steps after each{where and '; first: ' + where}"
    return [at_most("restore", sum(map(bool, found)) / len(found), 0, note)]


def unbroken(case: Case, one, t, tolerance, count) -> list:
    """Saved states before and after each step, with the bits of w, as far as steps are taken."""
    one.start(case.w.copy(), t0=t, h=case.h, tolerance=tolerance)
    path = [(one.save(), one.state())]
    while len(path) <= count and one.advance(1):
        path.append((one.save(), one.state()))
    return path


def same(case: Case, other, path, count) -> str:
    """What differs after the break at `count`, "" for nothing."""
    saved, w = path[count]
    other.start(case.nudged(0.1), t0=1.0, h=case.h / 2)
    other.advance(3)
    other.restore(saved)
    if other.state().tobytes() != w.tobytes() or other.save().tobytes() != saved.tobytes():
        return f"the state restored after step {count}"
    for k in range(count + 1, min(count + FOLLOWED + 1, len(path))):
        if not other.advance(1) or other.state().tobytes() != path[k][1].tobytes():
            return f"step {k}, restored after step {count}"
    return ""
