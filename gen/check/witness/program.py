"""A term's expression tree as straight code for the interpreter in C.

Vectors become three registers; nothing is differentiated or simplified here, equal
operations on equal registers are only written once. The values of parameters are
constants of the code, index values and weights come from columns, one row an instance.
"""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...errors import UsageError
from ...language.evaluate import whole
from ...language.expr import Elem, Idx, Num, Op, Par, Spin, Time, Weight, is_draw, walk
from ...language.spec import Term, families_of
from ...language.instances import instances_of
from . import disorder

OPERATIONS = (
    "constant", "time", "column", "spin", "element",
    "+", "-", "neg", "*", "/", "^",
    "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan",
    "sinh", "cosh", "tanh", "floor", "atan2", "if",
    "<", "<=", ">", ">=", "==", "!=", "and", "or", "not", "double")
CODE = {name: number for number, name in enumerate(OPERATIONS)}

SIDES = {"floor", "<", "<=", ">", ">=", "==", "!="}     # jump: what they look at is rounded to double, operation by operation

INSTRUCTION = np.dtype([("op", np.int32), ("a", np.int32), ("b", np.int32), ("c", np.int32),
                        ("number", np.float64)], align=True)


@dataclass
class Program:
    """Arrays that `struct program` of witness.h points to.

    site: (instances, slots) site numbers; data: (instances, columns); feels: (slots,).
    """
    name: str
    code: np.ndarray
    site: np.ndarray
    data: np.ndarray
    table: np.ndarray
    feels: np.ndarray


def compile_term(spec, term: Term, env: dict, places: dict, absent) -> Program:
    """The program of an effect or observable for the parameter values `env`.

    places: family -> (first site, count); absent: of all sites; no instance has one of them. Raises UsageError when an index leaves its family.
    """
    indices, columns, count = instances_left(term, env, places, absent)
    code = Code(env, {**indices, **columns}, count)
    code.result(term.value)
    sites = [_sites(slot, indices, places, count) for slot in code.slots]
    return Program(
        term.name, np.array(code.instructions, dtype=INSTRUCTION),
        _rows(sites, count, np.int64), _rows([*code.columns.values()], count, float),
        np.array(code.table or [0.0]), _feels(spec, term.over, code.slots))


def instances_left(term: Term, env: dict, places: dict, absent) -> tuple:
    """(indices, columns, their number) of the instances of a term that have no absent site."""
    indices, columns = instances_of(term.over, env, places)
    count = len(next(iter(indices.values()))) if indices else 1
    if not np.any(absent):
        return indices, columns, count
    bound = [*families_of(term.over).items(), *((e.slot, e.family) for e in walk(term.value) if isinstance(e, Spin) and isinstance(e.slot, int))]
    gone = np.zeros(count, bool)
    for index, family in bound:
        number = np.broadcast_to(indices[index] if isinstance(index, str) else index, count)
        first, size = places[family]
        inside = (number >= 0) & (number < size)
        gone |= inside & absent[first + np.where(inside, number, 0).astype(int)]
    return {i: v[~gone] for i, v in indices.items()}, {c: np.asarray(v)[~gone] for c, v in columns.items()}, int((~gone).sum())


def moved_sites(torque, env: dict, places: dict, absent) -> np.ndarray:
    """The site that a torque moves in every instance."""
    indices, _, count = instances_left(torque, env, places, absent)
    return np.ascontiguousarray(_sites((torque.on.family, torque.on.slot), indices, places, count), dtype=np.int64)


def _rows(columns, count, dtype):
    return np.ascontiguousarray(np.array(columns, dtype=dtype).reshape(len(columns), count).T)


def _sites(slot, indices, places, count):
    """The site number of a spin of the term in every instance."""
    family, index = slot
    first, size = places[family]
    number = indices[index] if isinstance(index, str) else np.full(count, index)
    outside = (number < 0) | (number >= size)
    if np.any(outside):
        raise UsageError(f"{family}[{number[outside][0]}] does not exist: "
                         f"'{family}' has {size} sites")
    return number + first


def _feels(spec, over, slots):
    """A term that runs over tracers, or names one, acts on tracers only; any other acts on all its spins."""
    tracers = {f.name for f in spec.families if f.tracer}
    tracer = np.array([family in tracers for family, _ in slots], dtype=np.uint8)
    runs = [getattr(over, "family", ""), *getattr(over, "families", ())]
    return tracer if tracer.any() or tracers & set(runs) else np.ones(len(slots), dtype=np.uint8)


