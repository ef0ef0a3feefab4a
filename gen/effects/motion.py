"""How effects move sites: contributions, by what they offer. A local energy term offers all; a sum by FFT, a damping or a noise would
offer less, and methods, solvers and features say what they ask (`gen/methods.py`).
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from ..language.expr import Expr, Idx, Num, Op, walk
from ..language.spec import Family, Spec
from ..methods import OFFERS

NONE = (Num(0),) * 3


@dataclass(frozen=True)
class Response:
    """How the sites of a family move in the gradient g = dH/dw, o the orientation of the bracket:

        w' = (o/kappa) (w x F + w x (w x Q)),   F = f g + F0,   Q = q g + Q0.

    f, q: formulas of parameters, time and the number Idx('i') of the site in its family; F0, Q0: three of them each. Without a
    response f = 1 and the rest is 0. lag: o s alpha of Gilbert's damping, which torques feel too, s the sign of kappa; 0 of any other response."""
    f: Expr = Num(1)
    q: Expr = Num(0)
    F0: tuple = NONE
    Q0: tuple = NONE
    lag: Expr = Num(0)

    def pushed(self, F, Q, strength: Expr, radius: Expr) -> "Response":
        """With the torque w x F + w x (w x Q), strength = o kappa. Gilbert's damping makes (T + (lag/r) w x T)/(1 + alpha^2) of it."""
        share, across, along = (Num(1), Num(0), Num(0)) if self.lag == Num(0) else (
            self.f, Op("neg", (times(self.lag, radius),)), Op("/", (self.lag, radius)))
        scale = times(share, strength)
        return replace(self, F0=tuple(plus(a, times(scale, plus(x, times(across, y)))) for a, x, y in zip(self.F0, F, Q)),
                       Q0=tuple(plus(a, times(scale, plus(y, times(along, x)))) for a, x, y in zip(self.Q0, F, Q)))

    def times(self, share: Expr) -> "Response":
        """A part of it: all or nothing."""
        return replace(self, f=where(share, self.f), q=where(share, self.q), F0=tuple(where(share, x) for x in self.F0), Q0=tuple(where(share, x) for x in self.Q0))

    @property
    def drag(self) -> Expr:
        """What of a torque R it turns by q w x R although it is to leave torques alone."""
        return self.q if self.lag == Num(0) else Num(0)


@dataclass(frozen=True)
class Contribution:
    """name; slots: the sites (family, slot) that one term joins; over: its index family, None where it is no sum of terms;
    offers: words of `methods.OFFERS`; conservative: is it the gradient of an energy? response: of the family of its slots, where it is
    no energy but tells how that one moves; diffusion: the rate D at which noise turns these sites, a formula as in a `Response`, where there is
    noise; push: (F, Q, o kappa, r) of a torque in closed form; bends: is it a field of its own, beside the gradients? moves: of the
    family of its slots, 1 where a site moves and 0 where it does not, a formula as in a `Response`."""
    name: str
    slots: tuple
    over: object = None
    offers: frozenset = OFFERS
    conservative: bool = True
    response: Response | None = None
    diffusion: Expr | None = None
    push: tuple | None = None
    bends: bool = False
    moves: Expr | None = None

    def lacks(self, asked) -> list:
        """What of `asked` it does not offer."""
        return [what for what in asked if what not in self.offers]


def plus(a: Expr, b: Expr) -> Expr:
    return b if a == Num(0) else a if b == Num(0) else Op("+", (a, b))


def times(a: Expr, b: Expr) -> Expr:
    return Num(0) if Num(0) in (a, b) else b if a == Num(1) else a if b == Num(1) else Op("*", (a, b))


def where(share: Expr, x: Expr) -> Expr:
    """x times a share of 0 or 1; 0 where the share is, also if x is infinite there."""
    by_site = any(isinstance(e, Idx) for e in walk(x)) and not isinstance(share, Num)
    return Op("if", (Op(">", (share, Num(0))), x, Num(0))) if by_site else times(share, x)


def family_of(spec: Spec, name: str) -> Family:
    return next(f for f in spec.families if f.name == name)
