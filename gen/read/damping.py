"""[effects]: those that damp the sites of a family, with the key `damping`, and `kT` where they are in a heat bath."""
from __future__ import annotations

from ..language.spec import FORMS, Damping, Sites
from . import codes
from .text import meaning
from .tree import Node

KEYS = ("over", "damping", "kT", "form", "meaning")


class DampingReader:
    """Reads one effect; `terms` reads its name and its index family."""

    def __init__(self, terms):
        self.terms, self.problems, self.damped = terms, terms.problems, {}

    def read(self, node: Node) -> Damping:
        if node.has("energy"):
            node.get(next(key for key in ("damping", "kT") if node.has(key))).wrong(
                codes.CONFLICT, f"`{node.label}` has an energy and a damping", "write two effects, an energy and a damping")
        if not node.has("damping"):
            node.get("kT").wrong(codes.MISSING, f"`{node.label}` has a `kT` and no `damping`",
                                 "noise alone heats without end, damping balances it: write `damping = 0.1` beside it")
        node.table(*KEYS)
        name, (over, alpha, form, kT), said = self.problems.together(
            lambda: self.terms.name(node, "effect", ()), lambda: self.law(node), lambda: meaning(node, "meaning"))
        return Damping(name, over, alpha, form, said, kT)

    def law(self, node: Node):
        """(the sites, alpha, the form, kT or None)."""
        over = self.sites(node)
        return (over, *self.problems.together(lambda: self.terms.formulas.free(node.get("damping"), "a damping", over.index),
                                              lambda: self.form(node, self.terms.declared.families[over.family].kind),
                                              lambda: self.temperature(node, over.index)))

    def temperature(self, node: Node, index: str):
        return self.terms.formulas.free(node.get("kT"), "a temperature", index) if node.has("kT") else None

    def sites(self, node: Node) -> Sites:
        """Those of one family on spheres or in R^3, that no other effect damps."""
        over = self.terms.over(node, "damping")
        at = node.get("over") if node.has("over") else node
        if not isinstance(over, Sites):
            at.wrong(codes.OVER, "a damping acts on the sites of a family", 'write `over = "site(i) of w"`')
        self.terms.known({over.family})
        family = self.terms.declared.families[over.family]
        if family.kind == "nambu" or family.tracer:
            what = "are tracers, which follow what carries them" if family.tracer else "are on Nambu leaves"
            at.wrong(codes.NOT_HERE, f"the sites of `{family.name}` {what}", "a damping is for sites on spheres or in R^3")
        if over.family in self.damped:
            at.wrong(codes.CONFLICT, f"`{self.damped[over.family]}` damps the sites of `{over.family}` already", "write one damping with the sum of both")
        self.damped[over.family] = node.name
        return over

    def form(self, node: Node, kind: str) -> str:
        """Gilbert's unless another is given; in R^3 that of Landau and Lifshitz alone, where alpha is in units of 1/|w|."""
        if not node.has("form"):
            return FORMS[kind == "r3"]
        form = node.get("form").string()
        if kind == "r3" and form == FORMS[0]:
            node.get("form").wrong(codes.CHOICE, "Gilbert's damping is for spheres", 'in R^3, where |w| is that of the start, write `form = "ll"`')
        if form not in FORMS:
            node.get("form").wrong(codes.CHOICE, f"`{form}` is no form of damping", " or ".join(f'`"{x}"`' for x in FORMS))
        return form
