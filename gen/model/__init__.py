"""Models written in Python: `Model` gathers what a spec says, from numbers, arrays, texts and sympy expressions, and reads it as a spec."""
from .model import Model

__all__ = ["Model"]
