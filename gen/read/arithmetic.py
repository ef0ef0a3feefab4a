"""Numerical values of expressions without vectors: sizes, strengths, starts, durations."""
from __future__ import annotations

import math
import operator

import numpy as np

from ..expr import Elem, Idx, Num, Op, Par, kind_of

# Operations on plain numbers, for constants.
CONSTANT = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "^": math.pow, "neg": operator.neg, "min": min, "max": max, "abs": abs,
    "mod": lambda a, b: a - b * math.floor(a / b),
    **{f: getattr(math, f) for f in (
        "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2",
        "sinh", "cosh", "tanh", "floor")}}

# The same on arrays, with conditions.
ARRAY = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.true_divide, "neg": np.negative,
    "^": lambda a, b: np.power(np.asarray(a, float), b), "min": np.minimum, "max": np.maximum,
    "abs": np.abs, "mod": lambda a, b: a - b * np.floor(np.true_divide(a, b)),
    "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos,
    "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "atan2": np.arctan2, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
    "floor": np.floor, "if": np.where, "<": np.less, "<=": np.less_equal,
    ">": np.greater, ">=": np.greater_equal, "==": np.equal, "!=": np.not_equal,
    "and": np.logical_and, "or": np.logical_or, "not": np.logical_not}


def evaluate(e, values: dict, index: dict | None = None):
    """The value of `e`, a scalar expression without vectors of the state.

    values: parameter or table name -> number or sequence; index: bound index -> integer or
    integer array (the result then has its shape). Not finite where the formula is not.
    """
    with np.errstate(all="ignore"):
        return _evaluate(e, values, index or {})


def _evaluate(e, values, index):
    if isinstance(e, Num):
        return e.value
    if isinstance(e, Par):
        return values[e.name]
    if isinstance(e, Idx):
        return index[e.name]
    if isinstance(e, Elem):
        return np.asarray(values[e.name], float)[_evaluate(e.index, values, index)]
    if isinstance(e, Op) and e.op in ("x", "y", "z", "dot", "norm", "triple"):
        return _vectorial(e, values, index)
    args = [_evaluate(a, values, index) for a in e.args]
    return ARRAY[e.op](*args)


def _vectorial(e, values, index):
    """Components and products of vectors made of numbers."""
    vectors = [_vector(a, values, index) for a in e.args]
    if e.op in "xyz":
        return vectors[0]["xyz".index(e.op)]
    if e.op == "triple":
        a, b, c = vectors
        return sum(p * q for p, q in zip(a, _cross(b, c)))
    if e.op == "dot":
        return sum(a * b for a, b in zip(*vectors))
    return np.sqrt(sum(a * a for a in vectors[0]))


def _vector(e, values, index) -> tuple:
    """Three numbers or arrays: the value of a vector expression of parameters."""
    if e.op == "vec":
        return tuple(_evaluate(a, values, index) for a in e.args)
    if e.op in ("+", "-"):
        a, b = (_vector(v, values, index) for v in e.args)
        return tuple(ARRAY[e.op](p, q) for p, q in zip(a, b))
    if e.op == "neg":
        return tuple(-p for p in _vector(e.args[0], values, index))
    if e.op == "cross":
        return _cross(*(_vector(v, values, index) for v in e.args))
    if e.op == "if":
        test = _evaluate(e.args[0], values, index)
        a, b = (_vector(v, values, index) for v in e.args[1:])
        return tuple(np.where(test, p, q) for p, q in zip(a, b))
    return _scaled(e, values, index)


def _cross(a, b) -> tuple:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _scaled(e, values, index) -> tuple:
    """A number times a vector, or a vector over a number."""
    a, b = e.args
    if kind_of(a) == "s":
        return tuple(_evaluate(a, values, index) * p for p in _vector(b, values, index))
    return tuple(ARRAY[e.op](p, _evaluate(b, values, index))
                 for p in _vector(a, values, index))
