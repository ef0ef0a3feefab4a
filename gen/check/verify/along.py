"""The run itself: its own steps, with their history, each held against the step equation."""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from ..witness import EQUATIONS
from .case import Case
from .residual import RESIDUAL, worst
from .row import Row, at_least, at_most, not_applicable, refused

WORK = {"quick": 2 * 10**4, "normal": 5 * 10**5}    # steps of single sites
FEWEST = 100


def along(case: Case, subject) -> list[Row]:
    """steps and run: are the run's own steps taken, and what is the largest residual of any of them?"""
    run = max(case.settings.steps, 1)
    count = min(run, max(FEWEST, case.of_tier(WORK) // case.sites))
    case.unseen.append(f"steps after the first {count}" + f" of the run's {run}" * (count < run))
    try:
        ends = subject.run(case.w[None], 0.0, case.h, range(1, count + 1))[:, 0]
    except RunError as error:
        return [refused("steps", str(error)), refused("run", "the run ended before its last step")]
    case.path = np.concatenate([case.w[None], ends])
    return [at_least("steps", count, count), run_row(case, subject, count, run)]


def run_row(case: Case, subject, count, run) -> Row:
    if case.settings.method not in EQUATIONS:
        return not_applicable("run", "the interpreter cannot compute residuals of this method")
    note = f"{'all' if count == run else 'the first'} {count} steps"
    return at_most("run", worst(case, subject, case.path, 0.0, case.h), RESIDUAL, note)
