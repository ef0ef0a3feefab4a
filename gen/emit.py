"""Emission: kernels and a plan -> the C files of a model, through the templates.

The functions here only fill slots; what is C beyond a slot lives in templates/.
"""
from __future__ import annotations

from dataclasses import dataclass
from math import comb

import sympy as sp
from jinja2 import Environment, FunctionLoader, StrictUndefined

from .cprint import number
from .colouring import colouring
from .kernels import DIRECTION, function, term_kernels
from .loops import Loops, graph_name, indent, loop
from .lower import CLOCK, PREPARE, SITE, Lowering
from .indices import safe_indices
from .plan import choose
from .prune import without_uncalled
from . import __version__ as VERSION
from .resources import folder
from .spec import Graph, Lattice, Sites, Spec

HISTORY = 7     # increments kept for the predictor; its degree adapts up to one less
ROWS = 64       # rows of history of a single sphere before they are moved back

METHODS = {"spherical-midpoint": "spherical midpoint (symplectic, order 2)",
           "classical-midpoint": "classical midpoint (comparator: not symplectic on spheres)",
           "moser-veselov": "discrete Moser-Veselov (free body)"}


class Files(dict):
    """File name -> text. `notes`: what was chosen and why, for people."""
    notes: dict


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


def read_template(name: str) -> str:
    return (folder("templates") / name).read_text()


def read_runtime(name: str) -> str:
    return (folder("runtime") / name).read_text()


def environment() -> Environment:
    return Environment(loader=FunctionLoader(read_template), undefined=StrictUndefined,
                       keep_trailing_newline=True)


