"""The interface: parameters, their checks and hoisted values, header, flat functions for ctypes."""
from __future__ import annotations

from ... import __version__ as VERSION
from ...language import limits
from ...language.spec import Graph, Lattice
from ..lower.cprint import number
from ..lower.kernels import function
from ..lower.loops import indent
from ..lower.lowering import CLOCK, PREPARE
from .statics import Static
from .text import comment



class InterfaceParts:
    """Header, parameters and flat functions; part of `Emitter`."""

    def interface(self):
        terms = [("energy", t) for t in self.effects] + [("observe", t) for t in self.observables]
        values = [dict(function=f"{kind}_{t.derived.term.name}", sums="\n".join(indent(self.sums([t], self.value_body)))) for kind, t in terms]
        energy = " + ".join(f"{self.M}_energy_{t.derived.term.name}(p, t, w)" for t in self.effects)
        return self.render("interface.c.j2", defaults=self.defaults(), values=values, energy_sum=energy or "0",
                           tangent="tangent" in self.features)

    def defaults(self):
        """Statements of `_defaults`; None where the caller gives all values."""
        if any(p.default is None for p in self.run_time()):
            return None
        lines = []
        for p in self.run_time():
            if p.kind == "array":
                values = ", ".join(number(x) for x in p.default)
                lines.append(f"static const double {p.name}[] = {{{values}}};")
                lines.append(f"p->{p.name} = {p.name};")
            else:
                lines.append(f"p->{p.name} = {int(p.default) if p.kind == 'int' else number(p.default)};")
        return lines

    def run_time(self):
        return [p for p in self.spec.parameters if not p.fixed]

    def checks(self):
        """Sizes that must hold for the loops, the solver and the arrays."""
        lines = [outside(f.count, 1) for f in self.families]
        lines += [outside(n, 1) for n in (self.low.size(p.size) for p in self.run_time() if p.kind == "array") if not n.isdigit()]
        for t in [*self.effects, *self.observables]:
            lines += [f"if ({self.by_name[f].count} <= {k}) return SMG_BAD_PARAMETER;"
                      for f, k in t.slots if isinstance(k, int)]
            if isinstance(t.over, Lattice):
                lines += self.lattice_checks(t)
            if isinstance(t.over, Graph):
                lines += self.graph_checks(t)
        if self.plan.solver == "band":
            lines.append(f"if ({self.rows} < {2 * self.plan.band + 1}) return SMG_BAD_PARAMETER;")
        if self.plan.solver == "sparse":
            lines.append(f"if ({self.rows} != {self.plan.pattern.size}) return SMG_BAD_PARAMETER;")
        return list(dict.fromkeys([*lines, *self.entry_checks()]))

    def lattice_checks(self, t):
        sizes = [self.low.size(s) for s in t.over.size]
        lines = []
        for d, n in enumerate(sizes):
            far = max(abs(offset[d]) for bond in t.over.bonds for _, offset in bond)
            lines.append(outside(n, max(1, far)))
        product = "*".join([*sizes, *([str(t.over.sites)] if t.over.sites > 1 else [])])
        for family in dict.fromkeys(f for f, _ in t.slots if self.by_name[f].count != product):
            lines.append(f"if ({self.by_name[family].count} != {product}) return SMG_BAD_PARAMETER;")
        return lines

    def graph_checks(self, t):
        """Every family that an edge meets has the sites that the graph names."""
        top = max((max(e) for e in t.over.edges), default=-1)
        return [f"if ({self.by_name[f].count} <= {top}) return SMG_BAD_PARAMETER;" for f, _ in t.slots]

    def coefficient_functions(self):
        """smg_sizes, smg_check_sizes, smg_prepare and smg_set_time: what parameters, and what time alone decide."""
        c = ["smg_coefficients *c"]
        sizes = ["c->p = *p;", "c->t = 0;", "c->h = 0;", *(f"c->{name} = {text};" for text, name in self.low.integers.items())]
        timed = ["c->t = t;", *self.hoisted(CLOCK)]
        return [Static("smg_sizes", function("void smg_sizes", [*c, "const smg_params *p"], sizes, []), True),
                Static("smg_check_sizes", function("smg_status smg_check_sizes", ["const smg_coefficients *c"], [*self.checks(), "return SMG_OK;"], ["c"]), True),
                Static("smg_prepare", function("int smg_prepare", c, self.prepare_lines(), ["c"]), True),
                Static("smg_set_time", function("void smg_set_time", [*c, "smg_real t"], timed, []), True)]

    def hoisted(self, when: int):
        return [f"c->{name} = {text};" for name, text, level in self.low.coefficients() if level == when]

    def prepare_lines(self):
        """Once per model: hoisted values of the parameters; 0 when a parameter is not finite."""
        tests = []
        for p in self.run_time():
            if p.kind == "real":
                tests.append(f"finite &= c->p.{p.name} - c->p.{p.name} == 0;")
            elif p.kind == "array":
                tests.append(f"for (int64_t i = 0; i < {self.low.size(p.size)}; ++i) finite &= c->p.{p.name}[i] - c->p.{p.name}[i] == 0;")
        lines = [*tests, *self.hoisted(PREPARE)]
        return ["int finite = 1;", *lines, "return finite;"] if tests else [*lines, "return 1;"]

    def header(self) -> str:
        return self.render(
            "model.h.j2", params=[self.declare(p) for p in self.run_time()], arrays=self.arrays(), H=self.history(), solo=self.solo, midpoint=self.method.of_midpoints, composed=self.method.stages > 1,
            integer_names=list(self.low.integers.values()), effects=[e.name for e in self.spec.effects],
            hoisted_names=[name for name, _, _ in self.low.coefficients()], tangent="tangent" in self.features,
            observables=[o.name for o in self.spec.observables],
            wide_names=self.wide_names(), **self.banner())

    def declare(self, p):
        kind = {"int": "int64_t ", "real": "double ", "array": "const double *"}[p.kind]
        note = ", ".join(x for x in (p.meaning, p.unit and f"[{p.unit}]") if x)
        return dict(declaration=kind + p.name, comment=f"/* {comment(note)} */" if note else "")

    def banner(self):
        spec, plan = self.spec, self.plan
        counts = [f"{t.derived.term.name} {t.operations[1]}" for t in self.effects]
        return dict(
            title=comment(spec.title or spec.name), version=VERSION, digest=spec.digest[:16] or "(no file)",
            method_text=self.method.summary, solver_text=comment(f"{plan.solver}: {plan.reason}"),
            bracket_text=f"{'' if spec.orientation > 0 else 'minus '}w x (1/kappa) dH/dw",
            effects_text=comment(", ".join(e.name for e in spec.effects) or "none"),
            extended=self.extended,
            operations_text=comment("gradient of one term: " + ", ".join(counts)),
            families_text=comment(", ".join(f.name for f in self.families)),
            family_names=comment(", ".join(f.name for f in self.families)))

    def abi(self) -> str:
        scalars = [p for p in self.run_time() if p.kind != "array"]
        arrays = [p for p in self.run_time() if p.kind == "array"]
        lines = [f"a->p.{p.name} = {'(int64_t)' if p.kind == 'int' else ''}scalars[{k}];"
                 for k, p in enumerate(scalars)]
        lines += [f"a->p.{p.name} = arrays[{k}];" for k, p in enumerate(arrays)]
        return self.render("abi.c.j2", assignments=lines, prototypes=PROTOTYPES(self.M, self.features), tangent="tangent" in self.features,
                           effects=[e.name for e in self.spec.effects],
                           observables=[o.name for o in self.spec.observables], families=self.families)


