"""Means, variances, standard errors and histograms of numbers that come one after the other, in memory that does not grow with them.

Samples come in members: stretches of one trajectory each. They are taken in blocks of SIZE, counted from the start of a member, so that
the result depends on the samples alone, not on how many were handed over at once; what a killed run has saved goes on to the same bits.

The standard error counts correlation. Of many members it is that of the means of members, which are independent. Of few it is found by blocking
(Flyvbjerg and Petersen 1989, doi:10.1063/1.457480): level l has the means of 2^l samples in a row, and of the highest level that has
FEWEST of them the error is taken as if they were independent.
"""
from __future__ import annotations

import math

import numpy as np

SIZE = 1024         # samples of a block: 2^DEPTH
DEPTH = 10
FEWEST = 32         # members, or means of a level, that tell a standard error


class Moments:
    """Number, mean and sum of squared deviations of rows of numbers, one for each column."""

    def __init__(self, columns: int):
        self.n, self.mean, self.square = 0, np.zeros(columns), np.zeros(columns)

    def add(self, rows: np.ndarray) -> None:
        """Chan, Golub and LeVeque: the moments of two parts from those of each."""
        n, mean = len(rows), rows.mean(0)
        away = mean - self.mean
        self.square += ((rows - mean) ** 2).sum(0) + away ** 2 * (self.n * n / (self.n + n))
        self.mean += away * (n / (self.n + n))
        self.n += n

    def variance(self) -> np.ndarray:
        return self.square / (self.n - 1) if self.n > 1 else np.full(len(self.mean), np.nan)

    def facts(self) -> list:
        return [self.n, self.mean.tolist(), self.square.tolist()]

    def go_on(self, facts) -> Moments:
        self.n, self.mean, self.square = facts[0], np.array(facts[1]), np.array(facts[2])
        return self


class Histogram:
    """Counts in at most `bins` bins whose width, a power of two, doubles where the samples ask for it; edges are its multiples."""

    def __init__(self, bins: int):
        self.bins, self.power, self.counts = bins, None, {}

    def add(self, x: np.ndarray) -> None:
        x = x[np.isfinite(x)]
        if not len(x):
            return
        largest = math.frexp(float(np.abs(x).max()))[1] - 50        # bins are then numbered by integers that a double holds
        self.power = largest if self.power is None else self.power
        self.widen(max(0, largest - self.power))
        found, counts = np.unique(np.floor(np.ldexp(x, -self.power)).astype(np.int64), return_counts=True)
        for k, count in zip(found.tolist(), counts.tolist()):
            self.counts[k] = self.counts.get(k, 0) + count
        while max(self.counts) - min(self.counts) >= self.bins:
            self.widen(1)

    def widen(self, times: int) -> None:
        """Double the width so many times."""
        merged: dict = {}
        for k, count in self.counts.items():
            merged[k >> times] = merged.get(k >> times, 0) + count
        self.power, self.counts = self.power + times, merged

    def table(self) -> dict:
        """low: the lower edge of the first bin; width; counts."""
        if not self.counts:
            return {"low": 0.0, "width": 0.0, "counts": []}
        first, last, width = min(self.counts), max(self.counts), math.ldexp(1.0, self.power)
        return {"low": first * width, "width": width, "counts": [self.counts.get(k, 0) for k in range(first, last + 1)]}

    def facts(self) -> list:
        return [self.power, sorted(self.counts.items())]

    def go_on(self, facts) -> Histogram:
        self.power, self.counts = facts[0], {k: count for k, count in facts[1]}
        return self


class Statistics:
    """Of the samples of several quantities; rows come by `add`, and `end` closes a member."""

    def __init__(self, columns: int, bins: int):
        self.columns, self.levels, self.pending = columns, [Moments(columns)], {}
        self.rest, self.member, self.members = np.empty((0, columns)), Moments(columns), Moments(columns)
        self.histograms = [Histogram(bins) for _ in range(columns)]

    def add(self, rows: np.ndarray) -> None:
        self.rest = np.concatenate([self.rest, np.asarray(rows, float)])
        while len(self.rest) >= SIZE:
            self.block(self.rest[:SIZE])
            self.rest = self.rest[SIZE:]

    def end(self) -> None:
        """The next samples are those of another trajectory."""
        if len(self.rest):
            self.block(self.rest)
        if self.member.n:
            self.members.add(self.member.mean[None])
        self.rest, self.pending, self.member = self.rest[:0], {}, Moments(self.columns)

    def block(self, rows: np.ndarray) -> None:
        """SIZE samples, or the last ones of a member. numpy adds up each column as it lies in memory: here in one piece, wherever the rows come from."""
        rows = np.asfortranarray(rows)
        self.member.add(rows)
        for histogram, column in zip(self.histograms, rows.T):
            histogram.add(column)
        whole = len(rows) == SIZE
        self.of_level(0, rows)
        for level in range(1, DEPTH + 1):
            rows = (rows[0:len(rows) // 2 * 2:2] + rows[1::2]) / 2
            if not len(rows):
                return
            self.of_level(level, rows)
        if whole:
            self.carry(DEPTH, rows)

    def of_level(self, level: int, rows: np.ndarray) -> None:
        if level == len(self.levels):
            self.levels.append(Moments(self.columns))
        self.levels[level].add(rows)

    def carry(self, level: int, row: np.ndarray) -> None:
        """Two means of a level in a row are one of the next."""
        while level in self.pending:
            row = (self.pending.pop(level) + row) / 2
            level += 1
            self.of_level(level, row)
        self.pending[level] = row

    # Results

    @property
    def samples(self) -> int:
        return self.levels[0].n

    def errors(self) -> np.ndarray:
        """The standard error of each mean; nan where there are too few samples to tell it."""
        if self.members.n >= FEWEST:
            return np.sqrt(self.members.variance() / self.members.n)
        level = next((moments for moments in reversed(self.levels) if moments.n >= FEWEST), None)
        return np.full(self.columns, np.nan) if level is None else np.sqrt(level.variance() / level.n)

    # A run that goes on

    def facts(self) -> dict:
        """All of it, as JSON has it."""
        return {"levels": [moments.facts() for moments in self.levels], "pending": [[level, row.tolist()] for level, row in self.pending.items()],
                "rest": self.rest.tolist(), "member": self.member.facts(), "members": self.members.facts(),
                "histograms": [histogram.facts() for histogram in self.histograms]}

    def go_on(self, facts: dict) -> None:
        """Be where `facts` were taken."""
        self.levels = [Moments(self.columns).go_on(one) for one in facts["levels"]]
        self.pending = {level: np.array(row) for level, row in facts["pending"]}
        self.rest = np.array(facts["rest"], float).reshape(-1, self.columns)
        self.member, self.members = Moments(self.columns).go_on(facts["member"]), Moments(self.columns).go_on(facts["members"])
        for histogram, one in zip(self.histograms, facts["histograms"]):
            histogram.go_on(one)