def comment(text: str) -> str:
    """User text inside a C comment: one line, printable ASCII, no comment ends."""
    plain = "".join(c if 32 <= ord(c) < 127 else "?" for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??/", "?? /").rstrip("\\")[:200]


class Emitter:
    """Emission of one model with one method."""

    def __init__(self, spec: Spec, method: str, solver: str):
        self.spec = safe_indices(spec)
        self.method = method
        self.plan = choose(self.spec, method, solver)
        self.low = Lowering(self.spec)
        self.M = spec.name
        self.families = self.family_texts()
        self.by_name = {f.name: f for f in self.families}
        self.loops = Loops(self.low, lambda family: self.by_name[family].count)
        self.effects = [term_kernels(self.low, e, "effect") for e in self.spec.effects]
        self.observables = [term_kernels(self.low, o, "observe", False) for o in self.spec.observables]
        self.tracers = {f.name for f in self.spec.families if f.tracer}
        self.env = environment()
        self.solo = self.is_solo()

    # -- families ---------------------------------------------------------------------------
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
        """C v, the gradient of C(v) = v.C v/2, as three sums over the non-zero entries."""
        entries = [low_entry for row in f.casimir for low_entry in row]
        from .derive import scalar
        values, leaves = [], {}
        for e in entries:
            value, more = scalar(e)
            values.append(value)
            leaves.update(more)
        v = sp.symbols("v0x v0y v0z", real=True)
        rows = [sum(values[3 * r + k] * v[k] for k in range(3)) for r in range(3)]
        kernel = self.low.kernel(rows, leaves)
        fix = [t.replace("v0[", "v[") for t in kernel.results]
        kernel.lines = [line.replace("v0[", "v[") for line in kernel.lines]
        return kernel, tuple(fix)

    def h_over(self, f, kappa):
        """h/kappa, as a product with a hoisted inverse where kappa is the same for all sites."""
        from .derive import scalar
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

    # -- sums -------------------------------------------------------------------------------
    def site(self, slot) -> str:
        """The global number of the site at a slot."""
        f = self.by_name[slot[0]]
        return plus(f.first, str(slot[1]))

    def vector(self, array: str, slot) -> str:
        return f"{array} + 3*({self.site(slot)})"

    def sums(self, terms, body):
        lines = []
        for term in terms:
            lines += self.loops.scatter(term.over, lambda _, t=term: body(t))
        return "\n".join(indent(lines))

    def coupled_effects(self):
        return [e for e in self.effects if not self.passive(e)
                and any(f in self.plan.coupled for f, _ in e.slots)]

    def passive(self, term):
        return [s for s in term.slots if s[0] in self.tracers]

    def gradient_body(self, vectors: str, out: str):
        def body(t):
            spare = [k for k, s in enumerate(t.slots) if self.passive(t) and s[0] not in self.tracers]
            outputs = [f"spare{k}" if k in spare else self.vector(out, s) for k, s in enumerate(t.slots)]
            call = t.call("gradient", [self.vector(vectors, s) for s in t.slots], *outputs) + ";"
            return [f"smg_real spare{k}[3] = {{0, 0, 0}};" for k in spare] + [call]
        return body

    def block_body(self, t):
        lines = []
        vectors = [self.vector("s->m", s) for s in t.slots]
        for k, l in t.derived.hessian:
            rows = [plus(self.by_name[t.slots[q][0]].row, str(t.slots[q][1])) for q in (k, l)]
            where = [self.site(t.slots[q]) for q in (k, l)]
            lines.append(f"{self.M}_ADD({where[0]}, {where[1]}, {rows[0]}, {rows[1]}, {t.prefix}_hessian_{k}{l}, "
                         f"{', '.join([*t.common(), *vectors])});")
        return lines

    def value_body(self, t):
        call = t.call("value", [self.vector("w", s) for s in t.slots])
        return [f"smg_add_carry(&sum, &lost, {call});"]

    # -- gathers ----------------------------------------------------------------------------
    def roles(self, family: str):
        """The effects and slots through which a site of `family` feels something."""
        for t in self.effects:
            passive = self.passive(t)
            for k, s in enumerate(t.slots):
                if s[0] == family and (not passive or s in passive):
                    yield t, k

    def gather(self, family: str, what: str, lines):
        out = ["const smg_real *v", "smg_real *y"] if what == "curvature" else ["smg_real *g"]
        place = self.place(family)
        return function(f"void {self.M}_{family}_{what}",
                        [f"const {self.M}_coefficients *c", *(f"int64_t {n}" for n in place),
                         "const smg_real *all", "const smg_real *own", *out], lines,
                        ["c", *place, "all", "own", *(o.split("*")[1] for o in out)]) + "\n"

    def place(self, family: str):
        """What a gather must know of a site: its number and, on a lattice, its cell and place."""
        lattice = self.lattice(family)
        return ["site"] if lattice is None else ["site", "sub", *(f"s{d}" for d in range(len(lattice.size)))]

    def lattice(self, family: str):
        """The lattice that a swept family lives on, when all its bonds agree on it."""
        if not self.plan.rotation or family not in self.plan.coupled:
            return None
        overs = [t.over for t, _ in self.roles(family) if isinstance(t.over, Lattice)]
        same = {(o.size, o.sites) for o in overs}
        return overs[0] if len(same) == 1 else None

    def gather_gradient(self, family: str):
        placed = self.lattice(family) is not None
        lines = []
        for t, k in self.roles(family):
            lines += self.loops.gather(t.over, t.slots[k], lambda _, t=t, k=k: self.gather_body(t, k), placed)
        return self.gather(family, "gather", lines)

    def seen(self, t, k):
        return ["own" if q == k else self.vector("all", s) for q, s in enumerate(t.slots)]

    def gather_body(self, t, k):
        outputs = ["g" if q == k else f"o{q}" for q in range(len(t.slots))]
        spare = [f"smg_real {o}[3] = {{0, 0, 0}};" for o in outputs if o != "g"]
        return [*spare, t.call("gradient", self.seen(t, k), *outputs) + ";"]

    def gather_curvature(self, family: str):
        lines = []
        for t, k in self.roles(family):
            if (k, k) in t.derived.hessian:
                call = t.call(f"hessian_{k}{k}", self.seen(t, k), "v", "y") + ";"
                lines += self.loops.gather(t.over, t.slots[k], lambda _, call=call: [call])
        return self.gather(family, "curvature", lines)

    def is_linear(self, family: str) -> bool:
        return not any((k, k) in t.derived.hessian for t, k in self.roles(family))

    def closed_form(self, f) -> bool:
        """A site alone in a field that does not depend on it: the step is an exact rotation."""
        return self.method == "spherical-midpoint" and f.kind != "nambu" and self.is_linear(f.name)

    # -- sweeps -----------------------------------------------------------------------------
    def sweep_loops(self):
        """All sites of the swept families, those of a lattice by colour."""
        lines = []
        for f in self.chosen(self.plan.coupled):
            call = f"{self.M}_{f.name}_relax(s, h, {{}}, &change);"
            lattice = self.lattice(f.name)
            if lattice is None:
                lines += loop("site", f.count, [call.format("site")])
                continue
            overs = [t.over for t, _ in self.roles(f.name) if isinstance(t.over, Lattice)]
            cells = ", ".join(f"s{d}" for d in range(len(lattice.size)))
            lines += self.loops.by_colour(lattice, colouring(overs),
                                          lambda sub: [call.format(f"site, {sub}, {cells}")])
        return "\n".join(indent(lines))

    def reach(self):
        """Sum of the norms of the Hessian blocks in a row, where they are the same for all sites; else None."""
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

    # -- text -------------------------------------------------------------------------------
    def render(self, template: str, **slots) -> str:
        return self.env.get_template(template).render(M=self.M, method=self.method, BS=self.plan.block, **slots)

    def chosen(self, names):
        return [f for f in self.families if f.name in names]

    def common(self):
        weights = ", ".join("{" + ", ".join(str((-1) ** j * comb(d + 1, j + 1)) for j in range(d + 1)) + "}"
                            for d in range(HISTORY))
        return dict(H=HISTORY, ROWS=ROWS, weights=weights, families=self.families, coupled=self.chosen(self.plan.coupled),
                    local=self.chosen(self.plan.local), total=self.total, N=self.total, order=self.rows,
                    solver=self.plan.solver, newton=self.plan.newton, timed=self.low.is_timed(), rotation=self.plan.rotation, orientation=self.spec.orientation,
                    band=self.plan.band, wrap=self.plan.wrap)

    def arrays(self):
        """The arrays of the state: name, number of entries, meaning."""
        n3, n1 = times(3, self.total), self.total
        found = [("w", n3, "the state: 3 numbers per site"), ("carry", n3, "what w has lost to rounding"),
                 ("u", n3, "increment W - w of the step under way")]
        if self.solo:
            found.append(("rows", str(4 * ROWS), "history: increment and 1/|w + W| of each step, newest first"))
        if any(f.kind != "sphere" for f in self.families):
            found.append(("level", n1, "|w| or C(w): the leaf each site is on"))
        found.append(("m", n3, "the points where the field is taken") if self.plan.coupled else
                     ("m", "0", "midpoints of coupled sites: none here"))
        if self.plan.coupled:
            found += [("mbar", n3, "midpoints (w + W)/2"), ("g", n3, "dH/dw at m"), ("r", n3, "residual"),
                      ("kept", n3, "a solution whose branch is in doubt"), ("s", n1, "m = s mbar")]
            found += self.matrix_arrays()
        return [dict(name=a, size=b, meaning=c) for a, b, c in found]

    def matrix_arrays(self):
        bs, n = self.plan.block, self.total
        frame = [("G", times(3 * bs, n), "dual rows of the Newton matrix"),
                 ("S", times(3 * bs, n), "tangent columns"), ("x", times(bs, n), "right-hand side and solution")]
        if not self.plan.newton:
            return frame
        return frame + [("A", self.matrix_size(), "Newton matrix"), ("work", self.work_size(), "its factorisation")]

    def matrix_size(self) -> str:
        bs2, n = self.plan.block ** 2, self.rows
        if self.plan.solver == "dense":
            return f"{bs2}*({n})*({n})"
        if self.plan.solver == "band":
            return f"{bs2 * (2 * self.plan.band + 1)}*({n})"
        return str(bs2 * self.plan.pattern.blocks)

    def work_size(self) -> str:
        if self.plan.solver == "dense":
            return f"smg_dense_worksize({self.plan.block}*({self.rows}))"
        if self.plan.solver == "band":
            return f"smg_band_worksize({self.rows}, {self.plan.band})"
        return f"smg_sparse_worksize({self.plan.pattern.size})"

    def tables(self):
        found = [f"static const double {self.M}_table_{name}[] = {{{', '.join(number(x) for x in values)}}};"
                 for name, values in self.low.used_tables.items()]
        graphs = {graph_name(t.over): t.over for t in [*self.effects, *self.observables]
                  if isinstance(t.over, Graph)}
        for name, over in graphs.items():
            found += graph_tables(self.M, name, over, self.plan.rotation or bool(self.tracers))
        if self.plan.solver == "sparse":
            found += pattern_tables(self.M, self.plan.pattern)
        return found

    def step(self):
        slots = self.common()
        slots["gradient"] = self.sums(self.coupled_effects(), self.gradient_body("s->m", "s->g"))
        slots["blocks"] = self.sums(self.coupled_effects(), self.block_body)
        slots["matrix_size"] = self.matrix_size() if self.plan.newton else "0"
        solver_text = ""
        if self.plan.coupled:
            solver_text = self.render("newton.c.j2", **slots)
            if not self.plan.newton or self.plan.rotation:
                solver_text += self.render("sweep.c.j2", **self.sweep_slots(), **slots)
        local_text = "".join(self.render("local.c.j2", f=f, linear=self.closed_form(f), solo=self.solo)
                             for f in self.chosen(self.plan.local))
        solo = self.render("solo.c.j2", f=self.families[0], kernels=self.solo_kernels(), local_text=local_text,
                           **slots) if self.solo else ""
        return self.render("step.c.j2", solo=solo, solver_text=solver_text, local_text=local_text,
                           needs_level=any(f.kind != "sphere" for f in self.families), **slots)

    # -- one unit sphere alone --------------------------------------------------------------
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

    def sweep_slots(self):
        if not self.plan.rotation:
            return dict(sweep_loops="", reach=None, place={})
        return dict(sweep_loops=self.sweep_loops(), reach=self.reach(),
                    place={f: self.place(f) for f in self.plan.coupled})

    def gathers(self):
        text = []
        local = self.plan.local
        for f in self.families:
            if f.name in local or self.plan.rotation:
                text.append(self.gather_gradient(f.name))
            if f.name in local and not self.closed_form(f):
                text.append(self.gather_curvature(f.name))
        return "\n".join(text)

    def interface(self):
        energies = [dict(function=f"energy_{t.derived.term.name}", sums=self.sums([t], self.value_body))
                    for t in self.effects]
        energies += [dict(function=f"observe_{t.derived.term.name}", sums=self.sums([t], self.value_body))
                     for t in self.observables]
        energy = " + ".join(f"{self.M}_energy_{t.derived.term.name}(p, t, w)" for t in self.effects)
        return self.render("interface.c.j2", defaults=self.defaults(), arrays=self.arrays(), solo=self.solo,
                           checks=self.checks(), energies=energies, energy_sum=energy or "0",
                           field_sums=self.sums(self.effects, self.gradient_body("w", "b")), **self.common())

    def defaults(self):
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
        """Sizes that must hold for the loops and the solver."""
        lines = [f"if ({f.count} < 1) return SMG_BAD_PARAMETER;" for f in self.families]
        for t in [*self.effects, *self.observables]:
            if isinstance(t.over, Lattice):
                lines += self.lattice_checks(t)
            if isinstance(t.over, Graph):
                top = max((max(e) for e in t.over.edges), default=-1)
                lines.append(f"if ({self.by_name[t.slots[0][0]].count} <= {top}) return SMG_BAD_PARAMETER;")
        if self.plan.solver == "band":
            lines.append(f"if ({self.rows} < {2 * self.plan.band + 1}) return SMG_BAD_PARAMETER;")
        if self.plan.solver == "sparse":
            lines.append(f"if ({self.rows} != {self.plan.pattern.size}) return SMG_BAD_PARAMETER;")
        return list(dict.fromkeys(lines))

    def lattice_checks(self, t):
        sizes = [self.low.size(s) for s in t.over.size]
        lines = []
        for d, n in enumerate(sizes):
            far = max(abs(offset[d]) for bond in t.over.bonds for _, offset in bond)
            lines.append(f"if ({n} < {max(1, far)}) return SMG_BAD_PARAMETER;")
        product = "*".join([*sizes, str(t.over.sites)])
        for family in dict.fromkeys(f for f, _ in t.slots):
            lines.append(f"if ({self.by_name[family].count} != {product}) return SMG_BAD_PARAMETER;")
        return lines

    def sizes_text(self):
        lines = [f"k->p = *p;", "k->t = 0;", f"const {self.M}_coefficients *c = k;", "(void)c;"]
        lines += [f"k->{name} = {text};" for text, name in self.low.integers.items()]
        return "\n".join([f"static void {self.M}_sizes({self.M}_coefficients *k, const {self.M}_params *p) {{",
                          *indent(lines), "}"])

    def prepare_text(self):
        """Once per model: hoisted values of the parameters; 0 when a parameter is not finite."""
        lines = [f"const {self.M}_coefficients *c = k;", "int finite = 1;", "(void)c;"]
        for p in self.run_time():
            if p.kind == "real":
                lines.append(f"finite &= c->p.{p.name} - c->p.{p.name} == 0;")
            elif p.kind == "array":
                lines.append(f"for (int64_t i = 0; i < {self.low.size(p.size)}; ++i) "
                             f"finite &= c->p.{p.name}[i] - c->p.{p.name}[i] == 0;")
        lines += [f"k->{name} = {text};" for name, text, level in self.low.coefficients() if level == PREPARE]
        return "\n".join([f"static int {self.M}_prepare({self.M}_coefficients *k) {{",
                          *indent([*lines, "return finite;"]), "}"])

    def clock_text(self):
        lines = [f"const {self.M}_coefficients *c = k;", "k->t = t;", "(void)c;"]
        lines += [f"k->{name} = {text};" for name, text, level in self.low.coefficients() if level == CLOCK]
        return "\n".join([f"static void {self.M}_clock({self.M}_coefficients *k, smg_real t) {{", *indent(lines), "}"])

    def sites_text(self):
        return "\n".join(self.render("family.c.j2", f=f, needs_blocks=self.has_frame(f), needs_newton=self.has_newton(f))
                         for f in self.families)

    def has_frame(self, f) -> bool:
        """Does the branch check or Newton need the blocks of this family?"""
        return f.name in self.plan.coupled or not self.closed_form(f)

    def has_newton(self, f) -> bool:
        return self.plan.newton if f.name in self.plan.coupled else not self.closed_form(f)

    def includes(self):
        names = ["smg_site.h", "smg_spin.h"]
        if self.plan.newton:
            names.append(f"smg_{self.plan.solver}.h")
        if self.solo:
            names.append("smg_vec.h")
        return names

    def source(self) -> str:
        kernels = "\n\n".join(t for k in [*self.effects, *self.observables] for t in k.text)
        body = dict(kernels=kernels, sites=self.sites_text(), sums=self.gathers(), step=self.step(),
                    interface=self.interface())
        # last, for they list what the parts above asked for
        body |= dict(prepare=self.sizes_text() + "\n\n" + self.prepare_text(), clock=self.clock_text(),
                     tables=self.tables(), includes=self.includes())
        return without_uncalled(self.render("model.c.j2", **body, **self.banner()))

    def header(self) -> str:
        return self.render(
            "model.h.j2", params=[self.declare(p) for p in self.run_time()], arrays=self.arrays(), H=HISTORY, solo=self.solo,
            integer_names=list(self.low.integers.values()), effects=[e.name for e in self.spec.effects],
            hoisted_names=[name for name, _, _ in self.low.coefficients()],
            observables=[o.name for o in self.spec.observables], **self.banner())

    def declare(self, p):
        kind = {"int": "int64_t ", "real": "double ", "array": "const double *"}[p.kind]
        note = ", ".join(x for x in (p.meaning, p.unit and f"[{p.unit}]") if x)
        return dict(declaration=kind + p.name, comment=f"/* {comment(note)} */" if note else "")

    def banner(self):
        spec, plan = self.spec, self.plan
        counts = [f"{t.derived.term.name} {t.operations[1]}" for t in self.effects]
        return dict(
            title=comment(spec.title or spec.name), version=VERSION, digest=spec.digest[:16] or "(no file)",
            method_text=METHODS[self.method], solver_text=comment(f"{plan.solver}: {plan.reason}"),
            bracket_text=f"{'' if spec.orientation > 0 else 'minus '}w x (1/kappa) dH/dw",
            effects_text=comment(", ".join(e.name for e in spec.effects) or "none"),
            operations_text=comment("gradient of one term: " + ", ".join(counts)),
            families_text=comment(", ".join(f.name for f in self.families)),
            family_names=comment(", ".join(f.name for f in self.families)))

    def abi(self) -> str:
        scalars = [p for p in self.run_time() if p.kind != "array"]
        arrays = [p for p in self.run_time() if p.kind == "array"]
        lines = [f"a->p.{p.name} = {'(int64_t)' if p.kind == 'int' else ''}scalars[{k}];"
                 for k, p in enumerate(scalars)]
        lines += [f"a->p.{p.name} = arrays[{k}];" for k, p in enumerate(arrays)]
        return self.render("abi.c.j2", assignments=lines, prototypes=PROTOTYPES(self.M),
                           effects=[e.name for e in self.spec.effects],
                           observables=[o.name for o in self.spec.observables], families=self.families)


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


def meetings(t, k: int, subs: int):
    """How often a site of each place in the cell stands at slot k of a term: [(sub, times)]."""
    if isinstance(t.over, Sites):
        return [(sub, 1) for sub in range(subs)]
    position = t.over.indices.index(t.slots[k][1])
    places = [bond[position][0] for bond in t.over.bonds]
    return [(sub, places.count(sub)) for sub in range(subs)]


LEVELS = {"sphere": "the sphere of its radius", "r3": "the sphere through w, of radius |w|",
          "nambu": "the level set C = C(w)"}


def PROTOTYPES(M: str):
    return [f"void *{M}_abi_new(const double *scalars, const double *const *arrays, const smg_real *w, "
            "double t0, double h, int *status)",
            f"int {M}_abi_steps(void *s, int64_t count, int64_t *done)", f"double {M}_abi_time(void *s)",
            f"int64_t {M}_abi_sites(void *s)", f"void {M}_abi_state(void *s, smg_real *w)",
            f"void {M}_abi_values(void *s, smg_real *out)", f"void {M}_abi_casimirs(void *s, smg_real *out)",
            f"void {M}_abi_report(void *s, int *iterations, double *residual, int64_t *site)",
            f"void {M}_abi_field(void *s, double t, const smg_real *w, smg_real *b)",
            f"void {M}_abi_energy(void *s, double t, const smg_real *w, smg_real *e)",
            f"void {M}_abi_free(void *s)"]


def describe(f, spec) -> str:
    kinds = {"sphere": "spheres", "r3": "factors R^3 with the Lie-Poisson bracket", "nambu": "Nambu factors"}
    return kinds[f.kind] + (", tracers" if f.tracer else "")


def per_site(e) -> bool:
    from .lower import index_names
    return bool(index_names(e))


def total(parts) -> str:
    """Sum of size texts, folded where both are numbers."""
    known = sum(int(p) for p in parts if p.isdigit())
    rest = [p for p in parts if not p.isdigit()]
    return " + ".join([*rest, *([str(known)] if known or not rest else [])])


def plus(first: str, index: str) -> str:
    if first == "0":
        return index
    return str(int(first) + int(index)) if first.isdigit() and index.isdigit() else f"{first} + {index}"


def times(k: int, n: str) -> str:
    return str(k * int(n)) if n.isdigit() else f"{k}*({n})"


def graph_tables(model: str, name: str, over: Graph, adjacency: bool):
    """Edges, weights and, for sweeps, the edges that each site begins and ends."""
    pairs = ", ".join(f"{{{i}, {j}}}" for i, j in over.edges)
    tables = [f"static const int64_t {model}_{name}_edge[][2] = {{{pairs}}};"]
    for column, values in over.columns:
        tables.append(f"static const double {model}_{name}_{column}[] = {{{', '.join(number(x) for x in values)}}};")
    if adjacency:
        sites = 1 + max((max(e) for e in over.edges), default=0)
        for side, label in ((0, "first"), (1, "second")):
            rows = [[k for k, e in enumerate(over.edges) if e[side] == s] for s in range(sites)]
            starts, at = [0], 0
            for r in rows:
                at += len(r)
                starts.append(at)
            flat = [str(k) for r in rows for k in r] or ["0"]
            tables.append(f"static const int64_t {model}_{name}_{label}_row[] = {{{', '.join(map(str, starts))}}};")
            tables.append(f"static const int64_t {model}_{name}_{label}[] = {{{', '.join(flat)}}};")
    return tables


def pattern_tables(model: str, pattern):
    entries = {"rows": pattern.rowptr, "columns": pattern.col, "diagonal": pattern.diag,
               "place": pattern.place}
    return [f"static const int32_t {model}_{name}[] = {{{', '.join(str(int(x)) for x in values)}}};"
            for name, values in entries.items()]


def generate(spec: Spec, method: str = "spherical-midpoint", solver: str = "auto",
             amalgamate: bool = False) -> Files:
    """The C files of a model: {name}.h, {name}.c, {name}_abi.c; `.notes` says what was chosen.

    `amalgamate` puts the runtime into the two files that a program needs.
    """
    emitter = Emitter(spec, method, solver)
    source = emitter.source()
    name = spec.name
    files = Files({f"{name}.h": emitter.header(), f"{name}.c": source, f"{name}_abi.c": emitter.abi()})
    if amalgamate:
        files = inline_runtime(files, name)
    plan = emitter.plan
    files.notes = {"method": method, "solver": plan.solver, "reason": plan.reason,
                   "local": list(plan.local), "coupled": list(plan.coupled)}
    return files


# A model calls some of the runtime's functions only; in a header no compiler minds.
UNUSED_PUSH = """#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif"""
UNUSED_POP = """#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif"""


def inline_runtime(files: Files, name: str) -> Files:
    """Runtime headers put in the place of their #include, each once."""
    seen: set = set()

    def expand(text: str, outermost: bool = True) -> str:
        lines = []
        for line in text.splitlines():
            included = line.removeprefix('#include "').removesuffix('"') if line.startswith('#include "smg') or \
                line.startswith('#include "smidgen') else None
            if included is None:
                lines.append(line)
            elif included not in seen:
                seen.add(included)
                inside = expand(read_runtime(included), False)
                lines += [UNUSED_PUSH, inside, UNUSED_POP] if outermost else [inside]
        return "\n".join(lines)

    out = Files()
    for key in (f"{name}.h", f"{name}.c"):
        out[key] = expand(files[key]) + "\n"
    out[f"{name}_abi.c"] = files[f"{name}_abi.c"]
    return out
