"""Small specs written as `Spec` objects, for the tests of the witness."""
from smidgen.effects.energy import Energy
from smidgen.language.expr import Num, Op, Spin, Time
from smidgen.language.spec import Family, Once, Pairs, Spec

ONE = Num(1.0)


def op(name, *args):
    return Op(name, tuple(Num(a) if isinstance(a, (int, float)) else a for a in args))


def sphere(count=1, kappa=ONE, radius=ONE, name="w", **more):
    return Family(name, "sphere", Num(count), kappa, radius, **more)


def nambu(rows):
    matrix = tuple(tuple(Num(float(x)) for x in row) for row in rows)
    return Family("w", "nambu", Num(1), ONE, casimir=matrix)


def one_term(value, family, over=Once(), **more):
    return Spec("m", "m", (), (family,), (Energy("e", over, value),), **more)


def body(moments, family=None, **more):
    """H = sum w_k^2/(2 I_k)."""
    w = Spin("w", 0)
    parts = [op("/", op("^", op(c, w), 2), 2 * m) for c, m in zip("xyz", moments)]
    return one_term(op("+", op("+", *parts[:2]), parts[2]), family or sphere(), **more)


def precession(rate, **more):
    """H = rate w_z."""
    return one_term(op("*", rate, op("z", Spin("w", 0))), sphere(), **more)


def pulsed():
    """H = sin(3 t) w_x + w_z^2/2 + t w_x w_y: the field changes with time."""
    w = Spin("w", 0)
    x, y, z = (op(c, w) for c in "xyz")
    return one_term(op("+", op("+", op("*", op("sin", op("*", 3, Time())), x),
                               op("/", op("^", z, 2), 2)), op("*", Time(), op("*", x, y))),
                    sphere())


def vortices(count, **more):
    """H = -(1/4 pi) sum_{i<j} ln(2 - 2 w_i.w_j)."""
    return one_term(chord("w", "i", "w", "j"), sphere(count), Pairs("i", "j", "w"), **more)


def chord(f, i, g, j):
    gap = op("-", 2, op("*", 2, op("dot", Spin(f, i), Spin(g, j))))
    return op("*", -0.07957747154594767, op("log", gap))
