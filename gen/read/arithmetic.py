"""Arithmetic on the constants of a formula, so that 1/0 is found where it is written."""
from __future__ import annotations

import math
import operator

CONSTANT = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "^": math.pow, "neg": operator.neg, "min": min, "max": max, "abs": abs,
    "mod": lambda a, b: a - b * math.floor(a / b),
    **{f: getattr(math, f) for f in (
        "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2",
        "sinh", "cosh", "tanh", "floor")}}
