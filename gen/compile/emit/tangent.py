"""The tangent map of the step: Hessian times vector for one site, and the text of the solve."""
from __future__ import annotations

from ..lower.kernels import function


class TangentParts:
    """Texts of the feature 'tangent'; part of `Emitter`."""

    def tangent(self) -> str:
        """C text of the tangent map; '' where it was not asked for."""
        if "tangent" not in self.features:
            return ""
        slots = self.common()
        return self.render(
            "tangent.c.j2", gathers=self.tangent_gathers(), solo=self.solo, lifts=self.lifts(),
            load=self.by_site("load", False),
            place={f: self.place(f) for f in self.plan.coupled}, keeps=self.tangent_keeps(),
            bent={f.name for f in self.chosen(self.plan.local) if self.neighbours(f.name)},
            linear={f.name for f in self.families if self.closed_form(f)},
            matrix_size=self.matrix_size() if self.plan.coupled else "0", **slots)

    def tangent_header(self) -> str:
        """The prototypes of the tangent map; '' where it was not asked for."""
        if "tangent" not in self.features:
            return ""
        return self.render("tangent.h.j2")

    def lifts(self) -> bool:
        """Does the leaf of a coupled site move with w?"""
        return self.method == "spherical-midpoint" and any(f.kind != "sphere" for f in self.chosen(self.plan.coupled))

    def tangent_keeps(self) -> str:
        """How many numbers a factorisation keeps beside the state: a permutation, or the matrix it destroys."""
        if self.plan.coupled and self.plan.solver == "dense":
            return f"{self.plan.block}*({self.rows})"
        return self.matrix_size() if self.plan.solver == "sparse" else ""

    def by_site(self, what: str, coloured: bool) -> str:
        """Calls of `what` for all coupled sites, in the order of a sweep."""
        return self.sweep_loops(what, "q", coloured).replace(", &q);", ", q);") if self.plan.coupled else ""

    def neighbours(self, family: str):
        """(term, own slot, other slot) of the Hessian blocks that join a site of `family` to others."""
        return [(t, k, l) for t, k in self.roles(family) for l in range(len(t.slots))
                if l != k and (k, l) in t.derived.hessian]

    def tangent_gathers(self) -> str:
        """y += sum_j B_ij dm_j over the others (bend), and B_ii v of coupled sites (curvature)."""
        text = [self.gather_bend(f.name) for f in self.families]
        text += [self.gather_curvature_of_coupled(f.name) for f in self.chosen(self.plan.coupled)]
        return "\n".join(text)

    def gather_bend(self, family: str) -> str:
        lines = []
        for t, k, l in self.neighbours(family):
            call = t.call(f"hessian_{k}{l}", self.seen(t, k), self.vector("dm", t.slots[l]), "y") + ";"
            lines += self.loops.gather(t.over, t.slots[k], lambda _, call=call: [call], self.lattice(family) is not None)
        place = self.place(family)
        return function(f"void {self.M}_{family}_bend",
                        [f"const {self.M}_coefficients *c", *(f"int64_t {n}" for n in place), "const smg_real *all",
                         "const smg_real *own", "const smg_real *dm", "smg_real *y"], lines,
                        ["c", *place, "all", "own", "dm", "y"]) + "\n"

    def gather_curvature_of_coupled(self, family: str) -> str:
        lines = []
        for t, k in self.roles(family):
            if (k, k) in t.derived.hessian:
                call = t.call(f"hessian_{k}{k}", self.seen(t, k), "v", "y") + ";"
                lines += self.loops.gather(t.over, t.slots[k], lambda _, call=call: [call],
                                           self.lattice(family) is not None)
        return self.gather(family, "curvature", lines)
