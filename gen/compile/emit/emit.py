"""Emission: kernels and a plan -> the C files of a model, through the templates.

The functions here only fill slots; what is C beyond a slot lives in templates/.
"""
from __future__ import annotations

from math import comb

from jinja2 import Environment, FunctionLoader, StrictUndefined

from ...language.spec import Graph, Spec
from ...resources import folder
from ..features import chosen_features
from ..lower.cprint import number
from ..lower.indices import one_site, safe_indices
from ..lower.kernels import term_kernels
from ..lower.loops import Loops, graph_name
from ..lower.lowering import Lowering
from ..plan.plan import Plan, choose, require_free_body
from ..program import program_of
from .amalgamate import inline_runtime
from .bounds import BoundParts
from .families import FamilyParts
from .interface import InterfaceParts
from .memory import ROWS, MemoryParts
from .prune import without_uncalled
from .solo import SoloParts
from .sums import SumParts
from .sweeps import SweepParts
from .tables import graph_tables, pattern_tables
from .tangent import TangentParts
from .wide import WideParts


class Files(dict):
    """File name -> text. `notes`: what was chosen and why, for people."""
    notes: dict


def read_template(name: str) -> str:
    return (folder("templates") / name).read_text()


def environment() -> Environment:
    return Environment(loader=FunctionLoader(read_template), undefined=StrictUndefined,
                       keep_trailing_newline=True)


class Emitter(FamilyParts, SumParts, SweepParts, SoloParts, TangentParts, WideParts, MemoryParts, BoundParts, InterfaceParts):
    """Emission of one model with one method."""

    def __init__(self, spec: Spec, plan: Plan, features=()):
        self.features = chosen_features(features)
        self.spec = safe_indices(one_site(spec))
        self.method, self.plan = plan.method, plan
        if plan.method == "moser-veselov":
            require_free_body(self.spec)
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

    def render(self, template: str, **slots) -> str:
        return self.env.get_template(template).render(M=self.M, method=self.method, BS=self.plan.block, **slots)

    def chosen(self, names):
        return [f for f in self.families if f.name in names]

    def common(self):
        return dict(H=self.history(), ROWS=ROWS, weights=extrapolation(self.history(), 1),
                    weights_by_four=extrapolation(self.history(), 4), families=self.families, coupled=self.chosen(self.plan.coupled),
                    local=self.chosen(self.plan.local), total=self.total, N=self.total, order=self.order(),
                    solver=self.plan.solver, matrix=self.plan.matrix, swept=self.plan.swept, timed=self.low.is_timed(), rotation=self.plan.rotation, orientation=self.spec.orientation,
                    band=self.plan.band, wrap=self.plan.wrap, extended=self.extended, plain_sums="plain-sums" in self.features)

    def tables(self):
        found = [f"static const double {self.M}_table_{name}[] = {{{', '.join(number(x) for x in values)}}};"
                 for name, values in self.low.used_tables.items()]
        graphs = {graph_name(t.over): t.over for t in [*self.effects, *self.observables]
                  if isinstance(t.over, Graph)}
        for name, over in graphs.items():
            found += graph_tables(self.M, name, over, self.plan.rotation or bool(self.tracers) or "tangent" in self.features)
        if self.plan.solver == "sparse":
            found += pattern_tables(self.M, self.plan.pattern)
        return found

    def step(self):
        slots = self.common()
        slots["gradient"] = self.sums(self.coupled_effects(), self.gradient_body("s->m", "s->g"))
        slots["blocks"] = self.sums(self.coupled_effects(), self.block_body)
        slots["products"] = self.sums(self.coupled_effects(), self.product_body)
        slots["matrix_size"] = self.matrix_size() if self.plan.coupled else "0"
        solver_text = ""
        if self.plan.coupled:
            solver_text = self.render("newton.c.j2", **slots)
            if self.plan.swept:
                solver_text += self.render("sweep.c.j2", **self.sweep_slots(), **slots)
        local_text = "".join(self.render("local.c.j2", f=f, linear=self.closed_form(f), solo=self.solo, tracers=self.tracers)
                             for f in self.chosen(self.plan.local))
        solo = self.render("solo.c.j2", f=self.families[0], kernels=self.solo_kernels(), local_text=local_text,
                           **slots) if self.solo else ""
        return self.render("step.c.j2", solo=solo, solver_text=solver_text, local_text=local_text,
                           needs_level=any(f.kind != "sphere" for f in self.families), **slots)

    def order(self) -> str:
        """Blocks in a row of the Newton matrix; of a sparse one, whose elimination is compiled in, a number."""
        return str(self.plan.pattern.size) if self.plan.solver == "sparse" else self.rows

    def sites_text(self):
        return "\n".join(self.render("family.c.j2", f=f, needs_blocks=self.has_frame(f), needs_newton=self.has_newton(f))
                         for f in self.families)

    def has_frame(self, f) -> bool:
        """Does the branch check or Newton need the blocks of this family?"""
        return f.name in self.plan.coupled or not self.closed_form(f)

    def has_newton(self, f) -> bool:
        return f.name in self.plan.coupled or not self.closed_form(f)

    def includes(self):
        names = ["smg_site.h", "smg_spin.h"]
        if self.plan.coupled:
            names += [f"smg_{self.plan.solver if self.plan.matrix else 'krylov'}.h", "smg_follow.h"]
        if any(not self.closed_form(f) for f in self.chosen(self.plan.local)):
            names.append("smg_follow.h")
        if self.solo:
            names.append("smg_vec.h")
        return list(dict.fromkeys([*names, *self.wide_includes()]))

    def source(self) -> str:
        kernels = "\n\n".join(t for k in [*self.effects, *self.observables] for t in k.text)
        body = dict(kernels=kernels, sites=self.sites_text(), sums=self.gathers(), wide=self.wide_text(), step=self.step(), tangent=self.tangent(),
                    interface=self.interface())
        self.low.close()    # what the kernels above have hoisted is computed here
        body |= dict(prepare=self.sizes_text() + "\n\n" + self.prepare_text(), clock=self.clock_text(),
                     tables=self.tables(), includes=self.includes())
        return without_uncalled(self.render("model.c.j2", **body, **self.banner()))


