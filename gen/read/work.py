"""How much work the derivatives of an energy are, counted before they are taken."""
from __future__ import annotations

from ..language.expr import Expr, Op, Spin

LINEAR = {"+", "-", "neg", "x", "y", "z", "vec"}
SCALARS = {"cross": 9, "dot": 5, "triple": 14, "norm": 6, "vec": 0, "x": 0, "y": 0, "z": 0}
VECTORS = {"cross", "vec"}
CARRIED = {"+", "-", "neg", "*", "/", "if"}      # of a vector they make a vector


def derivatives(e: Expr) -> int:
    """Operations of a formula, its gradient and its Hessian: each depends on d components of vectors, and has d
    first derivatives and d(d + 1)/2 second ones, which a sum leaves to its terms."""
    return _counted(e)[0]


def _counted(e: Expr) -> tuple[int, frozenset, bool]:
    """(operations, the vectors that e depends on, is e a vector)"""
    if isinstance(e, Spin):
        return 0, frozenset([(e.family, e.slot)]), True
    if not isinstance(e, Op):
        return 0, frozenset(), False
    parts = [_counted(a) for a in e.args]
    slots = frozenset().union(*(s for _, s, _ in parts))
    is_vector = e.op in VECTORS or e.op in CARRIED and any(v for _, _, v in parts)
    d = 3 * len(slots)
    each = 1 + d + (0 if e.op in LINEAR else d * (d + 1) // 2)
    count = SCALARS.get(e.op, 3 if is_vector else 1)
    return sum(n for n, _, _ in parts) + count * each, slots, is_vector
