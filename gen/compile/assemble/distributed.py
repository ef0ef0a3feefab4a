"""Ranks with memory of their own (runtime/lattice/smg_row_parts.h).

What a model must be for it, and how far the terms of a rank's sites reach.
"""
from __future__ import annotations

from ...errors import UsageError
from ...language.spec import Lattice, Sites
from .asked import Asked


class Distributed(Asked):
    """Every rank of MPI stores its part of the lattice alone."""
    name = "distributed"
    divides = True
    templates = {"public": "distributed.h.j2", "bodies": "distributed.c.j2", "flat": "distributed_abi.c.j2"}

    def fits(self, model):
        if model.in_rows is None or not model.method.midpoint:
            raise UsageError("feature distributed: only lattices processed by rows with a midpoint method can be divided"
                             + f". This one goes site by site, because {model.why_by_site}" * bool(model.why_by_site))
        if len(model.families) > 1:
            raise UsageError("feature distributed: the sites of several families are not stored layer by layer, so the lattice cannot be divided")
        if model.in_rows.timely:
            raise UsageError("feature distributed: the bounds of this model grow with time, so that not every step is processed by rows")
        for term in (*model.spec.energies, *model.spec.observables):
            if why := undivided(model.in_rows.over, term):
                raise UsageError(f"feature distributed: '{term.name}' cannot be summed in parts: {why}")

    def settings(self, model):
        return {"SMG_DISTRIBUTED": 1, "SMG_SLOWEST": slowest(model.in_rows.over), "SMG_PARTS_REACH": reach(model.spec)}


def slowest(over: Lattice) -> int:
    """The last direction of a lattice, along which it is cut."""
    return len(over.size) - 1


def reach(spec) -> int:
    """Cells of the slowest direction that terms reach from a site to others."""
    bonds = [bond for term in (*spec.energies, *spec.observables) if isinstance(term.over, Lattice) for bond in term.over.bonds]
    return max((abs(offset[-1]) for bond in bonds for _, offset in bond), default=0)


def undivided(over: Lattice, term) -> str:
    """Why the values of a term do not follow the order of the sites; "" where they do."""
    if isinstance(term.over, Sites):
        return ""
    if not isinstance(term.over, Lattice):
        return "it is neither over sites nor over bonds of the lattice"
    if (term.over.size, term.over.sites) != (over.size, over.sites):
        return "it is over another lattice"
    if len(over.size) == 1 and len(term.over.bonds) > 1:
        return "on a chain it must be over one kind of bond: write one effect for each"
    return ""
