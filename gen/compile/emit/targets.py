"""The printers by name. A further target is one more class, and its line here."""
from __future__ import annotations

from ..lower.code import Table
from .print_lanes import Lanes, LanesByValue
from .print_scalar import OfModel, Scalar
from .print_value import ByValue
from .print_wide import Wide

PRINTERS = {"scalar": Scalar(), "model": OfModel(), "value": ByValue(), "wide": Wide(), "lanes": Lanes(), "lanes by value": LanesByValue()}


def printed(definition) -> str:
    """A function, type or table as text."""
    target = "scalar" if isinstance(definition, Table) else definition.target
    return PRINTERS[target].define(definition)
