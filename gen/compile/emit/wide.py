"""The last evaluation of a step in extended precision (feature "extended"): its kernels, coefficients and arrays."""
from __future__ import annotations

import re

from ..derive.derivatives import scalar
from ..lower.kernels import function
from ..lower.loops import indent
from ..lower.lowering import CLOCK, PREPARE
from .text import times
from .wideprint import WideLowering


_CALLS = re.compile(r"smg_wide_(exp|log|a?sin|a?cos|a?tan|atan2|sinh|cosh|tanh|floor|pow)\(")


class WideParts:
    """Wide kernels; part of `Emitter`. They exist when `features` holds "extended"."""

    @property
    def extended(self) -> bool:
        return "extended" in self.features

    def wide_arrays(self):
        """Pairs of numbers: three high parts and three low ones for each site."""
        if not self.extended:
            return []
        n6, n3 = times(6, self.total), times(3, self.total)
        return [("low", n3, "low parts of u"), ("wide_m", n6, "midpoints m, high and low parts"),
                ("wide_g", n6, "dH/dw there"), ("wide_v", n6, "h X there"), ("wide_d", n3, "what u lacks of it"),
                ("wide_e", n3, "what v lacks of the solution"),
                ("wide_s", "0" if self.solo else self.total, "m = s mbar"),
                ("wide_y", "0" if self.solo else n3, "change of dH/dw")]

    def wide_text(self) -> str:
        """All of the closing evaluation: coefficients, kernels, evaluation."""
        if not self.extended:
            return ""
        wide = self.wide_low
        terms = [self.wide_gradient(t) for t in self.effects if t.slots]
        families = [self.wide_family(f, text) for f, text in zip(self.spec.families, self.families)]
        effects = [t for t in self.effects if t.slots]
        return self.render("wide.c.j2", kernels="\n\n".join(terms), sites="\n".join(families), solo=self.solo,
                           sums=self.sums(effects, self.wide_body), curvatures=self.sums(effects, self.wide_curvature),
                           prepared=self.wide_values(PREPARE), timed_values=self.wide_values(CLOCK),
                           reads_time=wide.is_timed(), **self.common())

    @property
    def wide_low(self) -> WideLowering:
        """The lowering, made at the first use; tables are shared with the model's own."""
        if not hasattr(self, "_wide_low"):
            self._wide_low = WideLowering(self.spec)
            self._wide_low.used_tables = self.low.used_tables
        return self._wide_low

    def wide_values(self, when: int):
        return [f"wide->{name} = {text};" for name, text, level in self.wide_low.coefficients() if level == when]

    def wide_includes(self):
        """The elementary functions, where a wide kernel calls one."""
        return ["smg_wide_math.h"] if self.extended and _CALLS.search(self.wide_text()) else []

    def wide_names(self):
        """Hoisted members of the struct of wide coefficients."""
        return [name for name, _, _ in self.wide_low.coefficients()]

    def wide_function(self, kind: str, name: str, arguments, lines) -> str:
        declared = [f"const {self.M}_coefficients *c", f"const {self.M}_wide_coefficients *wide", *arguments]
        names = ["c", "wide", *(a.split()[-1].lstrip("*") for a in arguments)]
        return function(f"{kind} {self.M}_wide_{name}", declared, lines, names)

    def wide_gradient(self, t) -> str:
        """g_k += d(term)/d(slot k), all in pairs."""
        kernel = self.wide_low.kernel([x for row in t.derived.gradient for x in row], t.derived.leaves, t.derived.parts)
        slots = range(len(t.slots))
        targets = [(f"g{k}", a) for k in slots for a in range(3)]
        lines = [f"smg_wide_into({g}, {a}, {value});" for (g, a), value in zip(targets, kernel.results)
                 if value != "smg_wide_of(0.0)"]
        arguments = [*(f"int64_t {i}" for i in t.over.bound), *(f"smg_real {w}" for w in t.weights()),
                     *(f"const smg_real *v{k}" for k in slots), *(f"smg_real *g{k}" for k in slots)]
        return self.wide_function("void", f"{t.prefix.removeprefix(self.M + '_')}_gradient", arguments,
                                  [*kernel.lines, *lines])

    def wide_body(self, t):
        """The call for one term. What tracers do to others is dropped, as everywhere."""
        spare = [k for k, s in enumerate(t.slots) if self.passive(t) and s[0] not in self.tracers]
        at = [f"6*({self.site(s)})" for s in t.slots]
        given = [f"s->wide_m + {a}" for a in at]
        taken = [f"spare{k}" if k in spare else f"s->wide_g + {a}" for k, a in enumerate(at)]
        name = f"{self.M}_wide_{t.prefix.removeprefix(self.M + '_')}_gradient"
        call = f"{name}({', '.join(['c', 'wide', *t.common()[1:], *given, *taken])});"
        return [f"smg_real spare{k}[6] = {{0, 0, 0, 0, 0, 0}};" for k in spare] + [call]

    def wide_curvature(self, t):
        """y_k += (d2e/dk dl) d_l, in double."""
        felt = {k for k, s in enumerate(t.slots) if not self.passive(t) or s[0] in self.tracers}
        vectors = [f"s->wide_m + 6*({self.site(s)})" for s in t.slots]
        return [t.call(f"hessian_{k}{l}", vectors, f"s->wide_d + 3*({self.site(t.slots[l])})",
                       f"s->wide_y + 3*({self.site(t.slots[k])})") + ";"
                for k, l in t.derived.hessian if k in felt]

    def wide_family(self, f, text) -> str:
        """h/kappa, the radius, and the normal grad C of one family."""
        parts = [self.wide_formula(f"{f.name}_rate", f.kappa, lambda kappa: self.wide_low.step_size() / kappa)]
        if f.kind == "sphere":
            parts.append(self.wide_formula(f"{f.name}_radius", f.radius, lambda radius: radius))
        if f.kind == "nambu":
            parts.append(self.wide_normal(f))
        return "\n\n".join(parts)

    def wide_formula(self, name: str, formula, value) -> str:
        e, leaves = scalar(formula)
        kernel = self.wide_low.kernel([value(e)], leaves)
        return self.wide_function("smg_wide", name, ["int64_t i"], [*kernel.lines, f"return {kernel.results[0]};"])

    def wide_normal(self, f) -> str:
        """n = grad C(v) of C(v) = v.C v/2."""
        rows, leaves = self.casimir_rows(f)
        kernel = self.wide_low.kernel(rows, leaves)
        lines = [*kernel.lines, *(f"n[{a}] = {value};" for a, value in enumerate(kernel.results))]
        lines = [re.sub(r"smg_wide_load\(v0, (\d)\)", r"v[\1]", line) for line in lines]
        return self.wide_function("void", f"{f.name}_normal", ["const smg_wide *v", "smg_wide *n"], lines)


def wide_members(names):
    """Members of the struct, for the header."""
    return indent([f"smg_wide {name};" for name in ("h", "t", *names)])
