"""What a hard case is: a generator of rows, each a criterion beside a measurement.

    @case("close vortex pair")
    def pair():
        '''One line: what is asked.'''
        yield near("angle of one step", measured, expected, 1e-14)

A row that does not hold, an exception and a case without rows are failures; nothing is skipped.
"""
from dataclasses import dataclass
from typing import Callable, Iterator

import numpy as np

from smidgen.errors import RunError
from smidgen.run.step.status import STATUS

TIERS = ("quick", "long")
CASES: list["Case"] = []
EPS = float(np.finfo(float).eps)
NO_CONVERGENCE, NO_SOLUTION, WRONG_BRANCH, OFF_MANIFOLD = 1, 2, 3, 6


@dataclass(frozen=True)
class Row:
    """One measurement: what it is of, what it must be, what it is, and whether that agrees."""
    what: str
    criterion: str
    measured: str
    holds: bool


@dataclass(frozen=True)
class Case:
    """A named case of a tier; `law` is the module that derives what it must show."""
    name: str
    tier: str
    law: str
    about: str
    rows: Callable[[], Iterator[Row]]

    def run(self) -> list[Row]:
        """All rows; an exception, or no row at all, is a row that fails."""
        found = []
        try:
            found.extend(self.rows())
        except Exception as error:      # any fault whatever is a failed case, never a crash of the suite
            found.append(Row("the case itself", "runs to its end", f"{type(error).__name__}: {error}", False))
        return found or [Row("the case itself", "measures something", "nothing", False)]


def case(name: str, tier: str = "quick"):
    """Register a generator of rows as a case."""
    if tier not in TIERS:
        raise ValueError(f"no tier {tier}")

    def register(rows):
        CASES.append(Case(name, tier, rows.__module__.rpartition(".")[2], " ".join(rows.__doc__.split()), rows))
        return rows
    return register


def near(what: str, measured, expected, tolerance: float) -> Row:
    """|measured - expected| <= tolerance; NaN does not hold."""
    off = abs(float(measured - expected))
    return Row(what, f"{float(expected):.10g} with an error of at most {tolerance:.1e}",
               f"{float(measured):.10g} (error {off:.1e})", off <= tolerance)


def ratio(what: str, measured, expected, tolerance: float) -> Row:
    """|measured/expected - 1| <= tolerance."""
    off = abs(float(measured / expected - 1))
    return Row(what, f"{float(expected):.10g} with a relative error of at most {tolerance:.1e}",
               f"{float(measured):.10g} (relative error {off:.1e})", off <= tolerance)


def below(what: str, measured, bound: float, law: str = "") -> Row:
    """measured <= bound; NaN does not hold."""
    return Row(what, f"at most {bound:.3g}" + (f" = {law}" if law else ""), f"{float(measured):.3g}",
               bool(measured <= bound))


def between(what: str, measured, low: float, high: float) -> Row:
    """low <= measured <= high."""
    return Row(what, f"from {low:.4g} to {high:.4g}", f"{float(measured):.4g}", bool(low <= measured <= high))


def same(what: str, measured, expected) -> Row:
    """Equal numbers, such as counts."""
    return Row(what, f"{expected}", f"{measured}", bool(measured == expected))


def same_bits(what: str, measured, expected) -> Row:
    """Two arrays equal bit for bit, the sign of zero included."""
    measured, expected = np.asarray(measured), np.asarray(expected)
    off = int(np.sum(measured.view(np.int64) != expected.view(np.int64)))
    return Row(what, "the same bits", "the same bits" if off == 0 else f"{off} numbers differ", off == 0)


def attempt(model, count: int = 1) -> RunError | None:
    """Up to `count` steps: the error that ended them, or None."""
    try:
        model.steps(count)
    except RunError as error:
        return error
    return None


def status_of(error: RunError | None) -> str:
    """The name of a status, or ok."""
    return "ok" if error is None else STATUS.get(error.status, (f"status {error.status}",))[0]


def ends(what: str, error: RunError | None, *statuses: int) -> Row:
    """A run must end in a named status, or in one of several."""
    return Row(what, " or ".join(STATUS[s][0] for s in statuses), status_of(error), error is not None and error.status in statuses)


def typed(what: str, error: RunError | None) -> Row:
    """A run must end in any status that has a name."""
    return Row(what, "a named status", status_of(error), error is not None and error.status in STATUS)


def refused(what: str, model, status, sites=None) -> Iterator[Row]:
    """The next step of a started model fails with `status` (or one of several), names sites and leaves every bit and the time alone."""
    w, t, count = model.state(), model.t, model.count
    yield ends(what, attempt(model), *(status if isinstance(status, tuple) else (status,)))
    yield same_bits(f"{what}: state afterwards", model.state(), w)
    yield same(f"{what}: time and count", (model.t, model.count), (t, count))
    if sites is not None:
        report = model.report()
        named = {report["site"], report["partner"]} - {-1}
        yield Row(f"{what}: sites named", f"some of {sorted(sites)}", str(sorted(named)), bool(named) and named <= set(sites))
