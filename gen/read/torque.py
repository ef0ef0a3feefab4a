"""[effects]: torques, with the key `torque`: they move a site as they stand, on its sphere."""
from __future__ import annotations

from ..language import limits
from ..language.expr import Op, Spin, walk
from ..language.polynomial import Polynomials, TooLong, dot
from ..language.spec import Once, Torque
from ..language.turning import about, radius_of
from . import codes
from .text import meaning
from .tree import Node
from .work import derivatives

KEYS = ("over", "torque", "on", "meaning", "unit")
CROSS = "write it with the vector as a factor, `cross({}, ..)`: that is tangent whatever stands beside it"


class TorqueReader:
    """Reads one effect; `terms` reads its name and its index family."""

    def __init__(self, terms):
        self.terms, self.problems, self.formulas = terms, terms.problems, terms.formulas

    def read(self, node: Node) -> Torque:
        for other in ("energy", "damping", "kT", "form"):
            if node.has(other):
                node.get(other).wrong(codes.CONFLICT, f"`{node.label}` has a torque and `{other}`", "write two effects, each with a key of its own")
        node.table(*KEYS)
        name, (over, value, on), said, unit = self.problems.together(
            lambda: self.terms.name(node, "effect", ()), lambda: self.term(node),
            lambda: meaning(node, "meaning"), lambda: meaning(node, "unit"))
        return Torque(name, over, value, said, unit, on)

    def term(self, node: Node):
        """(the index family, the torque, the vector that it moves)."""
        over, formula = self.problems.together(lambda: self.terms.over(node, "torque"), lambda: node.get("torque"))
        scope = self.terms.scope(over, "effect")
        value = self.formulas.vector(formula.text(), scope)
        on = self.moved(node, over, value, scope)
        self.allowed(node, formula, on, value)
        if not isinstance(over, Once):
            over, value = self.terms.summed(formula, over, value)
        if (work := derivatives(value)) > limits.DERIVATIVES:
            formula.wrong(codes.BIG, f"the derivatives of `{node.name}` take some {work} operations; at most {limits.DERIVATIVES} are "
                          "allowed", "write it as several effects, each with some terms of the sum, or shorter")
        self.tangent(formula, on, value)
        return over, value, on

    def moved(self, node: Node, over, value, scope) -> Spin:
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

    def allowed(self, node: Node, formula: Node, on: Spin, value) -> None:
        """Sites on spheres or in R^3; no tracers, which act on none and follow what carries them."""
        declared = self.terms.declared.families
        self.terms.known({on.family, *(e.family for e in walk(value) if isinstance(e, Spin))})
        if declared[on.family].kind == "nambu":
            formula.wrong(codes.NOT_HERE, f"the sites of `{on.family}` are on Nambu leaves", "a torque is for sites on spheres or in R^3")
        if declared[on.family].tracer or self.terms.tracers(value):
            formula.wrong(codes.NOT_HERE, "this torque moves or names tracers, which follow what carries them", "write it for families that are no tracers")

    def tangent(self, formula: Node, on: Spin, value) -> None:
        """w . torque = 0 on the sphere, in R^3 everywhere; or the error says what is left."""
        if about(value, on) is not None or self.terms.declared.rough & {on.family}:
            return
        radius = radius_of(self.terms.declared.families[on.family], on)
        sums = Polynomials(on, radius and Op("*", (radius, radius)))
        try:
            left = sums.reduced(dot(sums.vector(on), sums.vector(value)))
        except TooLong:
            formula.wrong(codes.BIG, "this torque is too long to be seen to be tangent", CROSS.format(self.spelt(on)))
        if left:
            where = "on the sphere" if radius else "for every vector"
            formula.wrong(codes.NORMAL, f"this torque leaves the sphere: of `dot({self.spelt(on)}, torque)`, which is to be 0 {where}, there is left "
                          f"{sums.text(left)}", CROSS.format(self.spelt(on)))

    @staticmethod
    def spelt(on: Spin) -> str:
        return f"{on.family}[{on.slot}]"
