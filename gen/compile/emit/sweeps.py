"""Visits of every coupled site in the order of a sweep, and a bound that shows a contraction."""
from __future__ import annotations

import sympy as sp

from ...language.spec import Lattice, Sites
from ..lower.kernels import function
from ..lower.loops import loop
from ..lower.lowering import CLOCK
from ..plan.colouring import colouring, one_colour
from .statics import Static
from .text import plus


class SweepParts:
    """Visits; part of `Emitter`."""

    def visits(self):
        """smg_each, cell by cell, and smg_each_coloured, colour after colour."""
        found = []
        if self.plan.coupled and (self.plan.rotation or "tangent" in self.features and self.lifts()):
            found.append(self.visit("smg_each", False))
        if self.plan.rotation:
            found.append(self.visit("smg_each_coloured", True))
            if self.reach() is not None:
                found.append(Static("smg_hessian_row_norm", self.by_family("smg_real smg_hessian_row_norm", ["const smg_coefficients *c", "int64_t k"],
                                                                lambda f: [f"return {self.reach()[f.name]};"], self.chosen(self.plan.coupled)), True))
        return found

    def visit(self, name: str, coloured: bool):
        arguments = ["const smg_coefficients *c", "void *context", "void (*visit)(void *context, smg_lattice_site at)"]
        lines = [line for f in self.chosen(self.plan.coupled) for line in self.visit_family(f, coloured)]
        text = function(f"void {name}", arguments, lines, ["c"])
        return Static(name, text.replace("static inline", "SMG_INLINE", 1), True)     # so that the call of `visit` is inlined too

    def visit_family(self, f, coloured: bool):
        """Calls of `visit` for all sites of a family."""
        def call(sub: str, cells: str):
            return [f"const smg_lattice_site at = {{{plus(f.first, 'site')}, {sub}, {cells}}};", "visit(context, at);"]
        lattice = self.lattice(f.name)
        if lattice is None:
            return loop("site", f.count, call("0", "0, 0, 0, 0"))
        overs = [t.over for t, _ in self.roles(f.name) if isinstance(t.over, Lattice)]
        colours = colouring(overs) if coloured else one_colour(lattice)
        cells = ", ".join([f"s{d}" for d in range(len(lattice.size))] + ["0"] * (4 - len(lattice.size)))
        return self.loops.by_colour(lattice, colours, lambda sub: call(str(sub), cells))

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
