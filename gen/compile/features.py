"""What may be asked of the generated C beyond the step: named, off unless asked for."""
from __future__ import annotations

from ..errors import UsageError
from ..methods import HESSIAN, WIDE_GRADIENT

FEATURES = {
    "tangent": "the tangent map of the step, for Lyapunov exponents and stability",
    "extended": "the last evaluation of a step in extended precision: round-off far below a unit of w",
    "plain-sums": "no compensated summation: w + u is rounded, its error forgotten",
    "ensemble": "many states side by side, each with the bits that it has alone; those of a single sphere in lanes",
}
EVERYWHERE = ("ensemble",)      # of every method
ASKS = {"tangent": (HESSIAN,), "extended": (WIDE_GRADIENT, HESSIAN)}       # of every contribution


def chosen_features(names) -> tuple[str, ...]:
    """The names, sorted, each once. Raises UsageError for one that is not in FEATURES."""
    for name in names:
        if name not in FEATURES:
            raise UsageError(f"no feature '{name}'; there are: {', '.join(FEATURES)}")
    return tuple(sorted(set(names)))
