"""A method, a step and a number of members for the error of a mean, of scenes at a temperature: the row of `weak_cost` that is there first."""
from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import UsageError
from .report import duration, label
from .weak import WeakCost, WeakRow


@dataclass(frozen=True)
class WeakChoice:
    """row: the pick (`weak.WeakRow`); members: how many it takes; others: the best rows of the other methods, by time; short: methods that do not get there,
    and why; asked: the error of the mean that was asked for; cost: all that was measured."""
    row: WeakRow
    members: int
    others: list
    short: dict
    asked: float
    cost: WeakCost

    @property
    def settings(self) -> dict:
        """Keywords of `smidgen.run` and `smidgen.average`: method, h and steps."""
        return {"method": self.row.method, "h": self.row.h, "steps": self.row.steps}

    def as_dict(self) -> dict:
        """For JSON."""
        return {**self.settings, "members": self.members, "asked": {"mean": self.asked}, "row": vars(self.row), "others": [vars(r) for r in self.others], "short": self.short}

    def __str__(self) -> str:
        row, f, r = self.row, self.cost.facts, self.cost.reference
        said = [f"{label(row.method)} (--method {row.method}) with h = {row.h:.17g}, {row.steps} steps, {self.members} members",
                f"takes {duration(row.takes(self.asked))} of processor time ({duration(row.ns_step / 1e9)} a step) for an error of {self.asked:g} in the mean of `{f['number']}`, due to the step and to statistics together",
                f"the error due to the step is {row.error:.1e} ± {row.error_error:.1e}, measured against {label(r.method)} with h = {r.h:.4g}, {r.members} members"]
        said += [f"  {label(other.method)}: takes {other.takes(self.asked) / row.takes(self.asked):.3g} times as long, h = {other.h:.4g}" for other in self.others]
        return "\n".join(said + [f"  {label(name)}: {why}" for name, why in self.short.items()])

    def __repr__(self) -> str:
        return f"<WeakChoice {', '.join(f'{word}={value!r}' for word, value in self.settings.items())}, members={self.members}; print() explains it>"


def asked_mean(error, energy, symplectic) -> float:
    """The error of the mean that is asked for. Raises UsageError for what makes no sense at a temperature."""
    if energy is not None or symplectic:
        raise UsageError("at a temperature the energy changes, and steps are not symplectic: ask for the error of a mean (--error 1e-3, and --mean for a quantity other than the energy)")
    if error is None or not 0 < error < math.inf:
        raise UsageError("give the accuracy as a positive error of the mean (--error 1e-3)")
    return float(error)


def weak_choice(cost: WeakCost, error: float) -> WeakChoice:
    """Raises UsageError where no method gets there, and where the reference is not known well enough to tell."""
    if not cost.reference.mean_error < error / 2:
        raise UsageError(f"the mean is known only to within ± {cost.reference.mean_error:.1e}, from {cost.reference.members} members with the smallest step: use more --seconds, or ask for a larger error")
    best = {name: min((r for r in cost.rows if r.method == name), key=lambda r: (r.takes(error), r.status != "", abs(r.error))) for name in dict.fromkeys(r.method for r in cost.rows)}
    short = {name: r.status or f"the error due to the step is {abs(r.error):.1e} ± {r.error_error:.1e} at h = {r.h:.3g}" for name, r in best.items() if r.takes(error) == math.inf}
    good = sorted((r for r in best.values() if r.takes(error) < math.inf), key=lambda r: r.takes(error))
    if not good:
        raise UsageError("no method reaches this accuracy: " + "; ".join(f"{label(n)}: {why}" for n, why in short.items()) + "; a smaller h in the run or more --seconds may help")
    members = math.ceil(good[0].members * good[0].takes(error) / good[0].seconds)
    return WeakChoice(good[0], members, good[1:], short, error, cost)
