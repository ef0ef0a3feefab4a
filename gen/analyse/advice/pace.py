"""How fast a sampled field changes: the angular frequency of its fastest modulation.

For b = A cos(omega t) the largest third difference of samples is 2 sin(omega spacing/2) times the largest second one. Neither contains a
constant part, however large it is, nor a linear drift, which a midpoint method follows exactly; and a weak fast modulation outweighs a
strong slow one.
"""
from __future__ import annotations

import numpy as np

FOUR = 4                # samples of a third difference
CLOSER = 8, 64, 512, 4096, 32768    # parts of the spacing of the run's samples at which a few more are taken
RESOLVED = 1.0          # frequency times spacing: beyond, less than six samples of a period
ROUND_OFF = 2e-13       # of the field, and of what it changes by in the time t: differences below are no change
ABRUPT = 1.5            # times the fastest modulation found: a change that is still faster is none of its samples


class Pace:
    """The largest differences of the field of every site, over groups of samples with the same spacing, at times up to `until`."""

    def __init__(self, spacing: float, until: float):
        self.spacing, self.until = float(abs(spacing)), float(abs(until))
        self.largest = np.zeros((FOUR, 1))

    def add(self, samples):
        """One group: fields of shape (times, sites, 3) at FOUR or more times that follow each other; fewer are left out."""
        if len(samples) >= FOUR:
            sizes = [np.linalg.norm(np.diff(samples, n, axis=0), axis=-1).max(axis=0) for n in range(FOUR)]
            self.largest = np.maximum(self.largest, sizes)

    @property
    def turn(self) -> float:
        """The largest frequency of a site, times the spacing; 0 where nothing but round-off changes."""
        size, first, second, third = self.largest
        there = third > ROUND_OFF * (size + self.until / self.spacing * first)
        return float(np.max(np.where(there, third, 0) / np.where(there, second, 1), initial=0.0))


def together(paces) -> tuple:
    """(the fastest frequency that is resolved by its samples, is there a faster change that none resolve?)."""
    turns = [(pace.turn, pace.spacing) for pace in paces]
    change = max((turn / spacing for turn, spacing in turns if turn < RESOLVED), default=0.0)
    return change, any(turn / spacing > ABRUPT * change for turn, spacing in turns if turn >= RESOLVED)
