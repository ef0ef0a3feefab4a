"""One unit sphere alone: kernels by value for the fastest step."""
from __future__ import annotations

import sympy as sp

from ..kernels import DIRECTION, function
from ..lower import SITE


class SoloParts:
    """Kernels of a single sphere; part of `Emitter`."""

    def is_solo(self) -> bool:
        """One unit sphere whose field depends on itself: the fastest step."""
        f = self.families[0]
        return (self.method == "spherical-midpoint" and len(self.families) == 1 and f.count == "1"
                and f.kind == "sphere" and f.level == "1.0" and not self.closed_form(f)
                and all(self.low.level(s.name) < SITE for t in self.effects for b in t.derived.hessian.values()
                        for s in b.free_symbols if s.name[0] != "v"))

    def solo_kernels(self) -> str:
        """Field b = dH/dm, B v, and d.adj(B - beta 1) d of the whole energy, B its Hessian."""
        effects = [t.derived for t in self.effects if t.slots]
        b = [sum(e.gradient[0][a] for e in effects) for a in range(3)]
        B = sum((e.hessian.get((0, 0), sp.zeros(3, 3)) for e in effects), sp.zeros(3, 3))
        d, beta = sp.Matrix(DIRECTION), sp.Symbol("beta", real=True)
        return "\n\n".join([self.solo_kernel("smg_vec", "field", [], b),
                            self.solo_kernel("smg_vec", "times", ["smg_vec d"], list(B * d)),
                            self.solo_kernel("smg_real", "adjugate", ["smg_real beta", "smg_vec d"],
                                             [adjugate_form(B - beta * sp.eye(3), d)])])

    def solo_kernel(self, kind: str, name: str, more, expressions) -> str:
        kernel = self.low.kernel(expressions, {})
        result = f"smg_vec_of({', '.join(kernel.results)})" if kind == "smg_vec" else kernel.results[0]
        body = [by_value(line) for line in [*kernel.lines, f"return {result};"]]
        return function(f"{kind} {self.M}_solo_{name}", [f"const {self.M}_coefficients *c", "smg_vec m", *more],
                        body, ["c", "m", *(x.split()[1] for x in more)])


def adjugate_form(C, d):
    """d.adj(C) d for a symmetric 3x3 matrix."""
    def cofactor(a, b):
        i, j, k, l = (a + 1) % 3, (a + 2) % 3, (b + 1) % 3, (b + 2) % 3
        return C[i, k] * C[j, l] - C[i, l] * C[j, k]
    return sum(cofactor(a, b) * d[a] * d[b] for a in range(3) for b in range(3))


def by_value(line: str) -> str:
    """The arrays v0 and d of a kernel as the vectors m and d by value."""
    for axis in range(3):
        line = line.replace(f"v0[{axis}]", f"m.{'xyz'[axis]}").replace(f"d[{axis}]", f"d.{'xyz'[axis]}")
    return line