def extrapolation(rows: int, times: int) -> str:
    """Rows of extrapolation weights (-1)^j C(d+1, j+1) as a C initialiser, each weight `times` times."""
    weights = [[(-1) ** j * comb(d + 1, j + 1) for j in range(d + 1) for _ in range(times)] for d in range(rows)]
    return ", ".join("{" + ", ".join(map(str, row)) + "}" for row in weights)


def generate(spec: Spec, method: str = "spherical-midpoint", solver: str = "auto",
             amalgamate: bool = False, features=()) -> Files:
    """The C files of a model: {name}.h, {name}.c, {name}_abi.c; `.notes` says what was chosen.

    `amalgamate` puts the runtime into the two files that a program needs; features: names of
    `features.FEATURES`.
    """
    files = emitted(spec, choose(spec, method, solver), features)
    if amalgamate:
        files = inline_runtime(files, spec.name)
    return files


def generate_program(spec: Spec, method: str, solver: str, features=()) -> Files:
    """The same C for a caller that gives every value, as a library from the cache does: without `{name}_defaults`.

    It is one text for all values that lead to the same plan.
    """
    return emitted(program_of(spec), choose(spec, method, solver), features)


def emitted(spec: Spec, plan: Plan, features) -> Files:
    emitter = Emitter(spec, plan, features)
    source = emitter.source()
    name = spec.name
    files = Files({f"{name}.h": emitter.header(), f"{name}.c": source, f"{name}_abi.c": emitter.abi()})
    files.notes = {"method": plan.method, "solver": plan.solver, "reason": plan.reason,
                   "local": list(plan.local), "coupled": list(plan.coupled)}
    return files
