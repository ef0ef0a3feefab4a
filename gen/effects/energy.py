"""Energies, with the key `energy`: the terms of H."""
from __future__ import annotations

from dataclasses import dataclass

from ..language.expr import slots_of
from ..language.spec import Effect, Term
from .motion import Contribution


class EnergyReader:
    """`terms` reads its name, its index family and its formula."""

    def __init__(self, terms):
        self.terms = terms

    def read(self, node) -> Energy:
        return Energy(*self.terms.term(node, "energy", "effect", ()))


@dataclass(frozen=True)
class Energy(Term, Effect):
    """A sum of energies of one representative term, whose derivatives are known: it offers all that is asked."""
    key = "energy"
    told_by = keys = ("energy",)
    reader = EnergyReader
    conservative = True

    def contribution(self, spec, method) -> Contribution:
        return Contribution(self.name, slots_of(self.value), self.over)
