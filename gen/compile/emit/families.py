"""The factors of the phase space: sizes, kappa, radius, Casimir."""
from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..derive.derivatives import scalar
from .text import comment, per_site, total

LEVELS = {"sphere": "the sphere of its radius", "r3": "the sphere through w, of radius |w|",
          "nambu": "the level set C = C(w)"}


@dataclass(frozen=True)
class FamilyText:
    """A family's pieces of C: sizes, kernels of kappa, radius and Casimir."""
    name: str
    kind: str
    text: str
    count: str
    first: str
    row: str
    kappa: object
    radius: object
    casimir: object
    rows: tuple
    h_over_kappa: str
    level: str
    level_text: str


def describe(f, spec) -> str:
    kinds = {"sphere": "spheres", "r3": "factors R^3 with the Lie-Poisson bracket", "nambu": "Nambu factors"}
    return kinds[f.kind] + (", tracers" if f.tracer else "")


class FamilyParts:
    """Texts of the families; part of `Emitter`."""

    def family_texts(self):
        texts, first, row = [], [], []
        for f in self.spec.families:
            count = self.low.size(f.count)
            texts.append(self.family_text(f, count, total(first), total(row)))
            first.append(count)
            if f.name in self.plan.coupled:
                row.append(count)
        self.total, self.rows = total(first), total(row)
        return texts

    def family_text(self, f, count, first, row):
        low = self.low
        kappa = low.formula(f.kappa)
        radius = low.formula(f.radius) if f.kind == "sphere" else None
        casimir, rows = self.casimir(f) if f.kind == "nambu" else (None, ())
        return FamilyText(
            f.name, f.kind, comment(describe(f, self.spec)), count, first, row, kappa, radius, casimir, rows,
            self.h_over(f, kappa), self.level(f, radius), LEVELS[f.kind])

    def casimir(self, f):
        """C v, the gradient of C(v) = v.C v/2, in the model's own precision."""
        rows, leaves = self.casimir_rows(f)
        kernel = self.low.kernel(rows, leaves)
        fix = [t.replace("v0[", "v[") for t in kernel.results]
        kernel.lines = [line.replace("v0[", "v[") for line in kernel.lines]
        return kernel, tuple(fix)

    def casimir_rows(self, f):
        """Three sums over the non-zero entries of C, in the symbols v0x, v0y, v0z."""
        entries = [low_entry for row in f.casimir for low_entry in row]
        values, leaves = [], {}
        for e in entries:
            value, more = scalar(e)
            values.append(value)
            leaves.update(more)
        v = sp.symbols("v0x v0y v0z", real=True)
        return [sum(values[3 * r + k] * v[k] for k in range(3)) for r in range(3)], leaves

    def h_over(self, f, kappa):
        """h/kappa, as a product with a hoisted inverse where kappa is the same for all sites."""
        value, leaves = scalar(f.kappa)
        inverse = self.low.kernel([1 / value], leaves)
        if inverse.results[0] in ("1.0", "1"):
            return "h"
        if inverse.lines or per_site(f.kappa):
            return f"h / {self.M}_{f.name}_kappa(c, i)"
        assert isinstance(value, sp.Expr)
        return f"h * ({inverse.results[0]})"

    def level(self, f, radius):
        if f.kind != "sphere":
            return "s->level[k]"
        if radius.lines or per_site(f.radius):
            return f"{self.M}_{f.name}_level(c, i, NULL)"
        return radius.results[0]
