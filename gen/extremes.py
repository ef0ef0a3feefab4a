"""The largest and the smallest of measured numbers, where NaN wins.

Python's max and min keep a NaN or lose it depending on where it stands, since every comparison with it is false.
A measurement that gave no number must not pass for a good one.
"""
from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np


def largest(*numbers: float) -> float:
    """The largest of one or more numbers; NaN if any of them is."""
    return float(np.max(np.array(numbers, np.longdouble)))


def smallest(*numbers: float) -> float:
    """The smallest of one or more numbers; NaN if any of them is."""
    return float(np.min(np.array(numbers, np.longdouble)))


def with_largest(items: Iterable, key: Callable):
    """The first item whose key is largest; one whose key is NaN before all others."""
    def order(item):
        number = float(key(item))
        return (True, 0.0) if math.isnan(number) else (False, number)
    return max(items, key=order)


def with_smallest(items: Iterable, key: Callable):
    """The first item whose key is smallest; one whose key is NaN before all others."""
    return with_largest(items, lambda item: -key(item))
