"""Contributions: what moves sites, by what it offers. A local energy term offers all; a sum by FFT, a damping or a noise would
offer less, and methods, solvers and features say what they ask (`gen/methods.py`).
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from ...errors import UsageError
from ...language.expr import Expr, Idx, Num, Op, slots_of, with_index
from ...language.spec import Damping, Spec
from ...methods import GRADIENT, HESSIAN, METHODS, OFFERS, SITE_GRADIENT, Method
from . import torque as torques
from .torque import plus, times


NONE = (Num(0),) * 3
OF_FIELDS = frozenset((GRADIENT, SITE_GRADIENT, HESSIAN))      # what a torque offers that is a field


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

    @property
    def drag(self) -> Expr:
        """What of a torque R it turns by q w x R although it is to leave torques alone."""
        return self.q if self.lag == Num(0) else Num(0)


@dataclass(frozen=True)
class Contribution:
    """name; slots: the sites (family, slot) that one term joins; over: its index family, None where it is no sum of terms;
    offers: words of `methods.OFFERS`; conservative: is it the gradient of an energy? response: of the family of its slots, where it is
    no energy but tells how that one moves; diffusion: the rate D at which noise turns these sites, a formula as in a `Response`, where there is
    noise; push: (F, Q, o kappa, r) of a torque in closed form; bends: is it a field of its own, beside the gradients?"""
    name: str
    slots: tuple
    over: object = None
    offers: frozenset = OFFERS
    conservative: bool = True
    response: Response | None = None
    diffusion: Expr | None = None
    push: tuple | None = None
    bends: bool = False

    def lacks(self, asked) -> list:
        """What of `asked` it does not offer."""
        return [what for what in asked if what not in self.offers]


def contributions_of(spec: Spec, method: Method | None = None) -> tuple:
    """The effects of a spec: energies of one representative term, whose derivatives are known, dampings, and torques as the method takes them."""
    return (*(Contribution(e.name, slots_of(e.value), e.over) for e in spec.effects),
            *(Contribution(d.name, ((d.over.family, d.over.index),), d.over, conservative=False, response=damped(spec, d),
                           diffusion=None if d.kT is None else diffusion(spec, d)) for d in spec.dampings),
            *(pushing(spec, t, method) for t in spec.torques))


def pushing(spec: Spec, torque, method: Method | None) -> Contribution:
    """In closed form, part of the response of its sites; or a field that it adds to their gradients."""
    found, family = None if method and method.across else torques.closed(torque, spec), torques.family_of(spec, torque)
    if found is None:
        return Contribution(torque.name, torques.slots(torque), torque.over, OF_FIELDS, conservative=False, bends=True)
    strength = times(Num(spec.orientation), family.kappa)
    return Contribution(torque.name, torques.slots(torque), torque.over, conservative=False, push=(*found, strength, family.radius or Num(1)))


def fields_of(spec: Spec, contributions, method: Method) -> tuple:
    """(torque, the field that it adds to dH/dw of the site that it moves), of the torques that are no part of a response."""
    laws, bending = responses_of(contributions), {c.name for c in contributions if c.bends}
    return tuple((t, torques.field(t, spec, laws[t.on.family].drag, method.across)) for t in spec.torques if t.name in bending)


def damped(spec: Spec, damping: Damping) -> Response:
    """Landau and Lifshitz: f = 1, q = o s alpha/r, s the sign of kappa, r = 1 in R^3; Gilbert: both divided by 1 + alpha^2."""
    family = next(f for f in spec.families if f.name == damping.over.family)
    alpha = with_index(damping.alpha, damping.over.index, Idx("i"))
    side = Op("if", (Op(">", (family.kappa, Num(0))), Num(spec.orientation), Num(-spec.orientation)))
    f = Num(1) if damping.form == "ll" else Op("/", (Num(1), Op("+", (Num(1), Op("*", (alpha, alpha))))))
    q = Op("*", (f, Op("*", (side, Op("/", (alpha, family.radius or Num(1)))))))
    return Response(f, q, lag=Num(0) if damping.form == "ll" else Op("*", (side, alpha)))


def diffusion(spec: Spec, damping: Damping) -> Expr:
    """D = alpha kT/(|kappa| r), for Gilbert's form divided by 1 + alpha^2; r = 1 in R^3. The components of a unit vector then forget where they were as
    exp(-2 D t), and exp(-H/kT) is stationary."""
    family = next(f for f in spec.families if f.name == damping.over.family)
    alpha, kT = (with_index(e, damping.over.index, Idx("i")) for e in (damping.alpha, damping.kT))
    size = Op("*", (Op("abs", (family.kappa,)), family.radius or Num(1)))
    rate = Op("/", (Op("*", (alpha, kT)), size))
    return rate if damping.form == "ll" else Op("/", (rate, Op("+", (Num(1), Op("*", (alpha, alpha))))))


def diffusions_of(contributions) -> dict:
    """Family -> its D, of those with noise."""
    return {family: c.diffusion for c in contributions if c.diffusion is not None for family, _ in c.slots}


def responses_of(contributions) -> dict:
    """Family -> its `Response`, of those that have one: a law, with what torques add to it. Raises UsageError where a family has two laws."""
    found = {}
    for c in contributions:
        for family in dict.fromkeys(family for family, _ in c.slots if c.response is not None):
            if family in found:
                raise UsageError(f"'{c.name}' is a second law by which '{family}' moves in its field; there can be one")
            found[family] = c.response
    for c in contributions:
        family = c.slots[0][0] if c.push or c.bends else None
        if family:
            law = found.get(family, Response())
            found[family] = law.pushed(*c.push) if c.push else law
    return found


def require_of_responses(spec: Spec, contributions, method: Method) -> None:
    """Raises UsageError where sites move in their field in a way that the method or their space has no step for."""
    responses = responses_of(contributions)
    if responses and not method.responds:
        fitting = [m.name for m in METHODS.values() if m.responds and m.symmetric and m.stages == 1]
        raise UsageError(f"method {method.name} is for sites that precess in their field alone; use {' or '.join(fitting[:3])}")
    strange = [f.name for f in spec.families if f.name in responses and f.kind == "nambu"]
    if strange:
        raise UsageError(f"sites that do more than precess in their field are on spheres or in R^3, not on Nambu leaves, as '{strange[0]}' is")


def all_offer(contributions, asked) -> bool:
    return not any(c.lacks(asked) for c in contributions)


def require(contributions, asked, who: str, instead: str = "") -> None:
    """Raises UsageError where a contribution does not offer what `who` asks of each."""
    for c in contributions:
        for what in c.lacks(asked):
            raise UsageError(f"{who} needs the {what} of every effect, and '{c.name}' offers none" + (f"; use {instead}" if instead else ""))


def require_of_method(contributions, method: Method) -> None:
    """What the method asks of every contribution, with the methods that ask no more than they offer."""
    fitting = [m.name for m in METHODS.values() if not m.free_body and all_offer(contributions, m.asks)]
    require(contributions, method.asks, f"method {method.name}", " or ".join(fitting[:3]))
    for c in contributions:
        if method.free_body and not c.conservative:
            raise UsageError(f"method {method.name} is for energies alone, and '{c.name}' is no gradient of one")
