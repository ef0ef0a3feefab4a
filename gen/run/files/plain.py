"""Values as JSON has them."""
from __future__ import annotations

import numbers

import numpy as np


def plain(value):
    """A number, a text, or a list of these, as JSON has it: numbers of numpy, of sympy, fractions are the int or the double that a run takes them for."""
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray) or np.ndim(value):
        return plain(np.asarray(value).tolist())
    if value is None or isinstance(value, (str, int, float)):
        return value
    return int(value) if isinstance(value, numbers.Integral) else float(value)
