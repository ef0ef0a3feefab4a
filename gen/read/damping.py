"""[effects]: those that damp the sites of a family, with the key `damping`."""
from __future__ import annotations

from ..language.spec import FORMS, Damping, Sites
from . import codes
from .text import meaning
from .tree import Node

KEYS = ("over", "damping", "form", "meaning")


class DampingReader:
    """Reads one effect; `terms` reads its name and its index family."""

    def __init__(self, terms):
        self.terms, self.problems, self.damped = terms, terms.problems, {}

    def read(self, node: Node) -> Damping:
        if node.has("energy"):
            node.get("damping").wrong(codes.CONFLICT, f"`{node.label}` has an energy and a damping", "write two effects, an energy and a damping")
        node.table(*KEYS)
        name, (over, alpha), form, said = self.problems.together(
            lambda: self.terms.name(node, "effect", ()), lambda: self.law(node), lambda: self.form(node), lambda: meaning(node, "meaning"))
        return Damping(name, over, alpha, form, said)

    def law(self, node: Node):
        """(the sites, alpha)."""
        over = self.sites(node)
        return over, self.terms.formulas.free(node.get("damping"), "a damping", over.index)

    def sites(self, node: Node) -> Sites:
        """Those of one family on spheres, that no other effect damps."""
        over = self.terms.over(node, "damping")
        at = node.get("over") if node.has("over") else node
        if not isinstance(over, Sites):
            at.wrong(codes.OVER, "a damping acts on the sites of a family", 'write `over = "site(i) of w"`')
        self.terms.known({over.family})
        family = self.terms.declared.families[over.family]
        if family.kind != "sphere" or family.tracer:
            what = "are tracers, which follow what carries them" if family.tracer else "are not on spheres"
            at.wrong(codes.NOT_HERE, f"the sites of `{family.name}` {what}", "a damping is for spins on spheres")
        if over.family in self.damped:
            at.wrong(codes.CONFLICT, f"`{self.damped[over.family]}` damps the sites of `{over.family}` already", "write one damping with the sum of both")
        self.damped[over.family] = node.name
        return over

    def form(self, node: Node) -> str:
        if not node.has("form"):
            return FORMS[0]
        form = node.get("form").string()
        if form not in FORMS:
            node.get("form").wrong(codes.CHOICE, f"`{form}` is no form of damping", " or ".join(f'`"{x}"`' for x in FORMS))
        return form
