"""Stage `read`: spec text -> `Spec`."""
from .load import load, load_text, shown
from .values import defaults

__all__ = ["defaults", "load", "load_text", "shown"]
