"""Vectors in formulas that are written with sympy: sites, array parameters, and what is made of them.

sympy sees a vector as a symbol, `w[i]`, and a product of vectors as a function that it does not know, `dot(w[i], w[j])`; so sums
and multiples of vectors are those of symbols, and `text.py` writes them as the language of specs has them.
"""
from __future__ import annotations

import sympy

from ..errors import UsageError


class Vector:
    """A vector: `.x`, `.y`, `.z`, `.dot(b)`, `.cross(b)`, `.norm()`, sums, multiples. `value`: the sympy expression that stands for it."""
    __array_ufunc__ = None      # numpy's numbers leave products with a vector to it

    def __init__(self, value):
        self.value = value

    def __repr__(self):
        return f"<Vector {self.value}>"

    def component(self, axis: str):
        """A number: the component of a site by name, of others by a scalar product."""
        if isinstance(self.value, sympy.Symbol):
            return sympy.Symbol(f"{self.value.name}.{axis}", real=True)
        return function("dot", self, vec(*(int(axis == other) for other in "xyz")))

    x, y, z = (property(lambda self, axis=axis: self.component(axis)) for axis in "xyz")

    def dot(self, other):
        """The scalar product."""
        return function("dot", self, other)

    def cross(self, other) -> "Vector":
        """The vector product."""
        return Vector(function("cross", self, other))

    def norm(self):
        """The length."""
        return function("norm", self)

    def __add__(self, other):
        return Vector(self.value + vector(other).value)

    def __sub__(self, other):
        return Vector(self.value - vector(other).value)

    def __neg__(self):
        return Vector(-self.value)

    def __mul__(self, factor):
        if isinstance(factor, Vector):
            raise UsageError("multiply two vectors with `.dot` or `.cross`, not with `*`")
        return Vector(self.value * sympy.sympify(factor, strict=True))

    __rmul__ = __mul__

    def __truediv__(self, number):
        return Vector(self.value / sympy.sympify(number, strict=True))


class Indexed:
    """What has entries: `w[i]` of a family, `K[i]` of an array parameter; `vectors`: whether they are vectors."""

    def __init__(self, name: str, vectors: bool):
        self.name, self.vectors = name, vectors

    def __repr__(self):
        return f"<{self.name}[i]>"

    def __getitem__(self, index):
        entry = sympy.Symbol(f"{self.name}[{index}]", real=True)
        return Vector(entry) if self.vectors else entry


def vec(x, y, z) -> Vector:
    """The vector of three numbers."""
    return Vector(function("vec", x, y, z))


def vector(value) -> Vector:
    """A Vector, or three numbers. Raises UsageError."""
    if isinstance(value, Vector):
        return value
    try:
        return vec(*value)
    except TypeError:
        raise UsageError(f"{value!r} is not a vector: use a site such as w[i], or three numbers") from None


def function(name: str, *arguments):
    """A function of the language of specs, applied to numbers and vectors."""
    plain = (a.value if isinstance(a, Vector) else vector(a).value if isinstance(a, (tuple, list)) else sympy.sympify(a, strict=True) for a in arguments)
    return sympy.Function(name, real=True)(*plain)
