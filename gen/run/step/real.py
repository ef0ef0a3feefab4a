"""Arrays from callers: what C takes are real numbers."""
from __future__ import annotations

import numpy as np

from ...errors import UsageError
from .evaluated import real


def real_array(given, kind, what: str) -> np.ndarray:
    """`given` itself if C can work on it, else a copy. Raises UsageError for what is no array of numbers, and for complex ones, whose
    imaginary parts numpy would drop."""
    try:
        return np.ascontiguousarray(real(given), dtype=kind)
    except (TypeError, ValueError) as problem:
        raise UsageError(f"{what} must be an array of {'real ' * (isinstance(problem, TypeError) and np.iscomplexobj(given))}numbers") from None