@dataclass
class Code:
    """Instructions under construction. A scalar is a register, a vector a triple of them."""
    env: dict
    columns: dict
    count: int
    instructions: list = field(default_factory=list)
    slots: list = field(default_factory=list)
    table: list = field(default_factory=list)
    seen: dict = field(default_factory=dict)
    placed: dict = field(default_factory=dict)
    rounding: bool = False

    def result(self, e):
        """The value of a term: always the last register."""
        last = self.value(e)
        if last != len(self.instructions) - 1:      # written earlier, or a leaf seen before
            self.instructions.append((CODE["+"], last, self.number(0.0), 0, 0.0))

    def value(self, e):
        return _NODES[type(e)](self, e)

    def rounded(self, e):
        """e in double precision, which decides on which side of a jump it is."""
        before, self.rounding = self.rounding, True
        found = self.value(e)
        self.rounding = before
        return found

    def emit(self, name, a=0, b=0, c=0, number=0.0):
        written = self.written(name, a, b, c, number)
        return self.written("double", written, 0, 0, 0.0) if self.rounding and name not in EXACT else written

    def written(self, name, a, b, c, number):
        key = (name, a, b, c, float(number).hex())
        if key not in self.seen:
            self.seen[key] = len(self.instructions)
            self.instructions.append((CODE[name], a, b, c, number))
        return self.seen[key]

    def number(self, value):
        return self.emit("constant", number=float(value))

    def column(self, name):
        return self.emit("column", [*self.columns].index(name))

    def element(self, e):
        if e.name not in self.placed:
            self.placed[e.name] = len(self.table)
            self.table.extend(self.env[e.name])
        return self.emit("element", self.value(e.index), self.placed[e.name],
                         len(self.env[e.name]))

    def spin(self, e):
        slot = (e.family, e.slot)
        if slot not in self.slots:
            self.slots.append(slot)
        return tuple(self.emit("spin", self.slots.index(slot), c) for c in range(3))

    def drawn(self, kind, *args):
        """A random number: a column of its own, one for every instance."""
        found = [np.broadcast_to(whole(a, {**self.env, **self.columns}), self.count).tolist() for a in args]
        return self.columns.setdefault((kind, *args), [disorder.number(kind, *one) for one in zip(*found)])

    def operation(self, e):
        if is_draw(e):
            self.drawn(e.op, *e.args)
            return self.column((e.op, *e.args))
        if e.op in _BY_SIDES:
            return _BY_SIDES[e.op](self, *e.args)
        arguments = [self.rounded(a) if e.op in SIDES else self.value(a) for a in e.args]
        if e.op in _EXPANDED:
            return _EXPANDED[e.op](self, *arguments)
        return self.componentwise(e.op, *arguments)

    def componentwise(self, op, *arguments):
        """op on scalars; on each component where an argument is a vector."""
        if not any(isinstance(a, tuple) for a in arguments):
            return self.emit(op, *arguments)
        return tuple(self.emit(op, *(a[c] if isinstance(a, tuple) else a for a in arguments))
                     for c in range(3))

    def modulo(self, a, b):
        """a - b floor(a/b)"""
        quotient = self.rounded(Op("/", (a, b)))
        return self.emit("-", self.value(a), self.emit("*", self.value(b), self.emit("floor", quotient)))

    def extreme(self, a, b, side):
        """The one of a and b that `side` of them finds."""
        return self.emit("if", self.emit(side, self.rounded(a), self.rounded(b)), self.value(a), self.value(b))

    def absolute(self, a):
        """sign(a) a"""
        side, zero = self.rounded(a), self.number(0.0)
        return self.emit("*", self.emit("-", self.emit(">", side, zero), self.emit("<", side, zero)), self.value(a))

    def dot(self, a, b):
        xx, yy, zz = (self.emit("*", a[c], b[c]) for c in range(3))
        return self.emit("+", self.emit("+", xx, yy), zz)

    def cross(self, a, b):
        def minor(i, j):
            return self.emit("-", self.emit("*", a[i], b[j]), self.emit("*", a[j], b[i]))
        return minor(1, 2), minor(2, 0), minor(0, 1)


_NODES = {
    Num: lambda code, e: code.number(e.value),
    Par: lambda code, e: code.number(code.env[e.name]),
    Idx: lambda code, e: code.column(e.name),
    Weight: lambda code, e: code.column(e.name),
    Time: lambda code, e: code.emit("time"),
    Elem: Code.element, Spin: Code.spin, Op: Code.operation,
}

EXACT = {"constant", "column", "element", "neg", "if", *SIDES, "and", "or", "not"}      # of doubles

_BY_SIDES = {"mod": Code.modulo, "abs": Code.absolute, "min": lambda code, a, b: code.extreme(a, b, "<="),
             "max": lambda code, a, b: code.extreme(a, b, ">=")}

_EXPANDED = {
    "vec": lambda code, x, y, z: (x, y, z),
    "x": lambda code, a: a[0], "y": lambda code, a: a[1], "z": lambda code, a: a[2],
    "dot": Code.dot, "cross": Code.cross,
    "triple": lambda code, a, b, c: code.dot(a, code.cross(b, c)),
    "norm": lambda code, a: code.emit("sqrt", code.dot(a, a)),
}
