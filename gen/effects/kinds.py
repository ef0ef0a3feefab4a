"""The registry of kinds of effects, in the order in which a spec holds them.

A new kind is a class in a file of its own, an `Effect` of gen/language/spec.py, and its place here. `reader` is a class: of an instance,
made with what reads terms (`gen/read/terms.py`: name, over, scope, formulas, problems), `read(node)` gives the effect of one table.
"""
from __future__ import annotations

from .damping import Damping
from .energy import Energy
from .held import Held
from .torque import Torque

KINDS = (Energy, Damping, Torque, Held)


def kind_of(keys):
    """The kind of a table of [effects] with these keys: the last that knows one of them, else an energy."""
    return next((kind for kind in reversed(KINDS) if not set(kind.told_by).isdisjoint(keys)), Energy)


def ordered(effects) -> tuple:
    """Effects by kinds, each kind as they come."""
    return tuple(sorted(effects, key=lambda e: KINDS.index(type(e))))
