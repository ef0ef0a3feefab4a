"""Torques: those whose turn does not depend on the site itself are part of its response; any other is a field beside dH/dw.

With T = w x R a torque adds o kappa R to the gradient g of the site that it moves, o the orientation: w' = (o/kappa) w x g. That field is no
gradient: its derivatives are blocks of a matrix that need not be symmetric, in the row of that site alone.
"""
from __future__ import annotations

from ...language.expr import Expr, Num, Op, Spin, slots_of, with_index
from ...language.expr import Idx
from ...language.polynomial import Polynomials, TooLong, added
from ...language.spec import Once, Sites, Spec, Torque
from ...language.turning import of_site, turn

AXES = "xyz"


def plus(a: Expr, b: Expr) -> Expr:
    return b if a == Num(0) else a if b == Num(0) else Op("+", (a, b))


def times(a: Expr, b: Expr) -> Expr:
    return Num(0) if Num(0) in (a, b) else b if a == Num(1) else a if b == Num(1) else Op("*", (a, b))


def family_of(spec: Spec, torque: Torque):
    return next(f for f in spec.families if f.name == torque.on.family)


# In closed form

def closed(torque: Torque, spec: Spec) -> tuple | None:
    """(F, Q), three formulas in the number Idx('i') each, with torque = w x F + w x (w x Q); None where there are none that are free of vectors.

    Of such a torque the odd part in w is w x F, the even part w x (w x Q) = w (w.Q) - |w|^2 Q, so that its values at the three unit vectors tell F and Q."""
    if not isinstance(torque.over, (Sites, Once)) or slots_of(torque.value) != ((torque.on.family, torque.on.slot),):
        return None
    if isinstance(torque.over, Once) and family_of(spec, torque).count != Num(1):
        return None
    ends = {a: [at(torque.value, torque.on, unit(a, sign)) for sign in (1, -1)] for a in range(3)}
    odd, even = ({a: halves(op, *pair) for a, pair in ends.items()} for op in "-+")
    F = tuple(part(odd[(a + 1) % 3], AXES[(a + 2) % 3], -1) for a in range(3))      # (e_y x F).z = -F_x
    Q = tuple(part(even[(a + 1) % 3], AXES[a], -1) for a in range(3))               # (e_y x (e_y x Q)).x = -Q_x
    if not same(torque.value, as_turn(torque.on, F, Q), torque.on):
        return None
    index = torque.over.index if isinstance(torque.over, Sites) else ""
    return tuple(tuple(with_index(e, index, Idx("i")) for e in three) for three in (F, Q))


def unit(axis: int, sign: int) -> Op:
    return Op("vec", tuple(Num(sign * (k == axis)) for k in range(3)))


def at(e: Expr, w: Spin, vector: Expr) -> Expr:
    """`e` with a vector in place of `w`."""
    if e == w:
        return vector
    return Op(e.op, tuple(at(a, w, vector) for a in e.args)) if isinstance(e, Op) else e


def halves(op: str, a: Expr, b: Expr) -> Op:
    return Op("/", (Op(op, (a, b)), Num(2)))


def part(vector: Expr, axis: str, sign: int) -> Op:
    return Op("*", (Num(sign), Op(axis, (vector,))))


def as_turn(w: Spin, F, Q) -> Op:
    """w x (F + w x Q)."""
    return Op("cross", (w, Op("+", (Op("vec", F), Op("cross", (w, Op("vec", Q)))))))


def same(a: Expr, b: Expr, w: Spin) -> bool:
    """Are two vectors equal whatever the state is?"""
    sums = Polynomials()
    try:
        return not any(added(x, y, -1) for x, y in zip(sums.vector(a), sums.vector(b)))
    except TooLong:
        return False


# As a field

def field(torque: Torque, spec: Spec, drag: Expr, across: bool) -> Expr:
    """o kappa R; where a damping of Landau and Lifshitz, which does not act on torques, adds drag w x R to it, what becomes R by that:
    (R - drag w x R)/(1 + drag^2 w.w). across: R is to be across w."""
    w, R = torque.on, turn(torque.value, torque.on, across)
    if drag != Num(0):
        here = of_site(drag, w)
        square = Op("*", (Op("*", (here, here)), Op("dot", (w, w))))
        R = Op("/", (Op("-", (R, Op("*", (here, Op("cross", (w, R)))))), Op("+", (Num(1), square))))
    return Op("*", (strength(torque, spec), R))


def strength(torque: Torque, spec: Spec) -> Expr:
    """o kappa of the site that it moves."""
    return times(Num(spec.orientation), of_site(family_of(spec, torque).kappa, torque.on))


def slots(torque: Torque) -> tuple:
    """The site that it moves first, then those that it depends on."""
    return tuple(dict.fromkeys(((torque.on.family, torque.on.slot), *slots_of(torque.value))))
