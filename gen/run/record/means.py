"""Averages over the outputs of a run, in memory that does not grow with them."""
from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...errors import UsageError
from .statistics import Statistics

BINS = 64           # of a histogram, at most


@dataclass(frozen=True)
class Average:
    """The average of one quantity.

    :ivar mean: the mean. `variance`: the variance.
    :ivar error: the standard error of the mean; None if there are too few samples to estimate it.
    :ivar correlation: the time over which samples are correlated (integrated autocorrelation time); None if it cannot be estimated.
    :ivar histogram: a dictionary with the lower edge `low`, the `width` of the bins, and their `counts`.
    """
    mean: float
    variance: float
    error: float | None
    correlation: float | None
    histogram: dict


class Means:
    """The averages of a run: of the numbers `what` of a model, from the time `after` on.

    see: takes outputs as they come; found: name -> what is known, as metadata have it.
    """

    def __init__(self, model, what, after: float, bins: int, interval: float):
        self.names, self.interval = numbers_of(model, what), interval
        self.at = [model.columns.index(name) for name in self.names]
        self.statistics = Statistics(len(self.names), bins)
        self.first = max(1, math.ceil(after / interval * (1 - 1e-15)))       # outputs before it are none; nor is the start

    def see(self, outputs: np.ndarray, values: np.ndarray) -> None:
        """Outputs by their numbers, 0 for the start, and the columns of each."""
        self.statistics.add(values[outputs >= self.first][:, self.at])

    def found(self) -> dict:
        """As they are if the run ends here; one that was interrupted may go on."""
        ended = copy.deepcopy(self.statistics)
        ended.end()
        return {name: vars(one) for name, one in zip(self.names, averages(ended, self.interval))} if ended.samples else {}


def averages(statistics: Statistics, interval: float) -> Iterator[Average]:
    """error^2 = variance 2 tau/(n dt), tau the correlation time."""
    moments = statistics.levels[0]
    for histogram, mean, variance, error in zip(statistics.histograms, moments.mean, moments.variance(), statistics.errors()):
        correlation = error ** 2 * moments.n * interval / (2 * variance) if variance > 0 else math.nan
        yield Average(float(mean), none(variance), none(error), none(correlation), histogram.table())


def none(x) -> float | None:
    return float(x) if math.isfinite(x) else None


def numbers_of(model, what) -> tuple[str, ...]:
    """Columns of the model. Raises UsageError for a name that is none."""
    known = model.columns
    names = tuple(what) if what else ("energy", *(o.name for o in model.scene.observables))
    for name in names:
        if name not in known:
            raise UsageError(f"{model.name} has no quantity '{name}' to average; there are: {', '.join(known)}")
    return tuple(dict.fromkeys(names))
