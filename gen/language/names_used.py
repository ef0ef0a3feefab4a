"""Which parameters of a spec its formulas name."""
from __future__ import annotations

import dataclasses

from .expr import Elem, Par
from .spec import Spec

DATA = {"default", "tables", "edges", "columns", "places"}       # fields of numbers alone, perhaps millions


def unused(spec: Spec) -> list[str]:
    """The parameters that no energy, observable, space, lattice, start, run or size names."""
    named: set = set()
    _collect(spec, named)
    return [p.name for p in spec.parameters if p.name not in named]


def _collect(value, named: set) -> None:
    """Adds the names of parameters below a value: of expressions, and of whatever holds some."""
    left = [value]
    while left:
        one = left.pop()
        if isinstance(one, (Par, Elem)):
            named.add(one.name)
        if dataclasses.is_dataclass(one):
            left += [getattr(one, f.name) for f in dataclasses.fields(one) if f.name not in DATA]
        elif isinstance(one, (tuple, list)):
            left += one
        elif isinstance(one, dict):
            left += one.values()
