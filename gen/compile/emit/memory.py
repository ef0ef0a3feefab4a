"""The arrays of a state: what the caller's memory holds."""
from __future__ import annotations

from ..lower.loops import indent
from .text import times, total

HISTORY = 7     # increments kept for the predictor; its degree adapts up to one less
SOLO = 8        # the same of a single sphere, where another row costs less than another iteration
ROWS = 64       # rows of history of a single sphere before they are moved back


class MemoryParts:
    """Names and sizes of the arrays; part of `Emitter`."""

    def history(self) -> int:
        return SOLO if self.solo else HISTORY if self.method.midpoint else self.method.history

    def arrays(self):
        """The arrays of the state: name, number of entries, meaning."""
        n3, n1 = times(3, self.total), self.total
        found = [("w", n3, "the state: 3 numbers per site"), ("compensation", n3, "what w has lost to rounding"),
                 ("u", n3, "increment W - w of the step under way")]
        if not self.method.of_midpoints:
            found += [(name, total([times(size, n1), str(more)]), meaning) for name, size, more, meaning in self.method.arrays]
            return [dict(name=a, size=b, meaning=c) for a, b, c in found]
        if self.solo:
            found.append(("rows", str(4 * ROWS), "history: increment and 1/|w + W| of each step, newest first"))
        if any(f.kind != "sphere" for f in self.families):
            found.append(("leaf_value", n1, "|w| or C(w): the leaf each site is on"))
        found.append(("m", n3, "the points where the field is taken") if self.plan.coupled else
                     ("m", "0", "midpoints of coupled sites: none here"))
        if self.plan.coupled:
            found += [("mbar", n3, "midpoints (w + W)/2"), ("g", n3, "dH/dw at m"), ("r", n3, "residual"),
                      ("s", n1, "m = s mbar")]
            found += self.matrix_arrays()
            found.append(("curve", times(15, self.total), "a branch of solutions followed: its point, tangent, changes"))
        found += [*self.stage_arrays(), *self.wide_arrays()]
        return [dict(name=a, size=b, meaning=c) for a, b, c in found]

    def stage_arrays(self):
        """Of a composition."""
        stages, n3 = self.method.stages, times(3, self.total)
        if stages == 1:
            return []
        found = [("misses", "5", "what every level of the predictor missed in a step, and in how many stages")]
        if self.solo:
            one = "((sizeof(smg_coefficients) + sizeof(smg_real) - 1)/sizeof(smg_real))"
            return [*found, ("prepared", f"2 + {stages // 2 + 1}*{one}", "coefficients for every size of stage, after 1 and the h that they are for")]
        found.append(("before", times(6, self.total), "w and compensation before the step"))
        return [*found, *([("increments", times(stages, n3), "increments of all stages of the step just taken")] if self.stages_kept() else [])]

    def stages_kept(self) -> bool:
        """Does the tangent map need the increments of all stages? A single sphere has them in its history."""
        return self.method.stages > 1 and "tangent" in self.features and not self.solo

    def layout(self):
        """The arrays one after the other in mem; how many numbers they take."""
        lines = ["const smg_coefficients *c = &s->c;", "size_t used = 0;", "(void)c;"]
        lines += [f"used = smg_place_array(&s->{a['name']}, mem, used, (size_t)({a['size']}));" for a in self.arrays()]
        lines.append("return used;" if self.solo or not self.method.of_midpoints else "return smg_place_history(s, mem, used);")
        return "\n".join(["static size_t smg_layout(smg_state *s, smg_real *mem) {", *indent(lines), "}"])

    def matrix_arrays(self):
        bs, n = self.plan.block, self.total
        frame = [("G", times(3 * bs, n), "dual rows of the Newton matrix"),
                 ("S", times(3 * bs, n), "tangent columns"), ("x", times(bs, n), "right-hand side and solution")]
        if self.plan.matrix:
            return frame + [("A", self.matrix_size(), "Newton matrix"), ("work", self.work_size(), "its factorisation")]
        rows, n3 = times(bs, self.rows), times(3, n)
        return frame + [("A", self.matrix_size(), "diagonal blocks of the Newton matrix J"), ("sums", rows, "row sums of abs(J - I)"),
                        ("mean", rows, "the same of (J + J^T)/2"), ("v", n3, "a change of the midpoints"),
                        ("hessian_v", n3, "the change of dH/dw that it makes, d2H/dw2 v"), ("product", rows, "half of a product with J"), ("work", self.work_size(), "basis of a Krylov space")]

    def matrix_size(self) -> str:
        bs2, n = self.plan.block ** 2, self.rows
        if self.plan.solver == "dense":
            return f"{bs2}*({n})*({n})"
        if self.plan.solver == "band":
            return f"{bs2 * (2 * self.plan.band + 1)}*({n})"
        if not self.plan.matrix:
            return times(bs2, n)
        return str(bs2 * self.plan.pattern.blocks)

    def work_size(self) -> str:
        if self.plan.solver == "dense":
            return self.matrix_size()
        if self.plan.solver == "band":
            return f"smg_band_worksize({self.rows}, {self.plan.band})"
        if not self.plan.matrix:
            return f"smg_krylov_worksize({times(self.plan.block, self.rows)})"
        return f"smg_sparse_worksize({self.plan.pattern.size})"