def outside(size: str, least: int) -> str:
    """The check of a size; beyond `limits.SITES` the products of sizes could overflow."""
    return f"if ({size} < {least} || {size} > {limits.SITES}) return SMG_BAD_PARAMETER;"


def PROTOTYPES(M: str, features=()):
    tangent = [f"int {M}_abi_tangent(void *s, smg_real *v, int64_t columns, int64_t count, int64_t *done)"] if "tangent" in features else []
    return [*tangent, f"void *{M}_abi_new(const double *scalars, const double *const *arrays, const smg_real *w, "
            "double t0, double h, int *status)",
            f"int {M}_abi_steps(void *s, int64_t count, int64_t *done)", f"double {M}_abi_time(void *s)",
            f"int64_t {M}_abi_sites(void *s)", f"void {M}_abi_state(void *s, smg_real *w)",
            f"int64_t {M}_abi_savesize(void *s)", f"void {M}_abi_save(void *s, smg_real *out)",
            f"int {M}_abi_restore(void *s, const smg_real *in)",
            f"void {M}_abi_values(void *s, smg_real *out)", f"void {M}_abi_casimirs(void *s, smg_real *out)",
            f"void {M}_abi_report(void *s, int *iterations, double *residual, int64_t *site, int64_t *partner, "
            "double *reached)",
            f"void {M}_abi_field(void *s, double t, const smg_real *w, smg_real *b)",
            f"void {M}_abi_energy(void *s, double t, const smg_real *w, smg_real *e)",
            f"void {M}_abi_free(void *s)"]
