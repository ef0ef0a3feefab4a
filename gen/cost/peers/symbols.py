"""The right-hand side of a case in heyoka's expressions: w' = (1/kappa) grad C x dH/dw, of every component.

Of a single site it is expanded by sympy, which leaves a polynomial its fewest terms: (1/I3 - 1/I2) w.y w.z. Squared distances
of unit vectors stand as sums of squares, 2 - 2 a.b = |a - b|^2, as they are best for Taylor series.
"""
from __future__ import annotations

import numpy as np

from ...language.expr import Elem, Idx, Num, Op, Par, Spin, Time, Weight, slots_of
from ...language.instances import instances_of


class NoExpression(Exception):
    """The spec has an operation that heyoka lacks; the text names it."""


def system(hy, case) -> list:
    """[(variable, its derivative)] of all components, site after site."""
    model = case.model(case.settings.method)
    spec, numbers = model.scene, model.prepared.numbers
    known, places = numbers.values, numbers.places
    tracers = {f.name for f in spec.families if f.tracer}
    w = [hy.make_vars(f"x{i}", f"y{i}", f"z{i}") for i in range(len(case.w))]
    slopes = [[[] for _ in range(3)] for _ in w]
    for effect in spec.energies:
        for value, sites in terms(hy, effect, known, places, w, tracers):
            for i in sites:
                for b, variable in enumerate(w[i]):
                    slopes[i][b].append(hy.diff(value, variable))
    field = [[hy.sum(parts) if parts else hy.expression(0.0) for parts in row] for row in slopes]
    return turned(hy, spec, values, w, field)


def turned(hy, spec, values, w, field) -> list:
    """The bracket."""
    kappa, leaf, found = numbers.kappas, numbers.casimir_matrices, []
    for i, v in enumerate(w):
        n = [sum((float(leaf[i][a][b]) * v[b] for b in range(3) if leaf[i][a][b]), hy.expression(0.0)) for a in range(3)]
        g, scale = field[i], spec.orientation / float(kappa[i])
        cross = [n[1] * g[2] - n[2] * g[1], n[2] * g[0] - n[0] * g[2], n[0] * g[1] - n[1] * g[0]]
        found += [(v[b], simple(hy, scale * cross[b], len(w))) for b in range(3)]
    return found


def simple(hy, value, sites: int):
    """With the fewest terms, of a single site."""
    if sites > 1:
        return value
    import sympy
    return hy.from_sympy(sympy.expand(hy.to_sympy(value)))


def terms(hy, effect, known, places, w, tracers):
    """(energy, sites whose field it enters) of every instance of an effect; one with a tracer moves its tracers only."""
    indices, columns = instances_of(effect.over, known, places)
    for k in range(len(next(iter(indices.values()))) if indices else 1):
        env = {**known, **{n: int(v[k]) for n, v in indices.items()}, **{n: float(v[k]) for n, v in columns.items()}}
        sites = {slot: places[slot[0]][0] + (env[slot[1]] if isinstance(slot[1], str) else slot[1]) for slot in slots_of(effect.value)}
        moved = {site for (family, _), site in sites.items() if family in tracers} or set(sites.values())
        yield Reader(hy, env, {slot: tuple(w[site]) for slot, site in sites.items()}).value(effect.value), moved


class Reader:
    """Expressions of specs as heyoka's; numbers stay Python's as long as they are numbers."""

    def __init__(self, hy, env, spins):
        self.hy, self.env, self.spins = hy, env, spins

    def value(self, e):
        """Of any node; a vector is a tuple."""
        if isinstance(e, Num):
            return float(e.value)
        if isinstance(e, (Par, Idx, Weight)):
            found = self.env[e.name]
            return tuple(map(float, found)) if np.ndim(found) else float(found)
        if isinstance(e, Elem):
            return float(self.env[e.name][int(self.value(e.index))])
        if isinstance(e, Spin):
            return self.spins[e.family, e.slot]
        if isinstance(e, Time):
            return self.hy.time
        return self.operation(e)

    def operation(self, e: Op):
        if e.op == "-" and len(e.args) == 2 and (close := self.squared_distance(e)) is not None:
            return close
        args = [self.value(a) for a in e.args]
        if e.op in PLAIN:
            return PLAIN[e.op](*args)
        if e.op in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "atan2"):
            return getattr(np if all(isinstance(a, float) for a in args) else self.hy, NUMPY.get(e.op, e.op) if isinstance(args[0], float) else e.op)(*args)
        raise NoExpression(f"heyoka has no smooth '{e.op}'")

    def squared_distance(self, e: Op):
        """c - c*dot(a, b) of unit vectors as (c/2) |a - b|^2; None for what is none."""
        left, right = e.args
        if not (isinstance(left, Num) and isinstance(right, Op) and right.op == "*" and right.args[0] == left):
            return None
        product = right.args[1]
        if not (isinstance(product, Op) and product.op == "dot" and all(isinstance(a, Spin) for a in product.args)):
            return None
        a, b = (self.value(v) for v in product.args)
        return float(left.value) / 2 * self.hy.sum([(x - y) ** 2.0 for x, y in zip(a, b)])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def each(f, a, b):
    return tuple(map(f, a, b)) if isinstance(a, tuple) else f(a, b)


def times(a, b):
    return tuple(x * b for x in a) if isinstance(a, tuple) else tuple(a * y for y in b) if isinstance(b, tuple) else a * b


def power(a, b):
    return a ** (int(b) if isinstance(a, float) and b == int(b) else b)


NUMPY = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2"}
PLAIN = {"+": lambda a, b: each(lambda x, y: x + y, a, b), "-": lambda a, b: each(lambda x, y: x - y, a, b),
         "neg": lambda a: tuple(-x for x in a) if isinstance(a, tuple) else -a, "*": times,
         "/": lambda a, b: tuple(x / b for x in a) if isinstance(a, tuple) else a / b, "^": power, "vec": lambda x, y, z: (x, y, z),
         "x": lambda a: a[0], "y": lambda a: a[1], "z": lambda a: a[2], "dot": dot, "cross": cross,
         "triple": lambda a, b, c: dot(a, cross(b, c)), "norm": lambda a: dot(a, a) ** 0.5}
