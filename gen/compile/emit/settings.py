"""What a model says of itself by macros, and the headers that its method is made of."""
from __future__ import annotations

FEW = 4      # sites of which each gets its own copy of a loop's body: with two a step takes 6 or 7 % fewer instructions, with three 0.5 %
MATRICES = {"dense": "smg_matrix_dense.h", "band": "smg_matrix_band.h", "sparse": "smg_matrix_sparse.h"}


class SettingParts:
    """Macros and headers; part of `Emitter`."""

    def settings(self):
        """(name, value) of every macro that is not 0."""
        coupled, alone, plan = self.chosen(self.plan.coupled), self.chosen(self.plan.local), self.plan
        found = {
            "SMG_BS": plan.block, "SMG_HISTORY": self.history(), "SMG_FAMILIES": len(self.families),
            "SMG_ORIENTATION": 1 if self.spec.orientation > 0 else -1, "SMG_TIMED": self.low.is_timed(),
            "SMG_SINGLE_SPHERE": self.solo, "SMG_HAS_COUPLED": bool(coupled), "SMG_HAS_ALONE": bool(alone),
            "SMG_LEAVES": self.method.midpoint and any(f.kind != "sphere" for f in self.families),
            "SMG_ALONE_LINEAR": any(self.closed_form(f) for f in alone),
            "SMG_ALONE_NEWTON": any(not self.closed_form(f) for f in alone),
            "SMG_COUPLED_NAMBU": any(f.kind == "nambu" for f in coupled),
            "SMG_COUPLED_LIFTED": "tangent" in self.features and self.lifts(),
            "SMG_MATRIX_FREE": bool(coupled) and not plan.matrix, "SMG_SWEPT": plan.swept, "SMG_ROTATION": plan.swept and plan.rotation,
            "SMG_CONSTANT_HESSIAN": plan.swept and plan.rotation and self.reach() is not None,
            "SMG_BAND": plan.band if plan.solver == "band" else 0, "SMG_CYCLIC": plan.solver == "band" and plan.wrap,
            "SMG_FEW": self.rows.isdigit() and int(self.rows) <= FEW and bool(coupled),
            "SMG_ORDER": plan.pattern.size if plan.solver == "sparse" else 0,
            "SMG_EXTENDED": self.extended, "SMG_PLAIN_SUMS": "plain-sums" in self.features,
            "SMG_WIDE_TIMED": self.extended and self.wide_low.is_timed(),
            **dict(self.method.defines), "SMG_UNIT_RADIUS": self.extended and self.method.onto_leaf and self.unit_radius()}
        read = {"SMG_COUPLED_NAMBU": coupled, "SMG_CONSTANT_HESSIAN": plan.swept and plan.rotation, "SMG_CYCLIC": plan.solver == "band"}     # by C itself, not by #if alone
        return [(name, int(value)) for name, value in found.items() if value or read.get(name)]

    def lifts(self) -> bool:
        """Does the leaf of a coupled site move with w?"""
        return self.method.onto_leaf and any(f.kind != "sphere" for f in self.chosen(self.plan.coupled))

    def headers(self):
        """What the functions of the model are written with."""
        return ["smg_model.h", *(["smg_vec.h"] if self.solo else []), *self.wide_includes()]

    def method_header(self):
        """The method, what its step is made of, and its features."""
        names = [self.method.header]
        if not self.method.midpoint:
            return [*names, "smg_saved.h"]
        if self.plan.coupled:
            names.append(MATRICES.get(self.plan.solver, "smg_matrix_free.h"))
        names.append("smg_single_sphere.h" if self.solo else "smg_step.h")
        names += ["smg_saved.h", *(["smg_tangent.h"] if "tangent" in self.features else [])]
        return names
