"""Numbers, axes and quadratic forms as a person writes them."""
from __future__ import annotations

from fractions import Fraction

import sympy as sp

from .constants import real

AXES = "xyz"


def number(x: float):
    """The decimal that is written for a float, exactly."""
    f = Fraction(repr(float(x)))
    return sp.Rational(f.numerator, f.denominator)


def axis_name(a) -> str:
    """`z`, or `(0.6, 0, 0.8)`."""
    for c in range(3):
        if abs(abs(a[c]) - 1) < 1e-12:
            return AXES[c]
    return "(" + ", ".join(f"{x + 0.0:.6g}" for x in a) + ")"


def axis_text(vector: str, a) -> str:
    """a . vector: `w.z`, `w.(0.6, 0, 0.8)`."""
    for c in range(3):
        others = [abs(a[k]) for k in range(3) if k != c]
        if max(others) < 1e-12:
            return vector + "." + AXES[c] if abs(a[c] - 1) < 1e-12 else f"{a[c]:.6g} {vector}.{AXES[c]}"
    return f"{vector}.({', '.join(f'{x + 0.0:.6g}' for x in a)})"


def form_text(vector: str, q) -> str:
    """w.(Q w) for the entries xx xy xz yy yz zz of Q."""
    parts = []
    for (a, b), x in zip(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)), q):
        c = real(x) * (1 if a == b else 2)
        if c:
            power = f"{vector}.{AXES[a]}^2" if a == b else f"{vector}.{AXES[a]} {vector}.{AXES[b]}"
            parts.append(f"{'-' if c < 0 else '+'} {'' if abs(c) == 1 else f'{abs(c):.6g} '}{power}")
    text = " ".join(parts)
    return text[2:] if text.startswith("+ ") else text
