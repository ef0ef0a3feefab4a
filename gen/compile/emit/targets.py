"""The printers by name. A further target is one more class, and its line here."""
from __future__ import annotations

from ..lower.code import Function
from .print_lanes import Lanes
from .print_scalar import Scalar
from .print_value import ByValue
from .print_wide import Wide

PRINTERS = {"scalar": Scalar(), "value": ByValue(), "wide": Wide(), "lanes": Lanes()}


def printed(definition) -> str:
    """A function, type or table as text."""
    target = definition.target if isinstance(definition, Function) else "scalar"
    return PRINTERS[target].define(definition)
