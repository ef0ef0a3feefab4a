"""Contributions: what moves sites, by what it offers. A local energy term offers all; a sum by FFT, a damping or a noise would
offer less, and methods, solvers and features say what they ask (`gen/methods.py`).
"""
from __future__ import annotations

from dataclasses import dataclass

from ...errors import UsageError
from ...language.expr import slots_of
from ...language.spec import Spec
from ...methods import METHODS, OFFERS, Method


@dataclass(frozen=True)
class Contribution:
    """name; slots: the sites (family, slot) that one term joins; over: its index family, None where it is no sum of terms;
    offers: words of `methods.OFFERS`; conservative: is it the gradient of an energy?"""
    name: str
    slots: tuple
    over: object = None
    offers: frozenset = OFFERS
    conservative: bool = True

    def lacks(self, asked) -> list:
        """What of `asked` it does not offer."""
        return [what for what in asked if what not in self.offers]


def contributions_of(spec: Spec) -> tuple:
    """The effects of a spec: energies of one representative term, whose derivatives are known."""
    return tuple(Contribution(e.name, slots_of(e.value), e.over) for e in spec.effects)


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
