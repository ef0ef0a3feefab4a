"""Rotation sweeps: the order of the sites, and a bound that shows a contraction."""
from __future__ import annotations

import sympy as sp

from ...language.spec import Lattice, Sites
from ..lower.loops import indent, loop
from ..lower.lowering import CLOCK
from ..plan.colouring import colouring, one_colour


class SweepParts:
    """Loops of a sweep; part of `Emitter`."""

    def sweep_loops(self, what: str, result: str, coloured: bool):
        """Calls of `what` for all sites of the swept families, on a lattice cell by cell or by colour."""
        lines = []
        for f in self.chosen(self.plan.coupled):
            call = f"{self.M}_{f.name}_{what}(s, h, {{}}, &{result});"
            lattice = self.lattice(f.name)
            if lattice is None:
                lines += loop("site", f.count, [call.format("site")])
                continue
            overs = [t.over for t, _ in self.roles(f.name) if isinstance(t.over, Lattice)]
            colours = colouring(overs) if coloured else one_colour(lattice)
            cells = ", ".join(f"s{d}" for d in range(len(lattice.size)))
            lines += self.loops.by_colour(lattice, colours,
                                          lambda sub: [call.format(f"site, {sub}, {cells}")])
        return "\n".join(indent(lines))

    def sweep_slots(self):
        if not self.plan.rotation:
            return dict(sweep_loops="", close_loops="", reach=None, place={})
        return dict(sweep_loops=self.sweep_loops("relax", "change", True),
                    close_loops=self.sweep_loops("close", "found", False), reach=self.reach(),
                    place={f: self.place(f) for f in self.plan.coupled})

    def reach(self):
        """Sum of the norms of the Hessian blocks in a row, where they are the same for all sites; else None."""
        if any(f.kind == "nambu" for f in self.chosen(self.plan.coupled)):
            return None
        found = {}
        for f in self.chosen(self.plan.coupled):
            rows = [0] * max([t.over.sites for t, _ in self.roles(f.name) if isinstance(t.over, Lattice)] or [1])
            for t, k in self.roles(f.name):
                norm = self.block_norm(t, k)
                if norm is None:
                    return None
                for sub, times_seen in meetings(t, k, len(rows)):
                    rows[sub] += times_seen * norm
            kernel = self.low.kernel(rows, {})
            if kernel.lines:
                return None
            found[f.name] = " + ".join(f"({r})" for r in dict.fromkeys(kernel.results))
        return found

    def block_norm(self, t, k):
        """Frobenius norm of the row of Hessian blocks of slot k, if no site enters it."""
        if not isinstance(t.over, (Lattice, Sites)):
            return None
        total_norm = sp.S.Zero
        for (a, _), block in t.derived.hessian.items():
            if a == k:
                values = [self.low.number_values(x) for x in block]
                if any(self.low.when(x) > CLOCK for x in values):
                    return None
                total_norm += sp.sqrt(sum(x ** 2 for x in values))
        return total_norm


def meetings(t, k: int, subs: int):
    """How often a site of each place in the cell stands at slot k of a term: [(sub, times)]."""
    if isinstance(t.over, Sites):
        return [(sub, 1) for sub in range(subs)]
    position = t.over.indices.index(t.slots[k][1])
    places = [bond[position][0] for bond in t.over.bonds]
    return [(sub, places.count(sub)) for sub in range(subs)]
