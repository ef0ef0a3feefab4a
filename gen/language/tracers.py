"""Which effects move tracers alone: those that run over a family of tracers, or name one. One rule for every stage."""
from __future__ import annotations


def moves_tracers(over, slots, tracers) -> bool:
    """Does an effect over `over`, whose term depends on the vectors `slots`, hold tracers? All others then move as if it were not there."""
    bound = getattr(over, "families", ()) or (getattr(over, "family", ""),)
    return not tracers.isdisjoint((*bound, *(family for family, _ in slots)))
