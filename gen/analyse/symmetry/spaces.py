"""Subspaces in exact numbers: which of the combinations found have a plain meaning."""
from __future__ import annotations

import sympy as sp
from sympy.polys.matrices import DomainMatrix
from sympy.polys.polyerrors import BasePolynomialError


def within(vector, basis) -> bool:
    """Does the vector lie in the span of the basis?"""
    if not basis:
        return not any(vector)
    return rank([*basis, vector]) == rank(basis)


def rank(vectors) -> int:
    return len(echelon(vectors)[1]) if vectors else 0


def echelon(vectors) -> tuple:
    """(the reduced echelon form, its pivots), over the field that the numbers and symbols generate."""
    matrix = sp.Matrix(vectors)
    try:
        found, pivots = DomainMatrix.from_Matrix(matrix, extension=True).to_field().rref()
        return found.to_Matrix(), pivots
    except (NotImplementedError, BasePolynomialError):      # roots and symbols together
        return matrix.rref()


def beyond(vectors, known) -> list:
    """Those of the vectors that are independent of `known` and of each other."""
    known, found = list(known), []
    for v in vectors:
        if not within(v, known):
            known.append(v)
            found.append(v)
    return found


def common_axes(basis, families: int, chosen) -> list:
    """Axes a such that `a` on each chosen family, and nothing on the others, lies in the span."""
    if not basis:
        return []
    patterns = [[sp.Integer(int(f in chosen and c == axis)) for f in range(families) for c in range(3)]
                for axis in range(3)]
    matrix = sp.Matrix([*basis, *[[-x for x in p] for p in patterns]]).T
    found = [[sp.cancel(x) for x in v[len(basis):]] for v in matrix.nullspace()]
    return beyond([a for a in found if any(a)], [])


def support(vector) -> tuple:
    """The families (numbers) on which a vector of axes is not zero."""
    return tuple(f for f in range(len(vector) // 3) if any(vector[3 * f:3 * f + 3]))


def neat(axes) -> list:
    """The same space in its reduced echelon basis: x, y, z when it is everything."""
    reduced, _ = echelon(axes)
    return [list(reduced.row(k)) for k in range(reduced.rows)]
