"""What a value of the metadata may be: functions that say whether one is of a kind."""
from __future__ import annotations

import sys

from ...language import limits


def text(value) -> bool:
    return isinstance(value, str)


def flag(value) -> bool:
    return isinstance(value, (bool, int)) and value in (0, 1)


def number(value) -> bool:
    """An int or float that is a finite double."""
    return isinstance(value, (int, float)) and abs(value) <= sys.float_info.max


def count(value) -> bool:
    return isinstance(value, int) and 0 <= value <= limits.INTEGER


def seed(value) -> bool:
    return isinstance(value, int) and value >= 0


def finite_or_not(value) -> bool:
    """A number of a state that may have overflowed."""
    return number(value) or isinstance(value, float)


def either(*kinds):
    return lambda value: any(kind(value) for kind in kinds)


def none(value) -> bool:
    return value is None


def listed(kind):
    return lambda value: isinstance(value, list) and all(map(kind, value))


def table(kind):
    return lambda value: isinstance(value, dict) and all(map(kind, value.values()))


def triple(value) -> bool:
    """Three finite numbers."""
    return listed(number)(value) and len(value) == 3


def source(value) -> bool:
    """A file of the spec: its name and its text."""
    return listed(text)(value) and len(value) == 2


VALUE = either(number, text, listed(either(number, text)))
