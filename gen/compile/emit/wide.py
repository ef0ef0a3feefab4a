"""The last evaluation of a step in extended precision (feature "extended"): its kernels, coefficients and arrays."""
from __future__ import annotations

import re

from ..derive.derivatives import scalar
from ..lower.kernels import function
from ..lower.lowering import CLOCK, PREPARE
from .statics import Static
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

    def wide_functions(self):
        """What runtime/method/smg_extended.h asks of a model: coefficients, and kernels in pairs."""
        if not self.extended:
            return []
        effects = [t for t in self.effects if t.slots]
        found = [*(self.wide_gradient(t) for t in effects), *self.wide_sites(),
                 self.wide_sum("smg_wide_gradient", self.sums(effects, self.wide_body))]
        if not self.solo:
            found.append(self.wide_sum("smg_wide_hessian_vector", self.sums(effects, self.wide_hessian_vector)))
        timed = self.wide_low.is_timed()
        return [*self.wide_coefficients(timed), *found]

    def wide_sum(self, name: str, lines):
        head = ["const smg_coefficients *c = &s->c;", "const smg_wide_coefficients *wide = &s->wide;", "(void)c;", "(void)wide;"]
        return Static(name, function(f"void {name}", ["smg_state *s"], [*head, *lines], ["s"]), True)

    def wide_coefficients(self, timed: bool):
        """Coefficients to all digits; what the caller gave is exact."""
        lines = ["wide->h = smg_wide_of(c->h);", "wide->t = smg_wide_of(0);", *self.wide_values(PREPARE)]
        found = [Static("smg_wide_prepare", function("void smg_wide_prepare", ["smg_wide_coefficients *wide", "const smg_coefficients *c"], lines, ["c"]), True)]
        if timed:
            time = "smg_wide_scale((smg_real)s->count + (smg_real)0.5, smg_wide_of((smg_real)s->h))"
            lines = ["const smg_coefficients *c = &s->c;", "smg_wide_coefficients *wide = &s->wide;",
                     f"wide->t = smg_wide_add(smg_wide_of((smg_real)s->t0), {time});", "(void)c;", *self.wide_values(CLOCK)]
            found.append(Static("smg_wide_set_time", function("void smg_wide_set_time", ["smg_state *s"], lines, []), True))
        return found

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
        text = "\n".join(s.text for s in self.wide_functions())
        return ["smg_wide_math.h"] if _CALLS.search(text) else []

    def wide_names(self):
        """Hoisted members of the struct of wide coefficients."""
        return [name for name, _, _ in self.wide_low.coefficients()]

    def wide_function(self, kind: str, name: str, arguments, lines) -> Static:
        declared = ["const smg_coefficients *c", "const smg_wide_coefficients *wide", *arguments]
        names = ["c", "wide", *(a.split()[-1].lstrip("*") for a in arguments)]
        return Static(name, function(f"{kind} {name}", declared, lines, names))

    def wide_gradient(self, t) -> Static:
        """g_k += d(term)/d(slot k), all in pairs."""
        kernel = self.wide_low.kernel([x for row in t.derived.gradient for x in row], t.derived.leaves, t.derived.parts)
        slots = range(len(t.slots))
        targets = [(f"g{k}", a) for k in slots for a in range(3)]
        lines = [f"smg_wide_into({g}, {a}, {value});" for (g, a), value in zip(targets, kernel.results)
                 if value != "smg_wide_of(0.0)"]
        arguments = [*(f"int64_t {i}" for i in t.over.bound), *(f"smg_real {w}" for w in t.weights()),
                     *(f"const smg_real *v{k}" for k in slots), *(f"smg_real *g{k}" for k in slots)]
        return self.wide_function("void", f"wide_{t.prefix}_gradient", arguments,
                                  [*kernel.lines, *lines])

    def wide_body(self, t):
        """The call for one term. What tracers do to others is dropped, as everywhere."""
        spare = [k for k, s in enumerate(t.slots) if self.passive(t) and s[0] not in self.tracers]
        at = [f"6*({self.site(s)})" for s in t.slots]
        given = [f"s->wide_m + {a}" for a in at]
        taken = [f"spare{k}" if k in spare else f"s->wide_g + {a}" for k, a in enumerate(at)]
        name = f"wide_{t.prefix}_gradient"
        call = f"{name}({', '.join(['c', 'wide', *t.common()[1:], *given, *taken])});"
        return [f"smg_real spare{k}[6] = {{0, 0, 0, 0, 0, 0}};" for k in spare] + [call]

    def wide_hessian_vector(self, t):
        """y_k += (d2e/dk dl) d_l, in double."""
        felt = {k for k, s in enumerate(t.slots) if not self.passive(t) or s[0] in self.tracers}
        vectors = [f"s->wide_m + 6*({self.site(s)})" for s in t.slots]
        return [t.call(f"hessian_{k}{l}", vectors, f"s->wide_d + 3*({self.site(t.slots[l])})",
                       f"s->wide_y + 3*({self.site(t.slots[k])})") + ";"
                for k, l in t.derived.hessian if k in felt]

    def wide_sites(self):
        """h/kappa, the radius, and the normal grad C of every site."""
        site = ["const smg_coefficients *c", "const smg_wide_coefficients *wide", "int64_t k"]
        functions = [("smg_wide_h_over_kappa", "smg_wide", site, lambda f: self.wide_formula(f.kappa, lambda kappa: self.wide_low.step_size() / kappa)),
                     ("smg_wide_normal", "void", [*site, "const smg_wide *v", "smg_wide *n"], self.wide_normal)]
        if any(f.kind == "sphere" for f in self.families) and not self.unit_radius() and self.method.onto_leaf:
            functions.append(("smg_wide_radius", "smg_wide", site, lambda f: self.wide_formula(f.radius, lambda r: r) if f.kind == "sphere" else ["return smg_wide_of(0);"]))
        by_name = {f.name: f for f in self.spec.families}
        return [Static(name, self.by_family(f"{kind} {name}", arguments, lambda f, lines=lines: lines(by_name[f.name])), True)
                for name, kind, arguments, lines in functions]

    def unit_radius(self) -> bool:
        """Are all spheres of radius 1?"""
        return all(f.unit for f in self.families if f.kind == "sphere")

    def wide_formula(self, formula, value):
        e, leaves = scalar(formula)
        kernel = self.wide_low.kernel([value(e)], leaves)
        return [*kernel.lines, f"return {kernel.results[0]};"]

    def wide_normal(self, f):
        """n = grad C(v) of C(v) = v.C v/2."""
        if f.kind != "nambu":
            return [f"n[{a}] = v[{a}];" for a in range(3)]
        rows, leaves = self.casimir_rows(f)
        kernel = self.wide_low.kernel(rows, leaves)
        lines = [*kernel.lines, *(f"n[{a}] = {value};" for a, value in enumerate(kernel.results))]
        return [re.sub(r"smg_wide_load\(v0, (\d)\)", r"v[\1]", line) for line in lines]
