"""What may be asked of the generated C beyond the step: named, off unless asked for."""
from __future__ import annotations

from ..errors import UsageError
from ..methods import HESSIAN, WIDE_GRADIENT

FEATURES = {
    "tangent": "the tangent map of the step, for Lyapunov exponents and stability",
    "extended": "evaluates each step a last time in extended precision, so that round-off is far below an ulp of w",
    "plain-sums": "no compensated summation: the rounding error of w + u is discarded",
    "distributed": "with -DSMG_MPI, ranks that store only their own part of a lattice processed by rows",
    "ensemble": "many states side by side, each bit for bit as on its own; those of a single sphere in lanes",
}
EVERYWHERE = ("distributed", "ensemble")      # of every method
ASKS = {"tangent": (HESSIAN,), "extended": (WIDE_GRADIENT, HESSIAN)}       # of every contribution


def chosen_features(names) -> tuple[str, ...]:
    """The names, sorted, each once. Raises UsageError for one that is not in FEATURES."""
    for name in names:
        if name not in FEATURES:
            raise UsageError(f"no feature '{name}'; there are: {', '.join(FEATURES)}")
    return tuple(sorted(set(names)))
