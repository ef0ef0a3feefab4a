"""Values of resolved expressions with numpy: no sympy, no text, no derivative.

Scalars are float64 or arrays of them (one entry a site); a vector is a tuple of its three
components until it leaves `evaluate`, so that three scalars are never taken for a vector.
"""
from __future__ import annotations

import functools
import operator

import numpy as np

from ..errors import UsageError
from . import draws, limits
from .expr import Elem, Expr, Idx, Num, Op, Par, Spin, Time, Weight


def evaluate(expr: Expr, env: dict):
    """The value of `expr`: float64, bool, or for a vector an array whose last axis is 3.

    `env` maps the names of parameters, arrays, tables, indices and graph columns to numbers
    or arrays, "t" to the time and "spins" to a mapping family -> (count, 3) or a function
    (family, slot) -> vector. Index arrays are welcome: the value then has one entry for
    each. Floating-point exceptions give inf or nan, as in C. Raises UsageError when a
    name has no value or an array has no such entry.
    """
    with np.errstate(all="ignore"):
        value = _value(expr, env)
    if isinstance(value, tuple):
        return np.stack(np.broadcast_arrays(*value), axis=-1).astype(float)
    return value


def integer(expr: Expr, env: dict, what: str = "a size") -> int:
    """The value of an integer formula. Raises UsageError when it is not an integer."""
    value = evaluate(expr, env)
    if not np.isfinite(value) or value != np.floor(value) or abs(value) > limits.INTEGER:
        raise UsageError(f"{what} must be an integer, not {float(value):.17g}")
    return int(value)


def whole(expr: Expr, env: dict) -> np.ndarray:
    """The value of a formula of integers with + - *, such as a seed, modulo 2^64, as C has it; in doubles it would lose digits beyond 2^53."""
    if isinstance(expr, Num):
        return np.array(expr.value, np.int64)
    if isinstance(expr, Op):
        with np.errstate(over="ignore"):
            return _OPERATORS[expr.op](*(whole(a, env) for a in expr.args))
    return np.asarray(_lookup(env, expr.name)).astype(np.int64)


def _value(e, env):
    return _NODES[type(e)](e, env)


def _lookup(env, name):
    try:
        return env[name]
    except KeyError:
        raise UsageError(f"'{name}' is not defined here") from None


def _number(value):
    return np.asarray(value, dtype=float)[()]


def _named(e, env):
    return _number(_lookup(env, e.name))


def _element(e, env):
    table, index = _number(_lookup(env, e.name)), _value(e.index, env)
    if np.any(index != np.floor(index)) or np.any(index < 0) or np.any(index >= len(table)):
        raise UsageError(f"'{e.name}' has entries 0 to {len(table) - 1}, not {index}")
    return table[np.asarray(index, dtype=np.int64)]


def _spin(e, env):
    spins = _lookup(env, "spins")
    slot = _lookup(env, e.slot) if isinstance(e.slot, str) else e.slot
    w = spins(e.family, slot) if callable(spins) else np.asarray(spins[e.family])[slot]
    return tuple(np.moveaxis(np.asarray(w, dtype=float), -1, 0))


def _operation(e, env):
    if e.op in _LAZY:
        return _LAZY[e.op](e.args, env)
    return _OPERATORS[e.op](*(_value(a, env) for a in e.args))


def _if(args, env):
    """Only the branch that counts is evaluated, unless the condition is an array."""
    condition = _value(args[0], env)
    if np.ndim(condition) == 0:
        return _value(args[1 if condition else 2], env)
    return _each(functools.partial(np.where, condition), *(_value(a, env) for a in args[1:]))


def _and(args, env):
    left = _value(args[0], env)
    return left if np.ndim(left) == 0 and not left else np.logical_and(left, _value(args[1], env))


def _or(args, env):
    left = _value(args[0], env)
    return left if np.ndim(left) == 0 and left else np.logical_or(left, _value(args[1], env))


def _each(f, a, b):
    """f of two scalars, or of two vectors component by component."""
    if isinstance(a, tuple):
        return tuple(f(x, y) for x, y in zip(a, b))
    return f(a, b)


def _times(a, b):
    if isinstance(a, tuple):
        return tuple(x * b for x in a)
    return tuple(a * y for y in b) if isinstance(b, tuple) else a * b


def _over(a, b):
    return tuple(np.divide(x, b) for x in a) if isinstance(a, tuple) else np.divide(a, b)


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _negative(a):
    return tuple(-x for x in a) if isinstance(a, tuple) else -a


def _modulo(a, b):
    """a - b floor(a/b): the sign of b, as the spec language defines it."""
    return a - b * np.floor(np.divide(a, b))


_NODES = {
    Num: lambda e, env: np.float64(e.value),
    Par: _named, Idx: _named, Weight: _named, Elem: _element, Spin: _spin,
    Time: lambda e, env: _number(_lookup(env, "t")), Op: _operation,
}

def _drawn(number):
    return lambda args, env: number(*(whole(a, env) for a in args))


_LAZY = {"if": _if, "and": _and, "or": _or, "uniform": _drawn(draws.uniform), "normal": _drawn(draws.normal)}

_OPERATORS = {
    "+": functools.partial(_each, operator.add), "-": functools.partial(_each, operator.sub),
    "neg": _negative, "*": _times, "/": _over, "^": np.power,
    "vec": lambda x, y, z: (x, y, z),
    "x": lambda a: a[0], "y": lambda a: a[1], "z": lambda a: a[2],
    "dot": _dot, "cross": _cross, "triple": lambda a, b, c: _dot(a, _cross(b, c)),
    "norm": lambda a: np.sqrt(_dot(a, a)),
    "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos,
    "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "abs": np.abs, "floor": np.floor,
    "atan2": np.arctan2, "mod": _modulo, "min": np.minimum, "max": np.maximum,
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "==": operator.eq, "!=": operator.ne, "not": np.logical_not,
    "kept": lambda a: a,
}
