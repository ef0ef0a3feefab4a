"""What a check of values finds."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Trouble:
    """Something wrong with the value at `path`."""
    path: tuple
    code: str
    cause: str
    hint: str
    part: object = None     # the Spin or Elem of the formula that is wrong
