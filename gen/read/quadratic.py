"""The Casimir matrix of a Nambu factor, from its formula C.

A formula in x, y, z is a polynomial {(a, b, c): coefficient of x^a y^b z^c} with
expressions in the parameters as coefficients. C = w.(A w)/2 with A symmetric.
"""
from __future__ import annotations

from ..language.expr import Expr, Num, Op, Spin, kind_of

ONE = (0, 0, 0)
DEGREE = 8                  # of any intermediate polynomial


class NotPolynomial(Exception):
    """Why a formula is no polynomial in x, y, z."""


def matrix(c: Expr) -> tuple[tuple[Expr, ...], ...]:
    """The symmetric 3x3 matrix A of C = w.(A w)/2. Raises NotPolynomial with a reason."""
    poly = {m: e for m, e in scalar(c).items() if e not in (Num(0), Num(0.0))}
    if not poly:
        raise NotPolynomial("it is zero")
    for m in poly:
        if sum(m) != 2:
            raise NotPolynomial(f"it has a term of degree {sum(m)}")
    return tuple(tuple(entry(poly, i, j) for j in range(3)) for i in range(3))


def entry(poly, i: int, j: int) -> Expr:
    """d^2 C / dx_i dx_j."""
    m = tuple((k == i) + (k == j) for k in range(3))
    c = poly.get(m, Num(0))
    return times(Num(2), c) if i == j else c


def scalar(e: Expr) -> dict:
    """The polynomial of a scalar expression."""
    if not isinstance(e, Op):
        return {ONE: e}
    if e.op in "xyz":
        return vector(e.args[0])["xyz".index(e.op)]
    if e.op == "dot":
        return dot(vector(e.args[0]), vector(e.args[1]))
    if e.op == "neg":
        return scale(Num(-1), scalar(e.args[0]))
    if e.op in ("+", "-", "*", "/", "^"):
        return arithmetic(e)
    return {ONE: free(e)}


def arithmetic(e: Op) -> dict:
    if e.op == "^":
        return power(scalar(e.args[0]), e.args[1], e)
    a, b = scalar(e.args[0]), scalar(e.args[1])
    if e.op in "+-":
        return add(a, b if e.op == "+" else scale(Num(-1), b))
    if e.op == "*":
        return product(a, b)
    if set(b) - {ONE}:
        raise NotPolynomial("it divides by the vector")
    return {m: over(c, b.get(ONE, Num(0))) for m, c in a.items()}


def power(base: dict, exponent: Expr, e: Op) -> dict:
    if not set(base) - {ONE}:
        return {ONE: e}
    if not (isinstance(exponent, Num) and exponent.value in range(DEGREE + 1)):
        raise NotPolynomial("an exponent is not a small whole number")
    result = {ONE: Num(1)}
    for _ in range(int(exponent.value)):
        result = product(result, base)
    return result


def vector(e: Expr) -> tuple:
    """Three polynomials: the components of a vector expression."""
    if isinstance(e, Spin):
        return tuple({tuple(int(k == i) for k in range(3)): Num(1)} for i in range(3))
    if e.op == "vec":
        return tuple(scalar(a) for a in e.args)
    if e.op in ("+", "-"):
        sign = Num(1 if e.op == "+" else -1)
        return tuple(add(a, scale(sign, b)) for a, b in zip(*map(vector, e.args)))
    if e.op == "neg":
        return tuple(scale(Num(-1), a) for a in vector(e.args[0]))
    if e.op == "cross":
        return cross(*map(vector, e.args))
    if e.op in ("*", "/"):
        return scaled(e)
    raise NotPolynomial(f"it uses `{e.op}`")


def scaled(e: Op) -> tuple:
    a, b = e.args
    if kind_of(a) == "s":
        return tuple(product(scalar(a), p) for p in vector(b))
    return tuple(arithmetic_pair(e.op, p, scalar(b)) for p in vector(a))


def arithmetic_pair(op: str, p: dict, q: dict) -> dict:
    if op == "*":
        return product(p, q)
    if set(q) - {ONE}:
        raise NotPolynomial("it divides by the vector")
    return {m: over(c, q[ONE]) for m, c in p.items()}


def free(e: Op) -> Expr:
    """A function of parameters alone."""
    for a in e.args:
        if kind_of(a) != "s" or set(scalar(a)) - {ONE}:
            raise NotPolynomial(f"it uses `{e.op}` of the vector")
    return e


# Polynomials

def add(a: dict, b: dict) -> dict:
    return {m: plus(a[m], b[m]) if m in a and m in b else a.get(m, b.get(m))
            for m in {**a, **b}}


def scale(c: Expr, a: dict) -> dict:
    return {m: times(c, e) for m, e in a.items()}


def product(a: dict, b: dict) -> dict:
    result: dict = {}
    for m, c in a.items():
        for n, d in b.items():
            k = tuple(p + q for p, q in zip(m, n))
            result = add(result, {k: times(c, d)})
    if any(sum(m) > DEGREE for m in result):
        raise NotPolynomial("its degree is too high")
    return result


def dot(u, v) -> dict:
    return add(add(product(u[0], v[0]), product(u[1], v[1])), product(u[2], v[2]))


def cross(u, v) -> tuple:
    def minor(i, j):
        return add(product(u[i], v[j]), scale(Num(-1), product(u[j], v[i])))
    return minor(1, 2), minor(2, 0), minor(0, 1)


# Coefficients: numbers are folded, expressions are kept

def plus(a: Expr, b: Expr) -> Expr:
    return folded("+", a, b, 0, lambda p, q: p + q)


def times(a: Expr, b: Expr) -> Expr:
    if isinstance(a, Num) and a.value == 0 or isinstance(b, Num) and b.value == 0:
        return Num(0)
    return folded("*", a, b, 1, lambda p, q: p * q)


def over(a: Expr, b: Expr) -> Expr:
    if isinstance(a, Num) and isinstance(b, Num):
        q = a.value / b.value
        return Num(int(q)) if q == int(q) else Num(q)
    return a if b == Num(1) else Op("/", (a, b))


def folded(op: str, a: Expr, b: Expr, unit: int, f) -> Expr:
    if isinstance(a, Num) and isinstance(b, Num):
        return Num(f(a.value, b.value))
    if isinstance(a, Num) and a.value == unit:
        return b
    if isinstance(b, Num) and b.value == unit:
        return a
    return Op(op, (a, b))
