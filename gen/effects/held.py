"""Sites that do not move, with the key `pinned`, and sites that are not there, with the key `absent`: a condition on the number of a site.

An absent site is in no term and in no sum: what else stands in a term with it is free of it. States have its vector at (0, 0, r), outputs have 0.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from ..language import codes
from ..language.expr import Expr, Idx, Num, Op, with_index
from ..language.held import ALWAYS, unless
from ..language.spec import Effect, Family, Sites, Spec
from ..language.sublattice import sites_of
from .motion import Contribution, family_of

KINDS = ("pinned", "absent")


class HeldReader:
    """Reads one effect; `terms` reads its name and its index family."""

    def __init__(self, terms):
        self.terms, self.problems = terms, terms.problems

    def read(self, node) -> Held:
        key, *others = [k for k in KINDS if node.has(k)]
        for other in (*others, *(k for k in ("energy", "damping", "kT", "torque") if node.has(k))):
            node.get(other).wrong(codes.CONFLICT, f"`{node.label}` has `{key}` and `{other}`", "write two separate effects")
        node.table("over", key, "meaning")
        name, (over, where), said = self.problems.together(
            lambda: self.terms.name(node, "effect", ()), lambda: self.sites(node, key), lambda: self.terms.text(node, "meaning"))
        return Held(name, over, where, key == "absent", said)

    def sites(self, node, key: str):
        """(the sites, the condition)."""
        over, condition = sites_of(self.terms.over(node, key))
        at = node.get("over") if node.has("over") else node
        if not isinstance(over, Sites):
            at.wrong(codes.OVER, f"`{key}` applies to the sites of a family", 'write `over = "site(i) of w"`')
        self.terms.known({over.family})
        if self.terms.declared.families[over.family].kind == "nambu":
            at.wrong(codes.NOT_HERE, f"the sites of `{over.family}` are on Nambu leaves", f"`{key}` requires sites on spheres or in R^3")
        where = self.terms.formulas.condition(node.get(key), "a condition on sites", over.index, key, over.family)
        return over, where if condition is None else Op("and", (condition, where))


@dataclass(frozen=True)
class Held(Effect):
    """where: a condition on Idx(over.index) and parameters; gone: the sites are absent, not only pinned."""
    name: str
    over: Sites
    where: Expr
    gone: bool = False
    meaning: str = ""

    told_by = keys = KINDS
    reader = HeldReader
    moves = False
    conservative = True
    work = 0, 0

    @property
    def lost(self) -> dict[str, str]:
        return {} if self.gone else {"momentum": "the other sites rotate about sites that do not move"}

    @property
    def formulas(self) -> dict[str, Expr]:
        return {"absent" if self.gone else "pinned": self.where}

    @property
    def families(self) -> set[str]:
        return {self.over.family}

    def mapped(self, over, formula) -> Held:
        return replace(self, over=over(self.over), where=formula(self.where))

    @property
    def untitled(self) -> Held:
        return replace(self, meaning="")

    @property
    def holds(self) -> tuple[str, Expr]:
        return self.over.family, with_index(self.where, self.over.index, Idx("i"))

    @property
    def note(self) -> str:
        return f", sites {'absent' if self.gone else 'pinned'} by {self.name}"

    def contribution(self, spec: Spec, method) -> Contribution:
        family, condition = self.holds
        return Contribution(self.name, ((family, self.over.index),), self.over, moves=share(condition, family_of(spec, family)))


def fixed(family: Family) -> Contribution:
    """Of a family of which no site moves."""
    return Contribution(family.name, ((family.name, "i"),), Sites("i", family.name), moves=share(ALWAYS, family))


def share(condition: Expr, family: Family) -> Expr:
    """0 where the condition holds at the site Idx("i") of a family, else 1."""
    return at_site(condition, Num(0) if family.count == Num(1) else Idx("i"))


def at_site(condition: Expr, site: Expr) -> Expr:
    """0 where the condition holds at a site, else 1: kept, where the site is known by its index."""
    number = with_index(unless(condition), "i", site)
    return Op("kept", (number,)) if isinstance(site, Idx) else number
