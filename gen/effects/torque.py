"""Torques, with the key `torque`: they move a site as they stand, on its sphere.

Those whose turn does not depend on the site itself are part of its response; any other is a field beside dH/dw.
With T = w x R a torque adds o kappa R to the gradient g of the site that it moves, o the orientation: w' = (o/kappa) w x g. That field is no
gradient: its derivatives are blocks of a matrix that need not be symmetric, in the row of that site alone.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from ..language import codes
from ..language.expr import Expr, Idx, Num, Op, Spin, slots_of, timed, walk, with_index
from ..language.polynomial import Polynomials, TooLong, added, dot
from ..language.spec import Effect, Lattice, Once, Sites, Spec, Term
from ..language.units import NONE, TIME, quotient
from ..language.turning import about, of_site, radius_of, turn
from ..methods import GRADIENT, HESSIAN, SITE_GRADIENT
from .motion import Contribution, family_of, times

KEYS = ("over", "torque", "on", "meaning", "unit")
CROSS = "write it with the vector as a factor, `cross({}, ..)`: then it is always tangent"
OF_FIELDS = frozenset((GRADIENT, SITE_GRADIENT, HESSIAN))      # what one offers that is a field
AXES = "xyz"


class TorqueReader:
    """Reads one effect; `terms` reads its name and its index family."""

    def __init__(self, terms):
        self.terms, self.problems, self.formulas = terms, terms.problems, terms.formulas

    def read(self, node) -> Torque:
        for other in ("energy", "damping", "kT", "form"):
            if node.has(other):
                node.get(other).wrong(codes.CONFLICT, f"`{node.label}` has both a torque and `{other}`", "write two separate effects")
        node.table(*KEYS)
        name, (over, value, on), said, unit = self.problems.together(
            lambda: self.terms.name(node, "effect", ()), lambda: self.term(node),
            lambda: self.terms.text(node, "meaning"), lambda: self.terms.text(node, "unit"))
        return Torque(name, over, value, said, unit, on=on)

    def term(self, node):
        """(the index family, the torque, the vector that it moves)."""
        over, formula = self.problems.together(lambda: self.terms.over(node, "torque"), lambda: node.get("torque"))
        scope = self.terms.scope(over, "effect")
        found = self.formulas.vector_number(formula.text(), scope)
        value = found.expr
        on, over = self.moved(node, over, value, scope), self.terms.with_columns(over, value)
        rate = quotient(self.terms.declared.dimensions.get(on.family, NONE), TIME)
        self.formulas.fits(found, formula.text().whole, f"a torque, which is added to w' of `{on.family}`,", rate)
        self.terms.unit_of_effect(node, rate)
        self.allowed(node, formula, on, value)
        if not isinstance(over, Once):
            over, value = self.terms.summed(formula, over, value)
        self.terms.affordable(node, formula, value)
        self.tangent(formula, on, value)
        return over, value, on

    def moved(self, node, over, value, scope) -> Spin:
        """The vector of `on`; without that key of the first index, or the only one of the formula."""
        families = scope.indices
        if node.has("on"):
            on = self.formulas.vector(node.get("on").text(), scope)
            if not isinstance(on, Spin) or families and on.slot not in families:
                first = next(iter(families), 0)
                node.get("on").wrong(codes.CHOICE, "`on` names the vector that the torque moves", f'such as `on = "{families.get(first, "w")}[{first}]"`')
            return on
        if families:
            index, family = next(iter(families.items()))
            return Spin(family, index)
        named = list(dict.fromkeys(e for e in walk(value) if isinstance(e, Spin)))
        if len(named) != 1:
            node.wrong(codes.MISSING, f"`{node.label}` does not say which vector it moves", 'write `on = "w[0]"`, or `over = "site(i) of w"`')
        return named[0]

    def allowed(self, node, formula, on: Spin, value) -> None:
        """Sites on spheres or in R^3; no tracers, which act on none and follow what carries them."""
        declared = self.terms.declared.families
        self.terms.known({on.family, *(e.family for e in walk(value) if isinstance(e, Spin))})
        if declared[on.family].kind == "nambu":
            formula.wrong(codes.NOT_HERE, f"the sites of `{on.family}` are on Nambu leaves", "a torque requires sites on spheres or in R^3")
        if declared[on.family].tracer or self.terms.tracers(value):
            formula.wrong(codes.NOT_HERE, "this torque moves or refers to tracers, which only follow other sites", "use families that are not tracers")

    def tangent(self, formula, on: Spin, value) -> None:
        """w . torque = 0 on the sphere, in R^3 everywhere; or the error says what is left."""
        if about(value, on) is not None or self.terms.declared.rough & {on.family}:
            return
        radius = radius_of(self.terms.declared.families[on.family], on)
        sums = Polynomials(on, radius and Op("*", (radius, radius)))
        try:
            left = sums.reduced(dot(sums.vector(on), sums.vector(value)))
        except TooLong:
            formula.wrong(codes.BIG, "this torque is too long to check whether it is tangent", CROSS.format(self.spelt(on)))
        if left:
            where = "on the sphere" if radius else "for every vector"
            formula.wrong(codes.NORMAL, f"this torque is not tangent to the sphere: `dot({self.spelt(on)}, torque)` must be 0 {where}, but is {sums.text(left)}", CROSS.format(self.spelt(on)))

    @staticmethod
    def spelt(on: Spin) -> str:
        return f"{on.family}[{on.slot}]"


@dataclass(frozen=True)
class Torque(Term, Effect):
    """It moves the site of `on` by w' = .. + value, a vector that is tangent at w, as it stands: without kappa or orientation. Gilbert's
    damping acts on it as on precession."""
    on: Spin | None = None

    key = "torque"
    told_by = ("torque",)
    keys = ("torque", "on")
    reader = TorqueReader
    gives_up = {"by": "torques", "as": "torques act", "symplectic": "torques are not Hamiltonian", "energy": "torques add and remove energy",
                "momentum": "torques act on sites without any reaction on others"}

    def mapped(self, over, formula) -> Torque:
        return replace(super().mapped(over, formula), on=formula(self.on))

    @property
    def pushes(self) -> tuple[str, ...]:
        return (self.on.family,)

    @property
    def lost(self) -> dict[str, str]:
        return dict.fromkeys(("energy", "momentum", "symplectic"), "a torque does not derive from an energy")

    @property
    def moved(self) -> tuple:
        return ((self.on.family, self.on.slot),)

    @property
    def note(self) -> str:
        return f", with the torque {self.name}"

    @property
    def slots(self) -> tuple:
        """The site that it moves first, then those that it depends on."""
        return tuple(dict.fromkeys(((self.on.family, self.on.slot), *slots_of(self.value))))

    def contribution(self, spec: Spec, method) -> Contribution:
        """In closed form, part of the response of its sites; or a field that it adds to their gradients."""
        found, family = None if method and self.opened(spec, method) else closed(self, spec), family_of(spec, self.on.family)
        if found is None:
            return Contribution(self.name, self.slots, self.over, OF_FIELDS, conservative=False, bends=True)
        strength = times(Num(spec.orientation), family.kappa)
        return Contribution(self.name, self.slots, self.over, conservative=False, push=(*found, strength, family.radius or Num(1)))

    def opened(self, spec: Spec, method) -> bool:
        """Is it a field even where it has a closed form? Steps by rows take fields in time, but a response that is the same at all times."""
        return method.across or method.by_field and self.lags(spec) or timed(self.value) and method.pushed_by_rows and any(isinstance(e.over, Lattice) for e in spec.effects)

    def lags(self, spec: Spec) -> bool:
        """Does Gilbert's damping act on it? Its closed form then assumes |w| = r, which does not hold in the stages of methods that leave the sphere."""
        dampings = [e.contribution(spec, None).response for e in spec.effects if self.on.family in e.damps]
        return any(law.lag != Num(0) for law in dampings)

    def field(self, spec: Spec, drag: Expr, across: bool) -> Expr:
        """o kappa R; where a damping of Landau and Lifshitz, which does not act on torques, adds drag w x R to it, what becomes R by that:
        (R - drag w x R)/(1 + drag^2 w.w). across: R is to be across w."""
        w, R = self.on, turn(self.value, self.on, across)
        if drag != Num(0):
            here = of_site(drag, w)
            square = Op("*", (Op("*", (here, here)), Op("dot", (w, w))))
            R = Op("/", (Op("-", (R, Op("*", (here, Op("cross", (w, R)))))), Op("+", (Num(1), square))))
        return Op("*", (times(Num(spec.orientation), of_site(family_of(spec, w.family).kappa, w)), R))


# In closed form

def closed(torque, spec: Spec) -> tuple | None:
    """(F, Q), three formulas in the number Idx('i') each, with torque = w x F + w x (w x Q); None where there are none that are free of vectors.

    Of such a torque the odd part in w is w x F, the even part w x (w x Q) = w (w.Q) - |w|^2 Q, so that its values at the three unit vectors tell F and Q."""
    if not isinstance(torque.over, (Sites, Once)) or slots_of(torque.value) != ((torque.on.family, torque.on.slot),):
        return None
    if isinstance(torque.over, Once) and family_of(spec, torque.on.family).count != Num(1):
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

