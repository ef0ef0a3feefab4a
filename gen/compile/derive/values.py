"""Values of derived expressions in numpy: what a formula, its gradient and its Hessian blocks are at given vectors and parameters."""
from __future__ import annotations

import functools
import operator

import numpy as np
import sympy as sp

_OPERATIONS = {
    "Pow": np.power, "power": np.power, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin,
    "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
    "absolute": np.abs, "Abs": np.abs, "signum": np.sign, "sign": np.sign, "floor_": np.floor, "floor": np.floor,
    "lesser": np.minimum, "greater": np.maximum, "chosen": np.where,
    "plus": operator.add, "minus": operator.sub, "times": operator.mul, "over": np.divide, "negative": operator.neg,
    "StrictLessThan": np.less, "LessThan": np.less_equal, "StrictGreaterThan": np.greater, "GreaterThan": np.greater_equal,
    "Equality": np.equal, "Unequality": np.not_equal, "Not": np.logical_not,
}
_MANY = {"Add": operator.add, "Mul": operator.mul, "And": np.logical_and, "Or": np.logical_or}


def value(e, known: dict):
    """The value of e: a number or an array. known: symbol -> number or array; every expression that is met is added, and computed once.

    Floating-point exceptions give inf or nan, as in C."""
    if e not in known:
        known[e] = _computed(e, known)
    return known[e]


def _computed(e, known):
    if e in (sp.true, sp.false):
        return bool(e)
    if not e.args:
        return float(e)
    args = [value(a, known) for a in e.args]
    name = type(e).__name__
    with np.errstate(all="ignore"):
        return functools.reduce(_MANY[name], args) if name in _MANY else _OPERATIONS[name](*args)
