"""Stage `read`: spec text -> `Spec`."""
from .initial import initial_state
from .load import load, load_text
from .values import defaults

__all__ = ["defaults", "initial_state", "load", "load_text"]
