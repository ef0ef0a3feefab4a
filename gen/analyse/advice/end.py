"""Up to which h steps exist from a state, and what ends them."""
from __future__ import annotations

from dataclasses import dataclass

from .branch import follow
from .cause import effect_of, partners
from .rates import UNKNOWNS
from .trial import Failure, climb, first_step

BEYOND = 1.01           # of the limit: there the generated code says its own
NEAR = 5e-3             # relative difference of two limits that are the same
ALIKE = 0.05            # and of two that have the same cause


@dataclass(frozen=True)
class End:
    """limit: the largest h > 0 with a step, None: no end up to the cap; kind, sites and effect as in `Advice`;
    said: of a trial, what failed."""
    limit: float | None
    kind: str = "open"
    sites: tuple = ()
    effect: str = ""
    said: str = ""


def end_of(model, equation, cap: float) -> End:
    """By the branch of solutions up to `cap`; for many unknowns by trial."""
    if 3 * model.sites > UNKNOWNS:
        good, bad = climb(model, equation.w, equation.t, cap, equation.sign)
        return End(None) if bad is None else of_failure(bad, good)
    branch = follow(equation, cap)
    if not branch.ends:
        return End(None)
    return End(_sharp(model, equation, branch.h), branch.kind, partners(branch), effect_of(model, equation, branch))


def of_failure(bad: Failure, limit: float) -> End:
    """Of a step that failed."""
    return End(limit, "trial", bad.sites, "", f"h = {bad.h:.6g} fails: {bad.message}")


def there(model, equation, failure: Failure, cap: float) -> End:
    """The End at a state of a run where a step failed, with its cause where that can be told."""
    found = end_of(model, equation, cap) if 3 * model.sites <= UNKNOWNS else End(None)
    known = found.limit is not None and abs(found.limit / failure.limit - 1) < ALIKE
    return found if known else of_failure(failure, failure.limit)


def _sharp(model, equation, limit: float) -> float:
    """The limit as the generated code finds it, where it does."""
    bad = first_step(model, equation.w, equation.t, equation.sign * BEYOND * limit)
    return bad.reached if bad is not None and abs(bad.reached / limit - 1) < NEAR else limit
